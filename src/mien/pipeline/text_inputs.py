"""Texts as commands and calls take them: the text itself, or the name of a file that holds it.

One rule for all commands: a `Path` is a file; a string is one if it ends like a text file (`TEXT_FILES`) and is a
single word or the name of a file that is there. Everything else is text.
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from mien.core.errors import InputError, Note
from mien.core.plain_text import read_plain_text
from mien.text.commands import CommandLibrary
from mien.text.script import Script

__all__ = ["TEXT_FILES", "read_text", "script_of", "text_or_file"]

DOCUMENTS = (".xml", ".ssml", ".bml")
TEXT_FILES = (".txt", ".lab", *DOCUMENTS, ".textgrid")
"""Endings by which a string is taken for the name of a file."""
_LONGEST_NAME = 4096


def text_or_file(text: str | Path) -> str | Path:
    """What is given as it is, or as a `Path` if it names a file.

    Examples
    --------
    >>> text_or_file("I never said that."), text_or_file("nowhere/line.txt")
    ('I never said that.', PosixPath('nowhere/line.txt'))
    """
    if not isinstance(text, (str, Path)):
        raise InputError(f"expected a text or the path of a text file, got {type(text).__name__}")
    if isinstance(text, Path) or len(text) > _LONGEST_NAME or "\n" in text:
        return text
    name = text.strip()
    one_word, named = len(name.split()) == 1, name.lower().endswith(TEXT_FILES)
    if one_word and named:
        return Path(name)
    if (named or (one_word and os.sep in name)) and os.path.isfile(name):  # noqa: PTH113 - Path cannot hold any text
        return Path(name)
    return text


def read_text(text: str | Path) -> str:
    """The text itself, or the content of the file that it names.

    Raises
    ------
    InputError
        If it names a file that is missing or holds no text.

    Examples
    --------
    >>> read_text("I never said that.")
    'I never said that.'
    """
    found = text_or_file(text)
    return found if isinstance(found, str) else _content(found)[0]


def script_of(text: str | Path | Script, library: CommandLibrary | None = None) -> Script:
    """A script, from a text with tags or the file that a `Path` names.

    Raises
    ------
    InputError
        If it cannot be read or its tags are not understood.
    """
    from mien.text.script_reading import read_script, read_script_file

    if isinstance(text, Script):
        return text
    if isinstance(text, str):
        return _with_note(read_script(text, library), text)
    if not isinstance(text, Path):
        raise InputError(f"expected a text to say, got {type(text).__name__}")
    if text.suffix.lower() in DOCUMENTS:
        return read_script_file(text, library)
    if text.suffix.lower() == ".textgrid":
        raise InputError(f"{text}: a TextGrid goes with its recording: mien animate SOUND --text {text.name}")
    content, notes = _content(text)
    script = read_script(content, library, str(text))
    return replace(script, notes=(*notes, *script.notes))


def _content(path: Path) -> tuple[str, tuple[Note, ...]]:
    if not path.exists():
        raise InputError(f"{path}: no such text file")
    if path.is_dir():
        raise InputError(f"{path}: expected a text file, got a folder")
    return read_plain_text(path)


def _with_note(script: Script, text: str) -> Script:
    """Say so where a word that is spoken is also the name of a file here."""
    name = text.strip()
    if len(name.split()) != 1 or len(name) > 255 or not os.path.isfile(name):  # noqa: PTH113
        return script
    note = Note("note", f"{name!r} is spoken as a word; to read the file of that name, write .{os.sep}{name}")
    return replace(script, notes=(*script.notes, note))
