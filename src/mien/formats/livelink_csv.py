"""``.csv``: the columns of Epic's Live Link Face app, as Unreal, Blender, Maya and MotionBuilder importers read them.

``docs/formats.md`` says where each fact about the format comes from. In short: a timecode ``HH:MM:SS:FF.mmm``, the
number 61, the 52 ARKit weights with a capital first letter, then yaw, pitch and roll of head, left eye and right eye
in radians about ARKit's axes of the face (x to the speaker's left, y up, z forward; right-handed):
yaw > 0 turns to the speaker's left, pitch > 0 looks down, roll > 0 tips towards the speaker's right shoulder.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.animation.animation import Animation
from mien.core.channels import ARKIT, HEAD, MUSCLES
from mien.core.errors import Note
from mien.core.files import replace_when_complete
from mien.core.timeline import timecode
from mien.core.tracks import ChannelTrack
from mien.formats.livelink import COLUMNS, HEAD_SIGNS, MOTION_COLUMNS, read_livelink

__all__ = ["COLUMNS", "EYE_DEGREES", "livelink_motion", "read_livelink", "write_livelink"]

EYE_DEGREES: dict[str, float] = {"Up": 18.0, "Down": 24.0, "In": 28.0, "Out": 30.0}
"""How far an eye turns at weight 1 of its eyeLook channels, degrees. Hand-made, not measured: a CSV knows no face."""

_INNER_BROWS = ("browInnerUpLeft", "browInnerUpRight")
_SIDES_APART = 0.02


def write_livelink(animation: Animation, path: str | Path) -> tuple[Note, ...]:
    """Write the channels of an animation as a Live Link Face recording.

    Numbers have eight decimals, as the app writes them. Lines end in a line feed.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    track = animation.channels
    values = livelink_motion(track)
    rows = [",".join(COLUMNS)]
    for frame, row in enumerate(values):
        numbers = ",".join(f"{round(number, 8) + 0.0:.8f}" for number in row)
        rows.append(f"{timecode(frame, track.rate)},{len(MOTION_COLUMNS)},{numbers}")
    with replace_when_complete(path) as unfinished:
        unfinished.write_text("\n".join(rows) + "\n", encoding="utf-8", newline="\n")
    notes = _dropped(track, Path(path).name)
    if track.rate.fraction.denominator == 1:
        return notes
    whole = math.ceil(track.rate.fraction)
    message = f"the timecode in {Path(path).name} counts {whole} frames per second: tell the importer {track.rate} fps"
    return (*notes, Note("note", message))


def _dropped(track: ChannelTrack, file: str) -> tuple[Note, ...]:
    """Which channels beyond ARKit's 52 moved; the tongue moves in all speech, so it alone is worth no note."""
    lost = [name for name in MUSCLES if name in track.names and name not in _INNER_BROWS]
    moved = [name for name in lost if track.channel(name).any()]
    apart = float(np.abs(np.subtract(*track.select(_INNER_BROWS).values.T)).max(initial=0.0))
    notes = []
    if apart > _SIDES_APART:
        notes.append(
            Note("note", f"{file} has one channel for both inner brows: sides up to {apart:.2f} apart are evened")
        )
    if moved:
        notes.append(Note("note", f"{file} has ARKit's 52 channels and cannot hold {', '.join(moved)}"))
    return tuple(notes)


def livelink_motion(track: ChannelTrack) -> NDArray[np.float64]:
    """The numbers of `mien.formats.livelink.MOTION_COLUMNS` for every frame, shape (frames, 61); missing channels are
    zero.
    """
    angles = np.radians(track.select(HEAD).values) * HEAD_SIGNS
    motion: NDArray[np.float64] = np.hstack([_arkit_weights(track), angles, _eye_angles(track)])
    return motion + 0.0  # no "-0.00000000"


def _arkit_weights(track: ChannelTrack) -> NDArray[np.float64]:
    """ARKit's 52; its one raising of the inner brows takes the mean of what the two sides do besides."""
    weights = track.select(ARKIT).values.copy()
    column = ARKIT.index("browInnerUp")
    weights[:, column] = np.clip(weights[:, column] + track.select(_INNER_BROWS).values.mean(axis=1), 0.0, 1.0)
    return weights


def _eye_angles(track: ChannelTrack) -> NDArray[np.float64]:
    """Yaw, pitch and roll of both eyes from the eyeLook weights, radians, shape (frames, 6)."""

    def look(direction: str, side: str) -> NDArray[np.float64]:
        weight = track.select([f"eyeLook{direction}{side}"]).values[:, 0]
        return np.asarray(weight * np.radians(EYE_DEGREES[direction]))

    angles = []
    for side, outward in (("Left", 1.0), ("Right", -1.0)):  # the left eye looks out towards +x, the right towards -x
        angles += [outward * (look("Out", side) - look("In", side)), look("Down", side) - look("Up", side)]
        angles += [np.zeros(len(track))]
    return np.stack(angles, axis=1)
