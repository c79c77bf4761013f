"""What stands in a text and is not said: stage directions and the names of speakers.

Not said are: what stands in square brackets, ``[door slams]``; a few words in round brackets or between asterisks that
say how somebody speaks or what is heard, ``(sighs)``, ``*laughs*``, ``(very quietly)``; the name of a speaker at the
start of a line, ``ANNA:``, or ``Anna:`` where several lines begin with names. Each is named in a note.
"""

from __future__ import annotations

import re
from collections import Counter
from functools import cache

from mien.core.errors import Note
from mien.text.spoken_numbers import english_table

__all__ = ["without_directions"]

_SQUARE = re.compile(r"\[([^\[\]\n]{1,200})\]")
_ROUND = re.compile(r"\(([^()\n]{1,60})\)|\*([^*\n]{1,60})\*")
_NAME = re.compile(r"^[ \t]{0,20}([A-Z][A-Za-z.' -]{0,30}):(?=[ \t]+\S)", re.MULTILINE)
_MOST_WORDS = 4
_MODIFIERS = ("very", "more", "quite", "still", "a", "long", "half")


def without_directions(text: str) -> tuple[str, tuple[Note, ...]]:
    """A text of the same length with blanks for what is not said.

    Returns
    -------
    str
    tuple of Note
        One for directions and one for names, where there are any.

    Examples
    --------
    >>> text, notes = without_directions("ANNA: (sighs) Well. [door slams]")
    >>> text.strip()
    'Well.'
    >>> [note.message for note in notes]
    ['not spoken, taken as the name of a speaker: ANNA', 'not spoken, taken as stage directions: door slams, sighs']
    """
    found: list[str] = []
    names: list[str] = []

    def hidden(match: re.Match[str]) -> str:
        found.append(next(part for part in match.groups() if part is not None).strip())
        return " " * len(match[0])

    def hidden_if_heard(match: re.Match[str]) -> str:
        inside = next(part for part in match.groups() if part is not None)
        return hidden(match) if _is_direction(inside) else match[0]

    speakers = _speakers(text)

    def hidden_name(match: re.Match[str]) -> str:
        if match[1] not in speakers:
            return match[0]
        names.append(match[1])
        return " " * len(match[0])

    text = _ROUND.sub(hidden_if_heard, _SQUARE.sub(hidden, text))
    text = _NAME.sub(hidden_name, text)
    notes = []
    for what, said in (("the name of a speaker", names), ("stage directions", found)):
        if said:
            notes.append(Note("note", f"not spoken, taken as {what}: {', '.join(dict.fromkeys(said))}"))
    return text, tuple(notes)


def _is_direction(words: str) -> bool:
    """Whether a few words tell how somebody speaks, or what is heard: they begin with a word for that."""
    said = re.findall(r"[a-z']+", words.lower())
    if said and said[0] in _MODIFIERS:
        said = said[1:]
    return 0 < len(said) <= _MOST_WORDS and said[0] in _direction_words()


@cache
def _direction_words() -> frozenset[str]:
    return frozenset(english_table()["stage_directions"]["words"].split())


def _speakers(text: str) -> set[str]:
    """Names at the start of lines: in capitals, or of lines of which several begin with a name."""
    at_start = [match[1] for match in _NAME.finditer(text)]
    never = set(english_table()["stage_directions"]["not_names"].split())
    names = [name for name in at_start if name.lower() not in never and len(name.split()) <= 3]
    several = sum(Counter(names).values()) >= 2
    return {name for name in names if (name.isupper() and len(name) > 1) or several}
