"""Tables as people and spreadsheets save them: commas, semicolons or tabs, decimal commas, any encoding.

Every table that a command reads comes through here, so that all of them take the same files.
"""

from __future__ import annotations

import csv
import io
import re
from dataclasses import dataclass
from pathlib import Path

from mien.core.errors import InputError, Note
from mien.core.limits import check_size
from mien.core.plain_text import first_lines, read_plain_text

__all__ = ["Table", "first_row", "parsed_table", "read_rows"]

_SAID = re.compile(r"\s*\"?sep=(?P<mark>[,;\t])\"?[,;\t]*\s*(?:\n|$)", re.IGNORECASE)
_QUOTED = re.compile(r'"[^"]*"')
_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")


@dataclass(frozen=True)
class Table:
    """The rows of a table that hold anything.

    Attributes
    ----------
    rows : list of (int, list of str)
        The line on which each ends, from 1, and its cells, without blanks around them.
    mark : str
        What separates cells.
    notes : tuple of Note
    """

    rows: list[tuple[int, list[str]]]
    mark: str
    notes: tuple[Note, ...] = ()

    def spelt(self, cell: str) -> str:
        """A cell with a decimal point where it has a decimal comma (which needs another mark between cells).

        Examples
        --------
        >>> parsed_table("0;0,5", "a.csv").spelt("0,5")
        '0.5'
        """
        return cell.replace(",", ".") if self.mark != "," and _DECIMAL_COMMA.fullmatch(cell) else cell


def read_rows(path: str | Path, what: str = "a table", limit: str = "rows") -> Table:
    """Read a table.

    Parameters
    ----------
    path : path-like
    what : str
        What is expected, with its article, for messages.
    limit : str
        Which of `mien.core.limits.LIMITS` bounds the number of its lines.

    Raises
    ------
    InputError
        If the file is missing, no text, larger than the limit, or its quotes do not close.
    """
    path = Path(path)
    text, notes = read_plain_text(path, what)
    table = parsed_table(text, path, what, limit)
    return Table(table.rows, table.mark, notes)


def first_row(path: Path) -> list[str]:
    """The cells of a table's first row; none where there is no table."""
    lines = first_lines(path)
    head = lines[: 2 if lines and _SAID.match(lines[0]) else 1]
    try:
        return next((row for _, row in parsed_table("\n".join(head), path).rows), [])
    except InputError:
        return []


def parsed_table(text: str, where: object, what: str = "a table", limit: str = "rows") -> Table:
    r"""The table in a text. A first line ``sep=;`` says what separates cells; else
    tabs or semicolons do where there are any.

    Raises
    ------
    InputError
        As `read_rows`.

    Examples
    --------
    >>> parsed_table("sep=;\nname;text\na;\"one; two\"\n\n", "a.csv").rows
    [(2, ['name', 'text']), (3, ['a', 'one; two'])]
    """
    check_size(limit, text.count("\n"), where)
    said = _SAID.match(text)
    text, before = (text[said.end() :], 1) if said else (text, 0)
    first = next((line for line in io.StringIO(text) if line.strip() and not line.lstrip().startswith("#")), "")
    bare = _QUOTED.sub("", first)
    mark = said["mark"] if said else next((mark for mark in "\t;" if mark in bare), ",")
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=mark, strict=True)
    try:
        rows = [(reader.line_num + before, [cell.strip() for cell in row]) for row in reader]
    except csv.Error as problem:
        raise InputError(f"{where}, line {reader.line_num + before}: expected {what} ({problem})") from problem
    return Table([(line, row) for line, row in rows if any(row)], mark)
