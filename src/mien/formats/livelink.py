"""``.csv``: the columns of Epic's Live Link Face app, as Unreal, Blender, Maya and MotionBuilder importers read them.

``docs/formats.md`` says where each fact about the format comes from. In short: a timecode ``HH:MM:SS:FF.mmm``, the
number 61, the 52 ARKit weights with a capital first letter, then yaw, pitch and roll of head, left eye and right eye
in radians about ARKit's axes of the face (x to the speaker's left, y up, z forward; right-handed):
yaw > 0 turns to the speaker's left, pitch > 0 looks down, roll > 0 tips towards the speaker's right shoulder.

When reading, time comes from the timecode: hours, minutes, seconds, ticks (and thousandths of a tick). From it follow
the frame rate (29.97 and 59.94 too, drop-frame counting included) and the frames that are missing. Other programs write
seconds instead (``12.0333``, ``00:00:12.033``).
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.animation.animation import Animation
from mien.core.border import reading
from mien.core.channels import ARKIT, HEAD, MUSCLES
from mien.core.errors import InputError, Note
from mien.core.files import replace_when_complete
from mien.core.limits import check_size
from mien.core.table_rows import read_rows
from mien.core.timeline import FrameRate, timecode
from mien.core.tracks import ChannelTrack

__all__ = [
    "COLUMNS", "EYE_DEGREES", "HEAD_SIGNS", "MOTION_COLUMNS", "arkit_weights", "beyond_arkit", "first_timecode",
    "livelink_motion", "read_livelink", "write_livelink",
]  # fmt: skip

_HEAD_COLUMNS = ("HeadYaw", "HeadPitch", "HeadRoll")
_EYE_COLUMNS = tuple(f"{side}Eye{angle}" for side in ("Left", "Right") for angle in ("Yaw", "Pitch", "Roll"))
_WEIGHT_COLUMNS = tuple(name[0].upper() + name[1:] for name in ARKIT)
MOTION_COLUMNS: tuple[str, ...] = _WEIGHT_COLUMNS + _HEAD_COLUMNS + _EYE_COLUMNS
"""52 weights, then angles in radians."""
COLUMNS: tuple[str, ...] = ("Timecode", "BlendShapeCount", *MOTION_COLUMNS)
"""The header line."""
HEAD_SIGNS = np.array([1.0, -1.0, -1.0])
"""mien's yaw, pitch, roll against the app's."""
EYE_DEGREES: dict[str, float] = {"Up": 18.0, "Down": 35.0, "In": 28.0, "Out": 30.0}
"""How far an eye turns at weight 1 of its eyeLook channels, degrees: down as the app's recordings have it, the others
hand-made, since a CSV knows no face."""

_INNER_BROWS = ("browInnerUpLeft", "browInnerUpRight")
_SIDES_APART = 0.02
_BLOCK = 4096  # frames

_TIMECODE = re.compile(r"(\d{1,3}):(\d{1,2}):(\d{1,2})([:;])(\d{1,3})(?:[.,](\d{1,6}))?", re.ASCII)
_CLOCK = re.compile(r"(?:(\d{1,3}):(\d{1,2}):)?(\d{1,9})[.,](\d{1,9})", re.ASCII)
_THOUSANDTHS = 1000
_SIDE = re.compile(r"[_.]?(left|right|[lr])$")
_COUNT_COLUMN = "blendshapecount"
_PLAIN_NUMBER = re.compile(r"[-+]?\d{1,6}(?:\.\d{0,20})?", re.ASCII)
_DAY = 24 * 3600
_USUAL = 30  # frames a second of what mien writes and of the app
_LONGEST_GAP = 600.0  # seconds; more is another recording
_FEWEST_WEIGHTS = 26  # of 52: with less it is another kind of table
_NEEDED = ("Timecode", "JawOpen")
_MOST_WEIGHT = 1.5  # above it weights are percent
_MOST_RADIANS = 1.6  # no head turns further; above it angles are degrees

Floats = NDArray[np.float64]


def read_livelink(path: str | Path, rate: FrameRate | None = None) -> tuple[ChannelTrack, tuple[Note, ...]]:
    """Read a recording of Live Link Face, or a file of `write_livelink`.

    Columns may be separated by commas, semicolons or tabs; numbers may have decimal commas (between commas in quotes)
    and percent signs; sides may be ``_L`` and ``_R``. Weights in percent and angles in degrees are recognised by their
    size. Frames that are missing by the timecode, frames in which the app lost the face (count 0, no numbers) and
    empty cells are filled in a straight line between their neighbours; a column without numbers is 0.

    Parameters
    ----------
    path : path-like
    rate : FrameRate, optional
        A recording shorter than a second does not say it (30 or 60 are then assumed, with a note). It overrides what
        the timecode says.

    Returns
    -------
    track : ChannelTrack
        The channels of `mien.channels.ARKIT` and `mien.channels.HEAD`, head in degrees. The eyes' angles say the same
        as the eyeLook weights and are not kept.
    notes : tuple of Note
        Whatever was filled, converted or left out.

    Raises
    ------
    InputError
        If the file is missing, lacks the columns, holds other things than numbers (file, line and column are named),
        or its rate cannot be known.
    """
    path = Path(path)
    with reading(path, "a Live Link Face CSV"):
        table = _table(path)
        motion = _in_our_units(path, _numbers(path, table), table)
        codes = [row[table.places[0]] if len(row) > table.places[0] else "" for row in table.rows]
        rate, places = _times(path, codes, table.lines, rate, table.notes)
        motion = _filled(path, motion, places, rate, table.notes)
        return ChannelTrack(ARKIT + HEAD, motion, rate), tuple(table.notes)


@dataclass
class _Table:
    """Rows as text, the lines where they stand, and the column of each wanted name (-1: none)."""

    rows: list[list[str]]
    lines: list[int]
    header: list[str]
    places: list[int]
    count: int
    notes: list[Note] = field(default_factory=list)


def _table(path: Path) -> _Table:
    read = read_rows(path, "a Live Link Face CSV")
    numbered = [(line, row) for line, row in read.rows if not row[0].startswith("#")]
    header = [_column_name(name) for name in numbered[0][1]] if numbered else []
    wanted = ("Timecode", *_WEIGHT_COLUMNS, *_HEAD_COLUMNS)
    missing = [name for name in wanted if name.lower() not in header]
    weights = len(set(_WEIGHT_COLUMNS) - set(missing))
    if weights < _FEWEST_WEIGHTS or any(name in missing for name in _NEEDED):
        raise InputError(f"{path} is not a Live Link Face CSV: it lacks {len(missing)} columns, first {missing[0]!r}")
    if len(numbered) == 1:
        raise InputError(f"{path}: has a header and no frames")
    rows = [row for _, row in numbered[1:]]
    places = [header.index(name.lower()) if name.lower() in header else -1 for name in wanted]
    for name, place in zip(wanted[1:], places[1:], strict=True):
        if place >= 0 and not any(place < len(row) and row[place] for row in rows):
            missing.append(name)
    count = header.index(_COUNT_COLUMN) if _COUNT_COLUMN in header else -1
    places = [-1 if name in missing else place for name, place in zip(wanted, places, strict=True)]
    if len(missing) == len(wanted) - 1 and "Timecode" not in missing:
        raise InputError(f"{path}: the face was lost in all {len(rows)} frames: there is no motion in it")
    table = _Table(rows, [number for number, _ in numbered[1:]], numbered[0][1], places, count, list(read.notes))
    if missing:
        table.notes.append(Note("warning", f"{path.name} has no {', '.join(missing)}: taken as 0"))
    return table


def _column_name(name: str) -> str:
    """A name in small letters, its side written out: "EyeBlink_L" is "eyeblinkleft"."""
    name = name.lower()
    side = _SIDE.search(name)
    if side is None or name[side.start()] not in "_.":
        return name
    return name[: side.start()] + ("left" if side[1][0] == "l" else "right")


def _numbers(path: Path, table: _Table) -> Floats:
    """Values as they stand, shape (frames, columns); NaN where there is none."""
    places = np.array(table.places[1:])
    there = [(column, int(place)) for column, place in enumerate(places) if place >= 0]
    motion = np.full((len(table.rows), len(places)), np.nan)
    motion[:, places < 0] = 0.0
    lost = holes = 0
    for frame, (line, row) in enumerate(zip(table.lines, table.rows, strict=True)):
        said_lost = 0 <= table.count < len(row) and row[table.count] == "0"
        given = [(column, place) for column, place in there if place < len(row) and row[place]]
        if not said_lost and 2 < len(row) <= int(places.max()):
            raise InputError(f"{path}, line {line}: expected {len(table.header)} columns, got {len(row)}")
        if said_lost or not given:
            motion[frame] = np.nan
            lost += 1
            continue
        holes += len(given) < len(there)
        for column, place in given:
            motion[frame, column] = _number(path, line, table, place, row[place])
    if lost == len(motion):
        raise InputError(f"{path}: the face was lost in all {lost} frames: there is no motion in it")
    if lost:
        table.notes.append(Note("warning", f"{path.name}: the face was lost in {lost} frames: filled"))
    if holes:
        table.notes.append(Note("warning", f"{path.name}: {holes} frames have empty cells: filled"))
    return motion


def _number(path: Path, line: int, table: _Table, place: int, cell: str) -> float:
    try:
        number = float(cell.removesuffix("%").replace(",", "."))
        if not math.isfinite(number):
            raise ValueError
    except ValueError as problem:
        column = f"column {place + 1} ({table.header[place]})"
        raise InputError(f"{path}, line {line}, {column}: expected numbers, got {cell[:40]!r}") from problem
    return number


def _in_our_units(path: Path, motion: Floats, table: _Table) -> Floats:
    """Weights 0..1, head in mien's degrees."""
    weights, angles = motion[:, : len(ARKIT)], motion[:, len(ARKIT) :]
    most = float(np.nanmax(weights, initial=0.0))
    if most > _MOST_WEIGHT:
        if most > 100 * _MOST_WEIGHT:
            raise InputError(f"{path}: weights up to {most:g}: expected 0 to 1, or percent")
        table.notes.append(Note("note", f"{path.name} has weights up to {most:g}: read as percent"))
        weights = weights / 100
    outside = ((weights < -1e-6) | (weights > 1 + 1e-6)).any(axis=1)
    if outside.any():
        least, most = float(np.nanmin(weights)), float(np.nanmax(weights))
        table.notes.append(
            Note(
                "warning",
                f"{path.name} has weights from {least:.2f} to {most:.2f} in {int(outside.sum())} frames: "
                "brought to 0..1",
            )
        )
    widest = max(float(np.nanmax(np.abs(angles), initial=0.0)), _widest_eye(table))
    if widest > _MOST_RADIANS:
        table.notes.append(Note("note", f"{path.name} has angles up to {widest:.0f}: read as degrees"))
    else:
        angles = np.degrees(angles)
    return np.hstack([np.clip(weights, 0.0, 1.0), angles * HEAD_SIGNS])


