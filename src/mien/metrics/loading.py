"""From whatever holds a face in motion to a `FaceTrack`: animations, face capture, marker files, takes of a corpus."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from mien.animation.animation import Animation
from mien.capture.cleaning.impossible_motion import UNITS, guess_axes, guess_units
from mien.capture.cleaning.perspective import to_millimetres
from mien.capture.layouts import find_layout
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.corpus.readers import READERS, Found, Raw
from mien.corpus.recipes import load_recipe
from mien.corpus.recordings import Corpus
from mien.corpus.take import Take
from mien.formats.livelink import read_livelink
from mien.formats.native import read_native
from mien.metrics.face_track import FaceTrack

__all__ = ["Scorable", "face_track_of"]

Scorable = str | Path | Animation | Take | ChannelTrack | MarkerTrack | FaceTrack
"""What can be scored."""
_KINDS = (
    "an animation (.json), a Live Link Face recording (.csv), marker motion (.c3d, .csv, .npz), or a take of a corpus "
    "(CORPUS/NAME)"
)
_MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0}


def face_track_of(source: Scorable, fps: float | str | FrameRate | None = None) -> FaceTrack:
    """Bring anything that holds a face in motion to common ground.

    Parameters
    ----------
    source : path, Animation, Take, ChannelTrack, MarkerTrack or FaceTrack
        A path names a native animation (``.json``), a Live Link Face recording (``.csv``), marker motion (``.c3d``,
        ``.csv``, ``.npz``), or a take of a corpus (``CORPUS/NAME``). A MarkerTrack is as recorded, in millimetres.
    fps : float, str, FrameRate or None
        Frame rate of a ``.csv`` that does not say it itself.

    Raises
    ------
    InputError
        In one line, if it is none of these, or cannot be read.
    """
    if isinstance(source, FaceTrack):
        return source
    if isinstance(source, Animation):
        return _of_animation(source, "the animation")
    if isinstance(source, Take):
        return FaceTrack.of_take(source)
    if isinstance(source, ChannelTrack):
        return FaceTrack.of_channels(source)
    if isinstance(source, MarkerTrack):
        return FaceTrack.of_markers(source)
    return _of_path(Path(source), None if fps is None else FrameRate.of(fps))


def _of_animation(animation: Animation, name: str) -> FaceTrack:
    phones = animation.utterance.phones if animation.utterance.timing != "none" else None
    return FaceTrack.of_channels(animation.channels, name, phones)


def _of_path(path: Path, rate: FrameRate | None) -> FaceTrack:
    folder = path.parent.parent if path.parent.name == "motion" and path.suffix == ".npz" else path.parent
    if not path.is_dir() and (folder / "corpus.json").is_file() and (folder != path.parent or not path.exists()):
        name = path.stem if folder != path.parent else path.name
        return replace(FaceTrack.of_take(Corpus(folder).take(name)), name=str(path))
    if path.is_dir():
        what = "a corpus: name one of its takes, CORPUS/NAME" if (path / "corpus.json").is_file() else "a folder"
        raise InputError(f"{path} is {what}; expected {_KINDS}")
    if not path.exists():
        raise InputError(f"{path}: there is nothing of that name; expected {_KINDS}")
    if path.suffix.lower() == ".json":
        return _of_animation(read_native(path), str(path))
    return _of_recording(path, rate)


def _of_recording(path: Path, rate: FrameRate | None) -> FaceTrack:
    """Face capture or markers, by the readers of a corpus."""
    for reader in READERS:
        if reader.name in ("c3d", "livelink", "tracks") and reader.recognises(path):
            break
    else:
        raise InputError(f"{path}: expected {_KINDS}")
    if reader.name == "livelink":
        channels, _ = read_livelink(path, rate)
        if not len(channels):
            raise InputError(f"{path}: holds no frame of motion")
        return FaceTrack.of_channels(channels, str(path))
    recipe = load_recipe(reader.name)
    if rate is not None:
        recipe = recipe.with_changes(fps=rate.fps)
    return _of_raw(reader.read(Found(path.stem, path), recipe), str(path))


def _of_raw(raw: Raw, name: str) -> FaceTrack:
    layout = find_layout(raw.markers.names, name)
    if raw.units == "pixels":
        if layout.scale is None:
            raise InputError(f"{name}: layout {layout.name} has no [scale], so pixels cannot become millimetres")
        metric = to_millimetres(raw.markers, layout.scale[:2], layout.scale[2])
        return FaceTrack.of_markers(metric.track, name, layout, scale=True)
    factor = _MM.get(raw.units) or UNITS[guess_units(raw.markers) or "millimetres"]
    track = MarkerTrack(raw.markers.names, raw.markers.positions * factor, raw.markers.rate)
    axes = guess_axes(track, layout.motion_groups())
    turned = track.positions if axes is None else np.asarray(track.positions @ axes.T)
    return FaceTrack.of_markers(MarkerTrack(track.names, turned, track.rate), name, layout)
