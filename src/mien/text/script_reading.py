"""From a text with tags, mien's own documents, or SSML to a `Script` (``docs/script.md`` is the reference).

One vocabulary serves all three: the elements of SSML that a voice can follow stand beside mien's own, and every command
of the library is an element. What cannot be done is a note on the result.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from mien.core.errors import InputError, Note
from mien.core.limits import read_bytes
from mien.core.plain_text import decode_text
from mien.text.bml import read_bml
from mien.text.commands import CommandLibrary, shipped_library
from mien.text.script import Script
from mien.text.script_builder import Builder
from mien.text.tag_elements import ELEMENTS
from mien.text.tags import ROOTS, Event, is_document, read_document, read_tagged_text, with_long_tags

__all__ = ["SUFFIXES", "read_script", "read_script_file", "script_text"]

_NOT_IN_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff\ud800-\udfff]")
SUFFIXES = (".txt", ".xml", ".ssml", ".bml")


def read_script(text: str, library: CommandLibrary | None = None, source: str = "text") -> Script:
    """Read a text with tags in it, a document of mien's own, SSML or BML: which of them, the text itself tells.

    Parameters
    ----------
    text : str
    library : CommandLibrary, optional
        The commands that are known; the default is the shipped library.
    source : str
        Name for messages, such as that of the file.

    Raises
    ------
    InputError
        If a tag is not known, not closed or not well formed, or a value does not fit; the message names the line.

    Examples
    --------
    >>> script = read_script('That is <HeadNod count="2"/> true.')
    >>> script.text, str(script.commands[0].at)
    ('That is  true.', '_1')
    """
    library = library or shipped_library()
    text = _NOT_IN_XML.sub(" ", text)
    if not is_document(text):
        written, held = with_long_tags(text, library.names)
        script = _built(read_tagged_text(written, {*ELEMENTS, *library.names}, source), library, source, collapse=False)
        return replace(script, notes=(*script.notes, *(_unclosed(name, source) for name in held)))
    events = tuple(read_document(text, source))
    root = events[0]
    if root.text == "bml":
        return read_bml(events, library, source)
    if root.text not in ROOTS:
        raise InputError(
            f"{source}, line {root.line}: a script's root is <script>, <speak> (SSML) or <bml>, not <{root.text}>"
        )
    return _built(events, library, source, collapse=True)


def read_script_file(path: str | Path, library: CommandLibrary | None = None) -> Script:
    """Read a script from a file: ``.txt`` (text with tags), ``.xml``, ``.ssml`` or ``.bml``.

    Raises
    ------
    InputError
        As `read_script`, and if the file cannot be read.
    """
    text, notes = script_text(path)
    script = read_script(text, library, str(path))
    return replace(script, notes=(*notes, *script.notes))


def script_text(path: str | Path) -> tuple[str, tuple[Note, ...]]:
    """The text of a script file, and a note if it was not in Unicode.

    Raises
    ------
    InputError
        If it has another suffix, is missing, or is no text in what its XML declaration says.
    """
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path}: a script is a file {', '.join(SUFFIXES)}, not {path.suffix or 'without a suffix'}")
    if not path.exists():
        raise InputError(f"{path}: no such script")
    content = read_bytes(path, "text")
    encoding = _declared(content, path)
    if encoding is None:
        return decode_text(content, path)
    try:
        return content.decode(encoding).replace("\r\n", "\n"), ()
    except (UnicodeDecodeError, LookupError) as problem:
        start = getattr(problem, "start", 0)
        raise InputError(f"{path}: expected {encoding} text, got other bytes at byte {start}") from problem


def _declared(content: bytes, path: Path) -> str | None:
    """What an XML declaration says, if it is another encoding than Unicode's."""
    declared = re.match(rb"""(?:\xef\xbb\xbf)?<\?xml[^>]{0,200}?encoding\s*=\s*["']([\w.-]+)["']""", content)
    if declared is None:
        return None
    name = declared[1].decode("ascii")
    try:
        found = codecs.lookup(name)
    except LookupError as problem:
        raise InputError(f"{path}, line 1: the encoding {name!r} is not known; save it as UTF-8") from problem
    return None if found.name.startswith("utf-") or not found._is_text_encoding else found.name


def _unclosed(name: str, source: str) -> Note:
    return Note(
        "note",
        f"{source}: <{name}> is never closed with </{name}>: it holds to the next such tag, or to the end of the text",
    )


def _built(events: Iterable[Event], library: CommandLibrary, source: str, collapse: bool) -> Script:
    builder = Builder(library, source, collapse, ELEMENTS)
    for event in events:
        builder.take(event)
    return builder.finish()