def _widest_eye(table: _Table) -> float:
    """The eyes turn far even where the head is still: they show the unit of angles."""
    eyes = {name.lower() for name in _EYE_COLUMNS}
    places = [place for place, name in enumerate(table.header) if _column_name(name) in eyes]
    cells = (row[place].replace(",", ".") for row in table.rows for place in places if place < len(row))
    return max((abs(float(cell)) for cell in cells if _PLAIN_NUMBER.fullmatch(cell)), default=0.0)


# ------------------------------------------------------------------ time


@dataclass(frozen=True)
class _Code:
    """A timecode: whole seconds since midnight, and ticks within the second."""

    seconds: int
    ticks: float
    dropping: bool


def _times(
    path: Path, texts: Sequence[str], lines: Sequence[int], rate: FrameRate | None, notes: list[Note]
) -> tuple[FrameRate, NDArray[np.int64]]:
    """The rate, and the number of each row's frame, counted from the first row."""
    codes = [_code(text) or _clock(text) for text in texts]
    unread = next((i for i, code in enumerate(codes) if code is None), None)
    if unread is not None:
        if rate is None:
            raise InputError(
                f"{path}, line {lines[unread]}: expected a timecode HH:MM:SS:FF.mmm or seconds, got "
                f"{texts[unread][:40]!r}: give the rate (--fps)"
            )
        notes.append(Note("note", f"{path.name}, line {lines[unread]}: no timecode: its frames are taken as unbroken"))
        return rate, np.arange(len(texts))
    read = [code for code in codes if code is not None]
    base = _THOUSANDTHS if all(_code(text) is None for text in texts) else _ticks_in_a_second(read)
    if base is None:
        most = max(code.ticks + 1 for code in read)
        if rate is None:
            rate = FrameRate.of(_USUAL if most <= _USUAL else 2 * _USUAL)
            message = (
                f"{path.name} is shorter than a second, so its frame rate is not in it: {rate} frames/s are assumed"
            )
            notes.append(Note("note", message))
        base = math.ceil(max(rate.fps, most))
    dropping = any(code.dropping for code in read) or _drops(read, base)
    now = np.array([_tick(code, base, dropping) for code in read])
    wraps = np.concatenate([[0], np.cumsum(np.diff(now) < -_DAY * base / 2)])
    now = now + wraps * _DAY * base
    back = np.flatnonzero(np.diff(now) < 0)
    if len(back):
        line = lines[int(back[0]) + 1]
        raise InputError(f"{path}, line {line}: the timecode goes back to {texts[int(back[0]) + 1]!r}: split the file")
    step = _usual_step(now)
    ticks_per_second = base * 1000 / 1001 if dropping else base
    if rate is None:
        rate = _named_rate(ticks_per_second / step)
    return rate, np.round((now - now[0]) / step).astype(np.int64)


