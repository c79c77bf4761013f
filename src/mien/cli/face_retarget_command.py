"""``mien face retarget``: recorded markers on any face."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from mien.cli.foreign_face import add_face_option
from mien.cli.outputs import checked_face, finish
from mien.cli.view_options import add_view_options
from mien.core.errors import InputError

if TYPE_CHECKING:
    from mien.animation.animation import Animation

__all__ = ["add_command"]


def add_command(kinds: Any) -> None:
    """Add ``mien face retarget``."""
    parser = kinds.add_parser(
        "retarget", help="put recorded markers onto any face, and report what that face cannot show"
    )
    parser.add_argument(
        "motion", metavar="CORPUS|LINE.json", help="a corpus, or an animation: its markers or landmarks"
    )
    parser.add_argument("--take", metavar="NAME", help="the take of the corpus")
    parser.add_argument(
        "-o", "--output", metavar="OUT", required=True, help="file to write; its suffix picks the format"
    )
    parser.add_argument("--also", metavar="OUT2", action="append", default=[], help="one more output (repeatable)")
    add_face_option(parser)
    add_view_options(parser)
    parser.add_argument(
        "--method",
        choices=("least-squares", "rbf"),
        default="least-squares",
        help="bounded least squares on marker positions, or radial basis functions learned from pairs",
    )
    parser.add_argument("--pairs", metavar="X.npz", help="your own examples for rbf (docs/faces.md)")
    parser.add_argument("--rest", type=int, metavar="FRAME", help="frame at rest (default: the most neutral one)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the drawn examples (default 0)")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")
    parser.set_defaults(run=_retarget, deformer="blendshapes")


def _retarget(options: argparse.Namespace) -> int:
    from mien.face.foreign.drawn import drawn_face
    from mien.face.library import load_face
    from mien.face.model import Face
    from mien.motion.marker_motion import MarkerPairs, retarget

    if options.seed < 0:
        raise InputError(f"a seed is a whole number, 0 or more, not {options.seed}")
    face = checked_face(options, [options.motion, options.pairs])
    pairs = MarkerPairs.read(options.pairs) if options.pairs is not None else None
    recorded, layout, head = _recorded(options)
    assert recorded.markers is not None
    if isinstance(face, str):
        face = load_face(face)
    shown = face if isinstance(face, Face) else drawn_face(face).by_channels()
    moved = retarget(recorded.markers, layout, shown, options.method, pairs, options.rest, options.seed)
    if not options.quiet:
        print("\n".join(moved.lines()))
    return finish(_animated(recorded, moved.channels, head), face, options)


def _recorded(options: argparse.Namespace) -> tuple[Animation, str, Any]:
    """The markers with their sound, the name of their layout, and the head's motion or None."""
    if options.motion.lower().endswith(".json"):
        from mien.capture.layouts import find_layout
        from mien.formats.native import read_native

        if options.take is not None:
            raise InputError("--take is for a corpus")
        animation = read_native(options.motion)
        if animation.markers is None:
            from dataclasses import replace

            from mien.metrics.face_track import shown_landmarks

            animation = replace(animation, markers=shown_landmarks(animation.channels))  # as the default face moves
            assert animation.markers is not None
        return animation, find_layout(animation.markers.names, options.motion).name, None
    from importlib.metadata import version

    from mien.animation.animation import Animation, Provenance
    from mien.core.channels import ALL
    from mien.core.tracks import ChannelTrack
    from mien.core.utterance import Utterance
    from mien.corpus.recordings import Corpus
    from mien.text.score import Score

    corpus = Corpus(options.motion)
    if options.take is None:
        raise InputError(f"{options.motion} has {len(corpus)} takes: name one with --take, such as {corpus.names[0]}")
    take = corpus.take(options.take)
    heard = Utterance(take.text, take.audio, take.words, take.phones, "en-US", "aligned")
    still = ChannelTrack(ALL, [[0.0] * len(ALL)] * len(take.markers), take.markers.rate)
    made = Provenance(f"take {take.name} of {corpus.folder.name}, retargeted", options.seed, version("mien"))
    return Animation(still, take.markers, heard, Score(), made), take.layout, take.head


def _animated(recorded: Animation, channels: Any, head: Any) -> Animation:
    from dataclasses import replace

    from mien.core.channels import ALL
    from mien.core.tracks import ChannelTrack
    from mien.motion.marker_motion import head_channels

    if head is None:
        return replace(recorded, channels=channels)
    values = channels.values.copy()
    for name, angles in head_channels(head).items():
        values[:, ALL.index(name)] = angles
    return replace(recorded, channels=ChannelTrack(channels.names, values, channels.rate))
