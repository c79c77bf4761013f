"""``.csv``: the columns of Epic's Live Link Face app, as Unreal, Blender, Maya and MotionBuilder importers read them.

``docs/formats.md`` says where each fact about the format comes from. In short: a timecode ``HH:MM:SS:FF.mmm``, the
number 61, the 52 ARKit weights with a capital first letter, then yaw, pitch and roll of head, left eye and right eye
in radians about ARKit's axes of the face (x to the speaker's left, y up, z forward; right-handed):
yaw > 0 turns to the speaker's left, pitch > 0 looks down, roll > 0 tips towards the speaker's right shoulder.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.animation import Animation
from mien.channels import ARKIT, HEAD
from mien.errors import InputError, Note
from mien.files import replace_when_complete
from mien.timeline import FrameRate, timecode
from mien.tracks import ChannelTrack

__all__ = ["COLUMNS", "EYE_DEGREES", "read_livelink", "write_livelink"]

_HEAD_COLUMNS = ("HeadYaw", "HeadPitch", "HeadRoll")
_EYE_COLUMNS = tuple(f"{side}Eye{angle}" for side in ("Left", "Right") for angle in ("Yaw", "Pitch", "Roll"))
_WEIGHT_COLUMNS = tuple(name[0].upper() + name[1:] for name in ARKIT)
_MOTION_COLUMNS = _WEIGHT_COLUMNS + _HEAD_COLUMNS + _EYE_COLUMNS
COLUMNS: tuple[str, ...] = ("Timecode", "BlendShapeCount", *_MOTION_COLUMNS)
"""The header line."""

EYE_DEGREES: dict[str, float] = {"Up": 25.0, "Down": 28.0, "In": 33.0, "Out": 33.0}
"""How far an eye turns at weight 1 of its eyeLook channels, degrees. Authored, not measured: a CSV knows no face."""

_HEAD_SIGNS = np.array([1.0, -1.0, -1.0])  # mien's yaw, pitch, roll against the app's
_TIMECODE = re.compile(r"(\d+):(\d+):(\d+)[:;](\d+)(?:\.(\d+))?")


def write_livelink(animation: Animation, path: str | Path) -> tuple[Note, ...]:
    """Write the channels of an animation as a Live Link Face recording.

    Numbers have eight decimals, as the app writes them. Lines end in a line feed.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    track = animation.channels
    values = np.hstack(
        [track.select(ARKIT).values, np.radians(track.select(HEAD).values) * _HEAD_SIGNS, _eye_angles(track)]
    )
    values += 0.0  # no "-0.00000000"
    rows = [",".join(COLUMNS)]
    for frame, row in enumerate(values):
        numbers = ",".join(f"{round(number, 8) + 0.0:.8f}" for number in row)
        rows.append(f"{timecode(frame, track.rate)},{len(_MOTION_COLUMNS)},{numbers}")
    with replace_when_complete(path) as unfinished:
        unfinished.write_text("\n".join(rows) + "\n", encoding="utf-8", newline="\n")
    if track.rate.fraction.denominator == 1:
        return ()
    whole = math.ceil(track.rate.fraction)
    message = f"the timecode in {Path(path).name} counts {whole} frames per second: tell the importer {track.rate} fps"
    return (Note("note", message),)


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


def read_livelink(path: str | Path, rate: FrameRate | None = None) -> ChannelTrack:
    """Read a recording of Live Link Face, or a file of `write_livelink`.

    Parameters
    ----------
    path : path-like
    rate : FrameRate, optional
        Needed if the recording is shorter than a second: the file itself does not say it. Otherwise the number of
        frames that the timecode counts in a second is taken, so 29.97 reads as 30 unless it is given here.

    Returns
    -------
    ChannelTrack
        The channels of `mien.channels.ARKIT` and `mien.channels.HEAD`, head in degrees. The eyes' angles say the same
        as the eyeLook weights and are not kept. A frame in which the app lost the face (count 0, no numbers) repeats
        the frame ahead of it.

    Raises
    ------
    InputError
        If the file is missing, lacks a column, holds other things than numbers, or its rate cannot be known.
    """
    path = Path(path)
    try:
        with path.open(encoding="utf-8-sig", newline="") as lines:
            rows = [row for row in csv.reader(lines) if row]
    except OSError as problem:
        raise InputError(f"cannot read {path}: {problem.strerror}") from problem
    except (UnicodeDecodeError, csv.Error) as problem:
        raise InputError(f"{path} is not a Live Link Face CSV: {problem}") from problem
    wanted = ("Timecode", *_WEIGHT_COLUMNS, *_HEAD_COLUMNS)
    header = [name.strip().lower() for name in rows[0]] if rows else []
    missing = [name for name in wanted if name.lower() not in header]
    if missing:
        raise InputError(f"{path} is not a Live Link Face CSV: it lacks {len(missing)} columns, first {missing[0]!r}")
    places = [header.index(name.lower()) for name in wanted]
    motion = _numbers(path, rows, places[1:])
    motion[:, len(ARKIT) :] = np.degrees(motion[:, len(ARKIT) :] * _HEAD_SIGNS)
    rate = rate or _counted_rate(path, [row[places[0]] for row in rows[1:]])
    return ChannelTrack(ARKIT + HEAD, motion, rate)


def _numbers(path: Path, rows: Sequence[Sequence[str]], places: Sequence[int]) -> NDArray[np.float64]:
    motion = np.zeros((len(rows) - 1, len(places)))
    for frame, row in enumerate(rows[1:]):
        if len(row) <= max(places):
            if len(row) < 2 or row[1].strip() != "0":
                raise InputError(f"{path}, line {frame + 2}: expected {len(rows[0])} columns, got {len(row)}")
            motion[frame] = motion[frame - 1] if frame else 0.0
            continue
        try:
            motion[frame] = [float(row[place]) for place in places]
        except ValueError as problem:
            raise InputError(f"{path}, line {frame + 2}: expected numbers: {problem}") from problem
    return motion


def _counted_rate(path: Path, timecodes: Sequence[str]) -> FrameRate:
    counts = []
    for line, code in enumerate(timecodes, start=2):
        match = _TIMECODE.fullmatch(code.strip())
        if match is None:
            raise InputError(f"{path}, line {line}: expected a timecode HH:MM:SS:FF.mmm, got {code!r}")
        counts.append(int(match[4]))
    ends = [before + 1 for before, after in pairwise(counts) if after < before]
    if not ends:
        raise InputError(f"{path} is shorter than a second, so its frame rate is not in it: give the rate")
    return FrameRate.of(max(ends))
