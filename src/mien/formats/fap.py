"""MPEG-4 face animation parameter files (``.fap``), the text form that FAP players read and write.

::

    # remarks, as many as wanted
    2.1 NAME FPS FRAMES
    0 0 1 1 ... (68 masks)         a mask and a line of values per frame
    FRAME VALUE VALUE ...          one value per set mask, in order

A set mask 1 has four values (viseme 1, viseme 2, blend 0..63, definition), a set mask 2 six (expression 1, intensity
0..63, expression 2, intensity 0..63, initial face, definition). Values 3 to 68 are whole numbers in units of the face
(FAPU): 1/1024 of a distance, or 1/100000 radian. Source: ISO/IEC 14496-2, Annex C; the text form is that of the MPEG-4
reference software and of the players that followed it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset_table
from mien.core.border import guarded
from mien.core.errors import InputError
from mien.core.files import replace_when_complete
from mien.core.limits import check_size
from mien.core.plain_text import read_plain_text
from mien.core.timeline import FrameRate

__all__ = ["COUNT", "FapTrack", "fap_table", "read_fap", "write_fap_track"]

COUNT = 68
VERSION = "2.1"
_HIGH = (4, 6)  # values of parameters 1 and 2

Ints = NDArray[np.int64]


@cache
def fap_table() -> dict[str, Any]:
    """``assets/mpeg4/faps.toml``: parameters, feature points, expressions and visemes."""
    return asset_table("mpeg4/faps.toml")


@dataclass(frozen=True, eq=False)
class FapTrack:
    """Face animation parameters over time.

    Attributes
    ----------
    values : ndarray of int, shape (frames, 68)
        Column k is parameter k + 1; the first two are unused (see ``visemes`` and ``expressions``).
    masks : ndarray of bool, shape (frames, 68)
        Which parameters a frame holds.
    visemes : ndarray of int, shape (frames, 4)
        Viseme 1 and 2, blend (63: all of viseme 1), definition flag.
    expressions : ndarray of int, shape (frames, 6)
        Expression 1, its intensity (0..63), expression 2, its intensity, initial-face flag, definition flag.
    rate : FrameRate
    name : str
    """

    values: Ints
    masks: NDArray[np.bool_]
    visemes: Ints
    expressions: Ints
    rate: FrameRate
    name: str = "mien"

    def __len__(self) -> int:
        return len(self.values)

    def emotions(self) -> NDArray[np.float64]:
        """Intensity 0..1 of the six basic expressions (joy, sadness, anger, fear, disgust, surprise), (frames, 6)."""
        found = np.zeros((len(self), 6))
        for which, strength in ((0, 1), (2, 3)):
            chosen, level = self.expressions[:, which], self.expressions[:, strength] / 63
            frames = np.flatnonzero((chosen >= 1) & (chosen <= 6) & self.masks[:, 1])
            found[frames, chosen[frames] - 1] = np.maximum(found[frames, chosen[frames] - 1], level[frames])
        return np.clip(found, 0, 1)


def write_fap_track(track: FapTrack, path: str | Path) -> None:
    """Write parameters as a ``.fap`` file.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    name = "_".join(track.name.split()) or "mien"
    lines = [f"{VERSION} {name} {_spelt(track.rate)} {len(track)}"]
    for frame in range(len(track)):
        lines += [" ".join("1" if mask else "0" for mask in track.masks[frame]), _frame_line(track, frame)]
    with replace_when_complete(path) as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def _spelt(rate: FrameRate) -> str:
    whole = rate.fraction.denominator == 1
    return str(rate.fraction.numerator) if whole else f"{float(rate.fraction):.9g}"


def _frame_line(track: FapTrack, frame: int) -> str:
    mask = track.masks[frame]
    numbers = [frame]
    if mask[0]:
        numbers += track.visemes[frame].tolist()
    if mask[1]:
        numbers += track.expressions[frame].tolist()
    numbers += track.values[frame, 2:][mask[2:]].tolist()
    return " ".join(str(number) for number in numbers)


@guarded("a FAP file")
def read_fap(path: str | Path) -> FapTrack:
    """Read a ``.fap`` file.

    Raises
    ------
    InputError
        If the file is missing or no FAP file, or a line does not fit (file and line are named).
    """
    path = Path(path)
    text, _ = read_plain_text(path, "a FAP file")
    lines = iter(
        (number, line.split("#", 1)[0].split()) for number, line in enumerate(text.splitlines(), 1)
        if line.split("#", 1)[0].strip()
    )  # fmt: skip
    name, rate, frames = _header(path, lines)
    check_size("frames", frames, path)
    if frames > max(1000, len(text) // (2 * COUNT)):  # a mask takes two characters a parameter
        raise InputError(f"{path}: {frames} frames promised, {len(text)} characters there: is it cut short?")
    values, masks = np.zeros((frames, COUNT), np.int64), np.zeros((frames, COUNT), np.bool_)
    visemes, expressions = np.zeros((frames, 4), np.int64), np.zeros((frames, 6), np.int64)
    for frame in range(frames):
        number, mask = _whole_numbers(path, lines, f"the masks of frame {frame} of {frames}")
        if len(mask) != COUNT or not set(mask) <= {0, 1}:
            raise InputError(f"{path}:{number}: expected {COUNT} masks of 0 or 1, got {len(mask)} numbers")
        masks[frame] = np.array(mask, dtype=np.bool_)
        number, given = _whole_numbers(path, lines, f"the values of frame {frame} of {frames}")
        expected = 1 + sum(_HIGH[k] if k < 2 else 1 for k in np.flatnonzero(masks[frame]))
        if len(given) != expected:
            raise InputError(
                f"{path}:{number}: the masks ask for a frame number and {expected - 1} values, got {len(given)} numbers"
            )
        rest = given[1:]
        if masks[frame, 0]:
            visemes[frame], rest = rest[:4], rest[4:]
        if masks[frame, 1]:
            expressions[frame], rest = rest[:6], rest[6:]
        values[frame, 2:][masks[frame, 2:]] = rest
    return FapTrack(values, masks, visemes, expressions, rate, name)


def _header(path: Path, lines: Iterator[tuple[int, list[str]]]) -> tuple[str, FrameRate, int]:
    number, words = next(lines, (1, []))
    try:
        version, name, fps, frames = words[0], " ".join(words[1:-2]), words[-2], int(words[-1])
        if len(words) < 4 or not version.startswith("2") or frames < 0:
            raise ValueError
        return name, FrameRate.of(fps), frames
    except (IndexError, ValueError) as problem:
        told = " ".join(words)[:60]
        raise InputError(f"{path}:{number}: expected '2.1 NAME FPS FRAMES', got {told!r}") from problem


def _whole_numbers(path: Path, lines: Iterator[tuple[int, list[str]]], what: str) -> tuple[int, list[int]]:
    found = next(lines, None)
    if found is None:
        raise InputError(f"{path}: ends before {what}")
    try:
        return found[0], [int(word) for word in found[1]]
    except ValueError as problem:
        raise InputError(f"{path}:{found[0]}: expected whole numbers ({problem})") from problem
