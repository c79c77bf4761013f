"""Texts as people save them: UTF-8, UTF-16 and UTF-32 with and without their marks, and Windows' own eight bits.

Every text that a command reads comes through here, so that all of them take the same files.
"""

from __future__ import annotations

import codecs
import io
import itertools
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mien.core.errors import InputError, Note
from mien.core.limits import check_size, most, opened, read_bytes

__all__ = ["decode_text", "first_lines", "parsed_json", "read_plain_text", "text_lines"]

_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_NOT_TEXT = re.compile(r"[\x00-\x08\x0e-\x1a\x1c-\x1f\x7f\x81\x8d\x8f\x90\x9d]")
_SAMPLE = 4096
_LONGEST_LINE = 65536
_LONGEST_ROW = 2**20  # characters


def read_plain_text(path: str | Path, what: str = "text") -> tuple[str, tuple[Note, ...]]:
    """The text of a file, and a note if it was not in Unicode.

    Parameters
    ----------
    path : path-like
    what : str
        What is expected, for messages: ``"text"``, ``"a table"``.

    Raises
    ------
    InputError
        If the file is missing, no file, larger than the limit ``text``, or no text.
    """
    return decode_text(read_bytes(path, "text"), path, what)


def first_lines(path: Path) -> list[str]:
    """The first lines of a file, without blanks around them; none where it is no text."""
    with path.open("rb") as file:
        head = file.read(_LONGEST_LINE)
    whole = head[: head.rfind(b"\n") + 1] or head[: len(head) // 4 * 4]
    if head[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        whole = head[: len(head) // 4 * 4]
    try:
        return [line.strip() for line in decode_text(whole, path)[0].split("\n")]
    except InputError:
        return []


def text_lines(path: str | Path, limit: str) -> Iterator[str]:
    """The lines of a file one by one, without their ends: a mesh of a gigabyte is never in memory as text.

    Parameters
    ----------
    path : path-like
    limit : str
        The limit of its size, as `read_bytes` takes it.

    Raises
    ------
    InputError
        If it cannot be read, is too large, has too many lines or one of more than a million characters.
    """
    rows = most("rows")
    with opened(path, limit) as file, io.TextIOWrapper(file, encoding="utf-8", errors="replace") as text:
        for number in itertools.count(1):
            line = text.readline(_LONGEST_ROW)
            if not line:
                return
            if len(line) == _LONGEST_ROW:
                raise InputError(f"{path}:{number}: a line of more than a million characters: is it of another kind?")
            if number > rows:
                check_size("rows", number, path)
            yield line.removesuffix("\n")


def decode_text(content: bytes, where: object, what: str = "text") -> tuple[str, tuple[Note, ...]]:
    """Bytes as text: by their mark, else UTF-8, else UTF-16 by its zero bytes, else Windows-1252.

    All line ends become line feeds.

    Raises
    ------
    InputError
        If the bytes are no text in any of them, or more than the limit ``text``.

    Examples
    --------
    >>> decode_text("Hyvää päivää".encode("utf-16"), "a.txt")
    ('Hyvää päivää', ())
    >>> text, notes = decode_text("naïve".encode("cp1252"), "a.txt")
    >>> text, notes[0].message
    ('naïve', 'a.txt is not in UTF-8: read as Windows-1252 (Western European)')
    """
    check_size("text", len(content), where)
    marked = next((encoding for mark, encoding in _MARKS if content.startswith(mark)), None)
    encoding = marked or _wide_without_mark(content) or "utf-8"
    notes: tuple[Note, ...] = ()
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as problem:
        name = {"utf-8-sig": "UTF-8"}.get(encoding, encoding.upper())
        if encoding != "utf-8" or _NOT_TEXT.search(content.decode("latin-1")):
            raise InputError(
                f"{where}: expected {what} in {name}, got other bytes at byte {problem.start}; save it as UTF-8"
            ) from problem
        text = content.decode("cp1252")
        notes = (Note("note", f"{_name(where)} is not in UTF-8: read as Windows-1252 (Western European)"),)
    if "\0" in text:
        raise InputError(f"{where}: expected {what}, character {text.index(chr(0))} is 0: is it of another kind?")
    return text.replace("\r\n", "\n").replace("\r", "\n"), notes


def _name(where: object) -> str:
    return Path(str(where)).name if isinstance(where, Path) else str(where)


def _wide_without_mark(content: bytes) -> str | None:
    """UTF-16 without a mark: in Latin scripts every other byte is zero."""
    sample = content[:_SAMPLE]
    if len(sample) < 4 or len(content) % 2 or b"\0" not in sample:
        return None
    even, odd = sample[0::2].count(0) / (len(sample) // 2), sample[1::2].count(0) / (len(sample) // 2)
    if odd > 0.6 and even < 0.1:
        return "utf-16-le"
    return "utf-16-be" if even > 0.6 and odd < 0.1 else None


def parsed_json(text: str | bytes, **how: Any) -> Any:
    """What a JSON text says.

    Parameters
    ----------
    text : str or bytes
    **how
        As `json.loads` takes it.

    Raises
    ------
    ValueError
        If it is none, or nested too deeply for Python to follow.

    Examples
    --------
    >>> parsed_json('{"takes": [1, 2]}')
    {'takes': [1, 2]}
    >>> parsed_json("[" * 100_000)
    Traceback (most recent call last):
        ...
    ValueError: nested too deeply
    """
    try:
        return json.loads(text, **how)
    except RecursionError:
        raise ValueError("nested too deeply") from None
