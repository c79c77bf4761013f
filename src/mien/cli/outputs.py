"""What commands write: faces and outputs checked before any work is done, files written, what happened told."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from mien.cli.foreign_face import ShownFace, checked_foreign_face, glb_style
from mien.cli.progress_bar import progress_bar
from mien.cli.stopping import put_off
from mien.cli.view_options import VIEW_OPTIONS, view_of
from mien.core.errors import InputError, Note

if TYPE_CHECKING:
    from mien.animation.animation import Animation

__all__ = ["checked_face", "finish", "refuse_same_file", "tell", "unused_options"]

_WITHOUT_FRAMES = (".wav", ".textgrid")
_OF_FRAMES: dict[str, str | None] = {
    "fps": "30", "performer": "default", "speech_model": None, "prosody": "0.5", "alive": "all",
}  # fmt: skip
"""Options that change frames only, and their usual values."""
_OF_FACES: dict[str, str | None] = {"emotion": None, "effort": None}
"""Options that change frames, and a voice that is made for them."""


def checked_face(options: argparse.Namespace, inputs: Sequence[str | None]) -> ShownFace:
    """The face to show; an output or a face that cannot be had is refused before any work is done."""
    from mien.face.library import is_named_face, load_face
    from mien.formats.registry import check_output

    view = view_of(options)
    outputs = [check_output(path, view) for path in (options.output, *options.also)]
    glb_style(options)
    foreign = not is_named_face(options.face) and _is_foreign(options.face)
    refuse_same_file(outputs, [*inputs, *([options.face, options.names] if foreign else [])])
    arms = getattr(options, "arms", "lower")  # only what performs on avatars asks
    if foreign:
        return checked_foreign_face(options.face, outputs, options.deformer, options.names, arms)
    if arms == "keep":
        raise InputError(f"--arms is for a face in .glb, .vrm or .gltf, not for {options.face!r}")
    if options.names is not None:
        raise InputError(f"--names is for a face in .glb, .vrm or .gltf, not for {options.face!r}")
    if is_named_face(options.face) and options.deformer == "blendshapes":
        return str(options.face)  # read when something shows it
    face = load_face(options.face)
    if options.deformer != "blendshapes":
        from mien.face.deformers import deformed_by

        return deformed_by(face, options.deformer)
    if not any(part.targets for part in face.parts):
        raise InputError(f"{options.face} has no morph targets that could move it: give --deformer X.tree")
    return face


def _is_foreign(face: str) -> bool:
    from mien.face.foreign.gltf_document import is_gltf

    return is_gltf(face)


def refuse_same_file(outputs: Sequence[Path], inputs: Sequence[str | None]) -> None:
    """Refuse an output that would overwrite an input, or another output."""
    read = {Path(path).resolve() for path in inputs if path and len(path) < 1000}
    written: set[Path] = set()
    for path in outputs:
        real = path.resolve()
        if real in read:
            raise InputError(f"{path} is both read and written: give the output another name")
        if real in written:
            raise InputError(f"{path} is given twice as an output: give each a name of its own")
        written.add(real)


def finish(animation: Animation, face: ShownFace, options: argparse.Namespace) -> int:
    """Write an animation to all outputs asked for, and tell what happened; the exit code."""
    from mien.api import calls as api

    tell(animation.notes, options.quiet)
    outputs = _written(options, face)
    with progress_bar("drawing", " frames", options.quiet) as show, put_off() as obey:

        def progress(done: int, total: int) -> None:
            obey()
            show(done, total)

        view, glb = view_of(options), glb_style(options)
        notes = api.save(animation, *outputs, face=face, view=view, progress=progress, glb=glb)
    tell((*notes, *unused_options(options, outputs)), options.quiet)
    if not options.quiet:
        seconds = animation.utterance.duration
        print(f"{', '.join(outputs)}: {seconds:.2f} s at {animation.rate} frames/s")
    return 0


def _written(options: argparse.Namespace, face: ShownFace) -> tuple[str, ...]:
    """The outputs, less those for which a face would have to be drawn that cannot be (that was told at the start)."""
    outputs = (options.output, *options.also)
    if isinstance(face, str):
        return outputs
    from mien.face.foreign.drawn import not_drawn
    from mien.face.foreign.recognition import ForeignFace
    from mien.formats.registry import draws_pictures

    if isinstance(face, ForeignFace) and not_drawn(face):
        return tuple(path for path in outputs if not draws_pictures(path))
    return outputs


def unused_options(options: argparse.Namespace, outputs: Sequence[str]) -> list[Note]:
    """Notes on options that none of the formats written has a use for."""
    from mien.formats.registry import draws_pictures, shows_face

    suffixes = ", ".join(dict.fromkeys(Path(path).suffix for path in outputs))
    unused: dict[str, str | None] = {}
    if not any(shows_face(path) for path in outputs):
        unused |= {"face": "default", "deformer": "blendshapes"}
    if not any(map(draws_pictures, outputs)):
        unused |= dict.fromkeys(VIEW_OPTIONS)
    if all(Path(path).suffix.lower() in _WITHOUT_FRAMES for path in outputs):
        unused |= _OF_FRAMES if hasattr(options, "voice_emotion") else _OF_FRAMES | _OF_FACES
    asked = {name: value for name in unused if (value := getattr(options, name, None)) not in (unused[name], None)}
    given = [f"--{name.replace('_', '-')} {' '.join(v) if isinstance(v, list) else v}" for name, v in asked.items()]
    return [Note("warning", f"{option} has no effect on {suffixes}") for option in given]


def tell(notes: Iterable[Note], quiet: bool) -> None:
    """Print notes to the user, unless quiet is wanted."""
    if not quiet:
        for note in notes:
            print(f"mien: {note.kind}: {note.message}", file=sys.stderr)
