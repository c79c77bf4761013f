"""What is said in a take: from a text, label or TextGrid file beside it, or a table for all."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from mien.core.border import guarded, reading
from mien.core.errors import InputError, Note, unknown_name
from mien.core.limits import check_size, is_whole
from mien.core.plain_text import read_plain_text
from mien.core.table_rows import Table, first_row, read_rows
from mien.core.timeline import Interval, Tier
from mien.core.utterance import PAUSE
from mien.corpus.recipes import FIELDS
from mien.formats.textgrid import read_textgrid
from mien.text.phones import phone_table

__all__ = ["Transcript", "own_table", "read_table", "read_transcript"]

_PAUSES = frozenset({"", "sil", "sp", "spn", "pau", "h#", "#", "<sil>", "<p:>", "silence", "_"})
_ALIGN_TICKS = 25_000  # of GRID's .align files per second
_LAB_TICKS = 10_000_000  # of HTK's .lab files per second
_NO_WORDS = frozenset({"sil", "sp", "spn", "pau", "<sil>", "<s>", "</s>", "#"})


@dataclass(frozen=True)
class Transcript:
    """What is said, and when, as far as the file knows.

    Attributes
    ----------
    text : str
    words : Tier or None
        Times as in the file: a second opinion beside our own alignment.
    phones : Tier or None
        Given only by a TextGrid with a tier of phones: then nothing is aligned.
    notes : tuple of Note
    """

    text: str
    words: Tier | None = None
    phones: Tier | None = None
    notes: tuple[Note, ...] = ()


@guarded("a transcript")
def read_transcript(path: Path) -> Transcript:
    """Read a ``.txt``, ``.lab``, ``.align`` or ``.TextGrid``.

    Raises
    ------
    InputError
        If the file cannot be read, holds no words, or a phone in it is not known.
    """
    suffix = path.suffix.lower()
    if suffix == ".textgrid":
        return _from_textgrid(path)
    text, notes = read_plain_text(path)
    if suffix == ".align":
        transcript = _from_labels(path, text, notes, _ALIGN_TICKS)
    elif suffix == ".lab" and re.match(r"\s*\d+\s+\d+\s+\S", text):
        transcript = _from_labels(path, text, notes, _LAB_TICKS)
    else:
        transcript = Transcript(" ".join(text.split()), notes=notes)
    if not transcript.text:
        raise InputError(f"{path}: expected what is said in the recording, the file has no words")
    return transcript


def _from_labels(path: Path, text: str, notes: tuple[Note, ...], ticks: int) -> Transcript:
    intervals = []
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip():
            continue
        cells = line.split()
        if len(cells) < 3 or not (is_whole(cells[0]) and is_whole(cells[1])):
            raise InputError(f"{path}, line {number}: expected 'start end word', got {line.strip()!r}")
        if cells[2].lower() not in _NO_WORDS:
            try:
                intervals.append(Interval(int(cells[0]) / ticks, int(cells[1]) / ticks, cells[2]))
            except InputError as problem:
                raise InputError(f"{path}, line {number}: {problem}") from problem
    words = Tier("words", tuple(intervals))
    if intervals and all(interval.label.rstrip("012").upper() in phone_table() for interval in intervals[:50]):
        raise InputError(
            f"{path}: its labels are phones, not words; give the words in a .txt or .TextGrid of that name"
        )
    return Transcript(" ".join(interval.label for interval in intervals), words, notes=notes)


def _from_textgrid(path: Path) -> Transcript:
    tiers = {tier.name.strip().lower().rstrip("s"): tier for tier in read_textgrid(path)}
    words = tiers.get("word") or tiers.get("transcript") or tiers.get("text") or tiers.get("sentence")
    if words is None or not len(words):
        known = ", ".join(tiers) or "none"
        raise InputError(f"{path}: expected a tier 'words' with what is said (tiers: {known})")
    spoken = Tier("words", tuple(i for i in words if i.label.strip().lower() not in _NO_WORDS and i.label.strip()))
    phones = tiers.get("phone") or tiers.get("phoneme")
    text = " ".join(interval.label.strip() for interval in spoken)
    return Transcript(text, spoken, _arpabet(path, phones) if phones and len(phones) else None)


def _arpabet(path: Path, tier: Tier) -> Tier:
    """Phones without stress, pauses as `PAUSE`."""
    intervals = []
    for interval in tier:
        label = interval.label.strip()
        if label.lower() in _PAUSES:
            symbol = PAUSE
        else:
            symbol = label.upper().rstrip("012")
            if symbol not in phone_table():
                raise InputError(
                    f"{path}, at {interval.start:.3f} s: {label!r} is not an ARPAbet phone; rename it, or leave "
                    "the tier of phones out and the words are aligned"
                )
        intervals.append(Interval(interval.start, interval.end, symbol))
    return Tier("phones", tuple(intervals))


def own_table(source: Path) -> Path | None:
    """The table of takes that lies in a folder of recordings as ``table.csv``; it begins with ``name``."""
    path = source / "table.csv"
    return path if path.is_file() and [cell.lower() for cell in first_row(path)][:1] == ["name"] else None


def read_table(path: Path) -> tuple[dict[str, dict[str, str]], tuple[Note, ...]]:
    """Read a table of takes: CSV, TSV or with semicolons; a header line with ``name`` and any of `FIELDS`.

    Returns
    -------
    table : dict
        For each name what the line says; empty cells are left out.
    notes : tuple of Note

    Raises
    ------
    InputError
        If a column is not known, or a name repeats.
    """
    with reading(path, "a table of takes"):
        table = read_rows(path)
        return _by_name(path, table), table.notes


def _by_name(path: Path, table: Table) -> dict[str, dict[str, str]]:
    header = table.rows[0][1] if table.rows else []
    columns = [name.lower() for name in header]
    if "name" not in columns:
        told = table.mark.join(header)[:60]
        raise InputError(f"{path}: expected a header line with 'name' and any of {', '.join(FIELDS)}, got {told!r}")
    for column in columns:
        if column not in ("name", *FIELDS):
            raise unknown_name(f"column in {path.name}", column, ("name", *FIELDS))
    found: dict[str, dict[str, str]] = {}
    for line, row in table.rows[1:]:
        if len(row) > len(columns):
            raise InputError(f"{path}, line {line}: more cells than columns: quote a text that holds the separator")
        cells = {column: cell for column, cell in zip(columns, row, strict=False) if cell}
        name = cells.pop("name", "")
        check_size("name", len(name), f"{path}, line {line}")
        if name in found:
            raise InputError(f"{path}, line {line}: the name {name!r} is there twice; keep one of the lines")
        found[name] = cells
    return found
