"""The errors that mien raises, and the notes it leaves.

::

    MienError
    ├── InputError          what was given cannot be used: a file, a text, an option
    │   └── AlignmentError  the sound and its text could not be brought together
    ├── OutputError         the result cannot be written where it was asked for
    └── MissingPartError    an optional part (a voice, a decoder) is not installed

Every message is one line: what was expected, what came, where, and what to do.
The command line prints it and ends with exit code 2.

What is worth saying but does not stop the work is a `Note`, carried by the result
(`Utterance.notes`, `Animation.notes`), never printed by the library itself.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

__all__ = [
    "AlignmentError",
    "InputError",
    "MienError",
    "MissingPartError",
    "Note",
    "OutputError",
    "near_names",
    "unknown_name",
]


_LONGEST = 1200
"""Characters of a message; what was given may be a megabyte, and a message that quotes it is cut in the middle."""


class MienError(Exception):
    """Root of all errors raised on purpose by mien.

    Examples
    --------
    >>> len(str(MienError("x" * 5000)))
    1200
    """

    def __init__(self, message: str = "") -> None:
        message = " ".join(message.splitlines()) if len(message.splitlines()) > 1 else message
        if len(message) > _LONGEST:
            message = message[: _LONGEST * 2 // 3] + " ... " + message[5 - _LONGEST // 3 :]
        super().__init__(message)


class InputError(MienError):
    """What was given cannot be used."""


class AlignmentError(InputError):
    """The sound and its text could not be brought together."""


class OutputError(MienError):
    """The result cannot be written where it was asked for."""


class MissingPartError(MienError):
    """An optional part is needed and not installed."""


@dataclass(frozen=True)
class Note:
    """Something a person should know about a result that was made all the same.

    Attributes
    ----------
    kind : {"note", "warning"}
        A note says what was done with odd input; a warning says that the result may be poor.
    message : str
        One line.
    """

    kind: Literal["note", "warning"]
    message: str


def near_names(given: str, known: Iterable[str], most: int = 3) -> list[str]:
    """Names that were perhaps meant: nearly the same, or with a part that is, in any letters.

    Examples
    --------
    >>> near_names("nod", ["HeadNod", "Blink"]), near_names("haert", ["kokoro-heart", "espeak"])
    (['HeadNod'], ['kokoro-heart'])
    """
    import re
    from difflib import get_close_matches

    names = list(known)
    short = given[:80]
    near = get_close_matches(short, names, n=most)
    parts: dict[str, list[str]] = {}
    for name in names:
        for part in {name.lower(), *(part.lower() for part in re.findall(r"[A-Z]?[a-z]+|\d+", name))}:
            parts.setdefault(part, []).append(name)
    for part in () if near else get_close_matches(short.lower(), parts, n=most, cutoff=0.75):
        near += [name for name in parts[part] if name not in near]
    return near[:most]


def unknown_name(what: str, given: str, known: Iterable[str]) -> InputError:
    """Make the error for a name that is not known, with the nearest one that is.

    Examples
    --------
    >>> str(unknown_name("emotion", "hapy", ["happy", "sad"]))
    "unknown emotion 'hapy': did you mean 'happy'? known: happy, sad"
    """
    names = sorted(known)
    near = near_names(str(given), names, 1)
    guess = f" did you mean {near[0]!r}?" if near else ""
    return InputError(f"unknown {what} {given!r}:{guess} known: {', '.join(names)}")
