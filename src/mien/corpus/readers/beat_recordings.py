"""ARKit weights as the BEAT corpus keeps them: JSON with names and timed frames, sound and TextGrid beside."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.capture.layouts import load_layout
from mien.core.channels import ARKIT
from mien.core.errors import InputError
from mien.core.plain_text import parsed_json, read_plain_text
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.corpus.readers.livelink_recordings import carried_markers
from mien.corpus.readers.raw_recordings import Found, Raw, Reader
from mien.corpus.readers.recording_files import SOUND, TRANSCRIPTS, Beside, listed
from mien.corpus.recipes import Recipe
from mien.formats.sound_files import read_audio

__all__ = ["READER"]

_HEAD = 400  # bytes in which a file shows what it is


def _is_beat(path: Path) -> bool:
    if path.suffix.lower() != ".json":
        return False
    with path.open("rb") as handle:
        start = handle.read(_HEAD)
    return b'"names"' in start and any(name in start for name in (b"BlinkLeft", b"browDown", b"BrowDown"))


def _find(source: Path) -> list[Found]:
    beside = Beside(source)
    files = [path for path in listed(source) if _is_beat(path)]
    return [Found(p.stem, p, beside.near(p, SOUND), beside.near(p, TRANSCRIPTS)) for p in files]


def _read(found: Found, recipe: Recipe) -> Raw:
    content: dict[str, Any] = parsed_json(read_plain_text(found.motion, "a BEAT recording")[0])
    names = [_channel(name) for name in content["names"]]
    frames = content["frames"]
    if len(frames) < 2:
        raise InputError(f"{found.motion}: holds {len(frames)} frames of motion, expected two or more")
    weights = np.array([frame["weights"] for frame in frames], np.float64)
    times = np.array([frame["time"] for frame in frames], np.float64)
    if weights.shape != (len(times), len(names)) or not (np.diff(times) > 0).all():
        raise InputError(f"{found.motion}: expected {len(names)} weights in each frame, and times that rise")
    rate = FrameRate.of(recipe.fps or round(float((len(times) - 1) / (times[-1] - times[0]))))
    track = ChannelTrack(names, _evenly(weights, times, rate), rate).select(ARKIT)
    audio, notes = read_audio(found.sound) if found.sound else (None, ())
    layout = load_layout(recipe.layout or "face-102")
    return Raw(carried_markers(track, layout), "mm", audio, track, None, notes)


def _channel(name: str) -> str:
    """ARKit's spelling of a name: some files write ``EyeBlinkLeft``."""
    return name[:1].lower() + name[1:]


def _evenly(weights: NDArray[np.float64], times: NDArray[np.float64], rate: FrameRate) -> NDArray[np.float64]:
    """Weights at a steady rate from the start of the sound, shape (frames, channels), 0 to 1."""
    steady = rate.times(int(times[-1] * rate.fps) + 1)
    columns = [np.interp(steady, times, column) for column in weights.T]
    return np.asarray(np.clip(np.stack(columns, axis=1), 0.0, 1.0))


READER = Reader(
    "beat",
    "JSON files with names and frames of ARKit weights (BEAT), with sound and TextGrid of the same name",
    lambda source: any(_is_beat(path) for path in listed(source)),
    _find,
    _read,
)
