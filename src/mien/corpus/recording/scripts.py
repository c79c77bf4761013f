"""Scripts: sentences to read aloud, one a line. Data in ``assets/scripts/``, or a file of your own.

A line that begins with ``#`` is a comment; empty lines are passed over. Sentences are numbered from 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mien.core.assets import asset
from mien.core.errors import InputError, unknown_name
from mien.core.plain_text import read_plain_text

__all__ = ["LANGUAGES", "Line", "read_script"]

LANGUAGES = {"en": "english", "fi": "finnish"}
"""Scripts that come with mien, by language."""


@dataclass(frozen=True)
class Line:
    """A sentence of a script.

    Attributes
    ----------
    number : int
        From 1, as the script counts.
    text : str
    """

    number: int
    text: str

    @property
    def label(self) -> str:
        """The number in three digits, as files carry it."""
        return f"{self.number:03d}"


def read_script(language: str = "en", path: str | Path | None = None) -> list[Line]:
    """Read the script of a language, or one of your own.

    Parameters
    ----------
    language : str
        One of `LANGUAGES`; not looked at where ``path`` is given.
    path : path-like, optional
        Text, one sentence a line.

    Raises
    ------
    InputError
        If the language has no script, or the file cannot be read, is no text, holds no sentence, or one of them
        twice: the recordings of a sentence are told by its text.

    Examples
    --------
    >>> len(read_script("en")) < 60
    True
    """
    if path is None:
        if language not in LANGUAGES:
            raise unknown_name("language", language, LANGUAGES)
        file = asset(f"scripts/{LANGUAGES[language]}.txt")
    else:
        file = Path(path)
    content, _ = read_plain_text(file, "sentences to read")
    sentences = [text for row in content.splitlines() if (text := " ".join(row.split())) and not text.startswith("#")]
    if not sentences:
        raise InputError(f"{file}: expected sentences to read, one a line; the file holds none")
    for number, text in enumerate(sentences, start=1):
        first = sentences.index(text) + 1
        if first != number:
            raise InputError(f"{file}: sentences {first} and {number} are the same ({text!r}); keep one")
    return [Line(number, text) for number, text in enumerate(sentences, start=1)]