def _code(text: str) -> _Code | None:
    match = _TIMECODE.fullmatch(text.strip())
    if match is None:
        return None
    hours, minutes, seconds, mark, ticks, part = match.groups()
    whole = (int(hours) * 60 + int(minutes)) * 60 + int(seconds)
    return _Code(whole, int(ticks) + (float(f"0.{part}") if part else 0.0), mark == ";")


def _clock(text: str) -> _Code | None:
    """Seconds, with or without hours and minutes, in thousandths."""
    match = _CLOCK.fullmatch(text.strip())
    if match is None:
        return None
    hours, minutes, seconds, part = match.groups()
    whole = (int(hours or 0) * 60 + int(minutes or 0)) * 60 + int(seconds)
    return _Code(whole, float(f"0.{part}") * _THOUSANDTHS, dropping=False)


def _ticks_in_a_second(codes: Sequence[_Code]) -> int | None:
    """How many ticks the timecode counts in a second, as the changes of the second show; None if there is none."""
    pairs = list(pairwise(codes))
    steps = [b.ticks - a.ticks for a, b in pairs if a.seconds == b.seconds and b.ticks > a.ticks]
    step = float(np.median(steps)) if steps else 1.0
    changes = [a.ticks + step - b.ticks for a, b in pairs if (b.seconds - a.seconds) % _DAY == 1]
    if not changes:
        return None
    least = max(int(code.ticks) for code in codes) + 1
    kinds, counts = np.unique(np.round(changes), return_counts=True)
    return max(least, int(kinds[np.argmax(counts)]))


