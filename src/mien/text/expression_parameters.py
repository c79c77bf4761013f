"""MPEG-4's high-level expression parameter (FAP 2 of ISO/IEC 14496-2) as emotions of a score (Deng et al. 2004).

The parameter chooses two of six expressions and an intensity for each, 0 to 63. Here it is a CSV file, one line for
each moment at which it changes::

    seconds,expression1,intensity1,expression2,intensity2
    0.0,joy,20,,
    1.5,joy,63,surprise,10
    2.0,4,50,,

Expressions by name (joy, sadness, anger, fear, disgust, surprise) or by the standard's number (1 to 6; 0 or nothing:
none). Between lines intensities run straight.
"""

from __future__ import annotations

from pathlib import Path

from mien.core.border import guarded
from mien.core.errors import InputError, unknown_name
from mien.core.limits import is_whole
from mien.core.table_rows import read_rows
from mien.text.intensity import IntensityCurve
from mien.text.score import EmotionSpan

__all__ = ["EXPRESSIONS", "read_expression_parameters"]

EXPRESSIONS: dict[str, str] = {
    "joy": "happy",
    "sadness": "sad",
    "anger": "angry",
    "fear": "afraid",
    "disgust": "disgusted",
    "surprise": "surprised",
}
"""MPEG-4's expressions, in the order of their numbers 1 to 6, and the emotions of mien that show them."""
_STRONGEST = 63.0
_COLUMNS = ("seconds", "expression1", "intensity1", "expression2", "intensity2")


@guarded("a CSV of expression parameters")
def read_expression_parameters(path: str | Path) -> tuple[EmotionSpan, ...]:
    """Read a file of expression parameters: one span for each expression that it uses, with its intensity over time.

    Raises
    ------
    InputError
        If the file is missing or a line is not written as above; the message names the line.
    """
    path = Path(path)
    table = read_rows(path, "expression parameters", "keys")
    if not table.rows or tuple(cell.lower() for cell in table.rows[0][1]) != _COLUMNS:
        raise InputError(f"{path}, line 1: expected the headings {','.join(_COLUMNS)}")
    times: list[float] = []
    asked: list[dict[str, float]] = []
    for number, row in table.rows[1:]:
        try:
            time, moment = _moment([table.spelt(cell) for cell in row])
        except (InputError, ValueError) as problem:
            raise InputError(f"{path}, line {number}: {problem}") from problem
        if times and time <= times[-1]:
            raise InputError(f"{path}, line {number}: {time:g} s does not come after {times[-1]:g} s")
        times.append(time)
        asked.append(moment)
    used = sorted({name for moment in asked for name in moment})
    if not used:
        raise InputError(f"{path}: no line asks for an expression")
    return tuple(
        EmotionSpan(name, IntensityCurve(tuple(times), tuple(moment.get(name, 0.0) for moment in asked), "linear"))
        for name in used
    )


def _moment(cells: list[str]) -> tuple[float, dict[str, float]]:
    """Seconds, and the intensity (0..1) of each emotion asked for."""
    if len(cells) != len(_COLUMNS):
        raise InputError(f"expected {len(_COLUMNS)} columns, got {len(cells)}")
    moment: dict[str, float] = {}
    for name, intensity in (cells[1:3], cells[3:5]):
        if name in ("", "0"):
            continue
        emotion = _emotion(name)
        strength = float(intensity)
        if not 0 <= strength <= _STRONGEST:
            raise InputError(f"an intensity of MPEG-4 runs from 0 to 63, not {intensity}")
        moment[emotion] = max(moment.get(emotion, 0.0), strength / _STRONGEST)
    return float(cells[0]), moment


def _emotion(name: str) -> str:
    names = list(EXPRESSIONS)
    if is_whole(name) and 1 <= int(name) <= len(names):
        return EXPRESSIONS[names[int(name) - 1]]
    if name.lower() not in EXPRESSIONS:
        raise unknown_name("expression of MPEG-4", name, (*names, "1..6"))
    return EXPRESSIONS[name.lower()]
