"""`Stimulus`, one row of an experiment's design, and the table that lists them."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from mien.core.errors import InputError, unknown_name
from mien.core.limits import check_size
from mien.core.table_rows import read_rows
from mien.face.library import check_face
from mien.face.render.view import TRANSPARENT, View
from mien.formats.video import check_film
from mien.text.effort_spans import parse_effort

__all__ = ["COLUMNS", "Stimulus", "read_design"]


@dataclass(frozen=True)
class Stimulus:
    """One stimulus; the fields are the columns of a design (``docs/stimuli.md``).

    Attributes
    ----------
    name : str
        Of its files.
    sentence : str
        What the face says; tags as in ``docs/script.md``.
    heard : str
        What is heard instead (a McGurk pair); empty: the same.
    emotion, intensity
        As for `mien.say`.
    effort : str
        How hard it articulates, as for `mien.say`; empty: as the emotion has it.
    offset_ms : float
        Sound after (> 0) or before (< 0) the picture.
    rate : float
        Speaking rate, 1 as usual.
    au : str
        Action units or face parameters held throughout, such as ``AU12:0.7 AU4:0.5``.
    still_ms : str
        Empty for a video; else the time of the one picture.
    crop : str
        What of the face is seen: ``oval``, the name of a camera, or pixels as `View` has it.
    background, camera, light, quality, painter : str
        As `mien.face.render.view.View` has them; empty: as usual.
    where : str
        The file and line it comes from, for messages.
    """

    name: str
    sentence: str
    heard: str = ""
    voice: str = ""
    emotion: str = ""
    intensity: float = 1.0
    effort: str = ""
    offset_ms: float = 0.0
    rate: float = 1.0
    au: str = ""
    still_ms: str = ""
    crop: str = "portrait"
    background: str = ""
    camera: str = ""
    light: str = ""
    quality: str = ""
    painter: str = ""
    fps: str = "25"
    seed: int = 0
    performer: str = "default"
    face: str = "default"
    width: int = 640
    height: int = 480
    where: str = ""

    @property
    def file(self) -> str:
        """The name of its video or picture."""
        moving = "webm" if self.background == TRANSPARENT else "mp4"
        return f"{self.name}.{'png' if self.still_ms else moving}"

    @property
    def view(self) -> View:
        """How it is pictured."""
        cut = self.crop == "oval" or self.crop[:1].isdigit()
        if not cut and self.camera and self.crop != "portrait":
            raise InputError(f"crop {self.crop} and camera {self.camera} both say what is seen: give one of them")
        camera, crop = (self.camera, self.crop) if cut else (self.camera or self.crop, "")
        light, quality = self.light or "portrait", self.quality or "full"
        painter = self.painter or "processor"
        return View(self.width, self.height, camera, light, self.background, crop, quality, painter)

    def settings(self) -> dict[str, Any]:
        """The columns with their values."""
        return {name: getattr(self, name) for name in COLUMNS}


COLUMNS = tuple(field.name for field in fields(Stimulus) if field.name != "where")
_NUMBERS: dict[str, Callable[[str], float | int]] = {
    "intensity": float, "offset_ms": float, "rate": float, "seed": int, "width": int, "height": int,
}  # fmt: skip


def read_design(path: str | Path, usual: Mapping[str, str] | None = None) -> tuple[Stimulus, ...]:
    """The stimuli of a table: CSV with commas or semicolons (the first line tells), or TSV by its suffix.

    Levels in one cell are separated by ``|`` and crossed with those of the other cells of the row; several rows list
    what is not crossed. ``usual`` says what cells hold that are empty or whose column is missing.

    Raises
    ------
    InputError
        Naming file and line: a column that is missing, twice there or not known, a value that does not fit, a name
        used twice.
    """
    path = Path(path)
    header, rows = _table(path)
    for column in header:
        if column not in COLUMNS:
            raise InputError(f"{path}, line 1: {unknown_name('column', column, COLUMNS)}")
        if header.count(column) > 1:
            raise InputError(f"{path}, line 1: the column {column!r} is there {header.count(column)} times")
    if "sentence" not in header:
        raise InputError(f"{path}, line 1: the column 'sentence' is missing; known: {', '.join(COLUMNS)}")
    found: dict[str, Stimulus] = {}
    for line, row in rows:
        for stimulus in _crossed(header, row, f"{path}, line {line}", len(found), usual or {}):
            if stimulus.name in found:
                raise InputError(
                    f"{stimulus.where}: the name {stimulus.name!r} is used at {found[stimulus.name].where} too"
                )
            found[stimulus.name] = stimulus
    if not found:
        raise InputError(f"{path}: no stimulus in it")
    return tuple(found.values())


def _table(path: Path) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """The names of the columns, and each row that is not empty with the line it ends on."""
    table = read_rows(path)
    if not table.rows:
        return [], []
    (_, header), *rows = table.rows
    return header, rows


def _crossed(
    header: Sequence[str], row: Sequence[str], where: str, before: int, usual: Mapping[str, str]
) -> Iterable[Stimulus]:
    if len(row) != len(header):
        raise InputError(
            f"{where}: expected as many cells as the first line has ({len(header)}), found {len(row)}; a text with the "
            "table's separator in it stands in quotes"
        )
    given = {name: cell.strip() for name, cell in zip(header, row, strict=True) if cell.strip()}
    if "sentence" not in given:
        raise InputError(f"{where}: the sentence is empty")
    levels = {
        name: [level.strip() or usual.get(name, "") for level in value.split("|")] for name, value in given.items()
    }
    levels = {name: [value] for name, value in usual.items()} | levels
    check_size("stimuli", math.prod(map(len, levels.values())), where)
    crossed = list(itertools.product(*levels.values()))
    for number, values in enumerate(crossed, start=1):
        cell = dict(zip(levels, values, strict=True))
        name = cell.pop("name", f"s{before + number:04d}")
        name = f"{name}-{number:03d}" if "name" in given and len(crossed) > 1 else name
        if not re.fullmatch(r"[\w.-]+", name) or name.startswith("."):
            raise InputError(f"{where}: a name is letters, digits, '.', '_' and '-', not {name!r}")
        yield _stimulus(name, cell, where)


def _stimulus(name: str, cell: Mapping[str, str], where: str) -> Stimulus:
    values: dict[str, object] = {}
    for column, text in cell.items():
        if not text:
            continue  # an empty level: as usual
        if column not in _NUMBERS:
            values[column] = text
            continue
        try:
            values[column] = _NUMBERS[column](text.replace(",", "."))
        except ValueError:
            kind = "a whole number" if _NUMBERS[column] is int else "a number"
            raise InputError(f"{where}: {column} is {kind}, not {text!r}") from None
    if "sentence" not in values:
        raise InputError(f"{where}: one level of the sentence is empty")
    stimulus = Stimulus(name=name, where=where, **values)  # type: ignore[arg-type]
    try:
        _check(stimulus)
    except InputError as problem:
        raise InputError(f"{where}: {problem}") from problem
    return stimulus


def _check(stimulus: Stimulus) -> None:
    checks = (
        (0 <= stimulus.intensity <= 1, f"intensity runs from 0 to 1, not {stimulus.intensity:g}"),
        (0.25 <= stimulus.rate <= 4, f"rate lies between 0.25 and 4, not {stimulus.rate:g}"),
        (abs(stimulus.offset_ms) <= 10_000, f"offset_ms lies within 10 s, not {stimulus.offset_ms:g}"),
        (stimulus.seed >= 0, f"seed is 0 or more, not {stimulus.seed}"),
        (not stimulus.still_ms or re.fullmatch(r"\d+(\.\d+)?", stimulus.still_ms), "still_ms is milliseconds"),
    )
    for right, message in checks:
        if not right:
            raise InputError(message)
    if stimulus.effort not in ("", "off"):
        parse_effort(stimulus.effort)
    check_face(stimulus.face)
    view = stimulus.view
    if not stimulus.still_ms:
        check_film(stimulus.file, view)