def _drops(codes: Sequence[_Code], base: int) -> bool:
    """Whether the first ticks of a minute are left out, as drop-frame timecode does (but each tenth minute)."""
    left = 2 * round(base / 30)
    if base % 30 or not left:
        return False
    firsts = [
        b.ticks
        for a, b in pairwise(codes)
        if b.seconds // 60 != a.seconds // 60
        and b.seconds % 60 == 0
        and b.seconds // 60 % 10
        and b.seconds - a.seconds == 1
    ]
    return bool(firsts) and all(left <= first < left + 1 for first in firsts)


def _tick(code: _Code, base: int, dropping: bool) -> float:
    """Ticks since midnight."""
    ticks = code.seconds * base + code.ticks
    if dropping:
        minutes = code.seconds // 60
        ticks -= 2 * round(base / 30) * (minutes - minutes // 10)
    return ticks


def _usual_step(now: Floats) -> float:
    """Ticks from frame to frame where none is missing."""
    steps = np.diff(now)
    steps = steps[steps > 0]
    if not len(steps):
        return 1.0
    middle = float(np.median(steps))
    return float(steps[np.abs(steps - middle) < 0.5 * middle].mean())


def _named_rate(fps: float) -> FrameRate:
    """A whole rate, or one of television's, if it is one but for jitter."""
    for known in (float(round(fps)), *(whole * 1000 / 1001 for whole in (24, 30, 48, 60, 120))):
        if known and abs(fps - known) < 3e-4 * known:
            return FrameRate.of(known)
    return FrameRate.of(round(fps, 2))


def _filled(path: Path, motion: Floats, places: NDArray[np.int64], rate: FrameRate, notes: list[Note]) -> Floats:
    """One row for each frame; what is missing lies on a straight line between its neighbours."""
    if not len(motion):
        return motion
    steps = np.diff(places)
    longest = float(steps.max(initial=0) / rate.fps)
    if longest > _LONGEST_GAP:
        raise InputError(f"{path}: {longest:.0f} s are missing in one place by the timecode: split the file there")
    check_size("frames", int(places[-1]) + 1, path)
    if int((steps == 0).sum()):
        notes.append(Note("note", f"{path.name}: {int((steps == 0).sum())} frames share a timecode: the last is used"))
    if int((steps > 1).sum()):
        at = int(places[int(np.argmax(steps))] / rate.fps * 100) / 100
        missing = int((steps[steps > 1] - 1).sum())
        notes.append(
            Note(
                "warning",
                f"{path.name}: {missing} frames are missing by the timecode, at most {longest:.2f} s in one place "
                f"(at {at:.2f} s): filled between their neighbours",
            )
        )
    every = np.arange(int(places[-1]) + 1)
    return np.stack([_along(every, places, column) for column in motion.T], axis=1)


def _along(every: NDArray[np.int64], places: NDArray[np.int64], column: Floats) -> Floats:
    """A column at every frame; of several values for one frame the last is used."""
    seen = ~np.isnan(column)
    frames, last = np.unique(places[seen][::-1], return_index=True)
    return np.interp(every, frames, column[seen][::-1][last])


# ------------------------------------------------------------------ writing


def write_livelink(animation: Animation, path: str | Path) -> tuple[Note, ...]:
    """Write the channels of an animation as a Live Link Face recording.

    It begins at the animation's own timecode, where it has one. Numbers have eight decimals, as the app writes them.
    Lines end in a line feed.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    track = animation.channels
    start = _start(animation.timecode, track.rate)
    with replace_when_complete(path) as unfinished, unfinished.open("w", encoding="utf-8", newline="\n") as file:
        file.write(",".join(COLUMNS) + "\n")
        for first in range(0, len(track), _BLOCK):  # the text of an hour would take more memory than its motion
            part = ChannelTrack(track.names, track.values[first : first + _BLOCK], track.rate)
            for frame, row in enumerate(livelink_motion(part), first):
                numbers = ",".join(f"{round(number, 8) + 0.0:.8f}" for number in row)
                file.write(f"{timecode(frame, track.rate, start)},{len(MOTION_COLUMNS)},{numbers}\n")
    notes = beyond_arkit(track, Path(path).name)
    if track.rate.fraction.denominator == 1:
        return notes
    told = f"{Path(path).name} has {track.rate} frames per second: tell importers that count frames (docs/formats.md)"
    return (*notes, Note("note", told))


def _start(code: str, rate: FrameRate) -> Fraction:
    """The timecode of the first frame as ticks since midnight."""
    read = _code(code)
    return Fraction(0) if read is None else read.seconds * math.ceil(rate.fraction) + Fraction(str(read.ticks))


def first_timecode(path: str | Path) -> str:
    """The timecode with which a recording begins; "" if it has none."""
    with reading(Path(path), "a Live Link Face CSV"):
        table = _table(Path(path))
        first = table.rows[0][table.places[0]].strip() if table.rows and table.rows[0] else ""
        return first if _code(first) is not None else ""


def beyond_arkit(track: ChannelTrack, file: str) -> tuple[Note, ...]:
    """Which channels beyond ARKit's 52 moved; the tongue moves in all speech, so it alone is worth no note."""
    lost = [name for name in MUSCLES if name in track.names and name not in _INNER_BROWS]
    moved = [name for name in lost if track.channel(name).any()]
    apart = float(np.abs(np.subtract(*track.select(_INNER_BROWS).values.T)).max(initial=0.0))
    notes = []
    if apart > _SIDES_APART:
        notes.append(
            Note(
                "note",
                f"{file} has one channel for both inner brows: sides up to {apart:.2f} apart are averaged",
            )
        )
    if moved:
        notes.append(Note("note", f"{file} has ARKit's 52 channels and cannot hold {', '.join(moved)}"))
    return tuple(notes)


def livelink_motion(track: ChannelTrack) -> NDArray[np.float64]:
    """The numbers of `MOTION_COLUMNS` for every frame, shape (frames, 61); missing channels are
    zero.
    """
    angles = np.radians(track.select(HEAD).values) * HEAD_SIGNS
    motion: NDArray[np.float64] = np.hstack([arkit_weights(track), angles, _eye_angles(track)])
    return motion + 0.0  # no "-0.00000000"


def arkit_weights(track: ChannelTrack) -> NDArray[np.float64]:
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
