"""The columns of Epic's Live Link Face CSV, and reading it; `mien.formats.livelink_csv` writes it.

It lies below the corpus, which reads it too.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.core.channels import ARKIT, HEAD
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack

__all__ = ["COLUMNS", "HEAD_SIGNS", "MOTION_COLUMNS", "read_livelink"]

_HEAD_COLUMNS = ("HeadYaw", "HeadPitch", "HeadRoll")
_EYE_COLUMNS = tuple(f"{side}Eye{angle}" for side in ("Left", "Right") for angle in ("Yaw", "Pitch", "Roll"))
_WEIGHT_COLUMNS = tuple(name[0].upper() + name[1:] for name in ARKIT)
MOTION_COLUMNS: tuple[str, ...] = _WEIGHT_COLUMNS + _HEAD_COLUMNS + _EYE_COLUMNS
"""52 weights, then angles in radians."""
COLUMNS: tuple[str, ...] = ("Timecode", "BlendShapeCount", *MOTION_COLUMNS)
"""The header line."""
HEAD_SIGNS = np.array([1.0, -1.0, -1.0])
"""mien's yaw, pitch, roll against the app's."""
_TIMECODE = re.compile(r"(\d+):(\d+):(\d+)[:;](\d+)(?:\.(\d+))?")


def read_livelink(path: str | Path, rate: FrameRate | None = None) -> ChannelTrack:
    """Read a recording of Live Link Face, or a file of `mien.formats.livelink_csv.write_livelink`.

    Parameters
    ----------
    path : path-like
    rate : FrameRate, optional
        Needed if the recording is shorter than a second: the file itself does not say it. Otherwise the number of
        frames that the timecode counts in a second is taken, so 29.97 reads as 30 unless it is given here.

    Returns
    -------
    ChannelTrack
        The channels of `mien.core.channels.ARKIT` and `mien.core.channels.HEAD`, head in degrees. The eyes' angles say
        the same
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
    motion[:, len(ARKIT) :] = np.degrees(motion[:, len(ARKIT) :] * HEAD_SIGNS)
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
