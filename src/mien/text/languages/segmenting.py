"""Words of scripts that write none: Chinese by `rjieba`, Japanese by Janome (readings too), each an extra of mien."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from importlib.util import find_spec
from typing import Any

from mien.core.errors import Note
from mien.text.languages.language import Language
from mien.text.languages.tokens import Token

__all__ = ["can_segment", "note_on_blanks", "segmented"]

_CLAUSE = {"rjieba": 4, "janome": 12}
"""Letters that a piece without blanks has at most if it is likely one word."""
_LEANING = ("助詞", "助動詞", "接尾", "非自立")
"""Parts of speech that belong to the word before them: particles, endings, auxiliaries."""


def can_segment(language: Language) -> bool:
    """Whether what cuts this language's text into words is wanted and installed."""
    return find_spec(language.table.get("written", {}).get("segmenter", "no")) is not None


def note_on_blanks(words: list[str], language: Language) -> tuple[Note, ...]:
    """A note where a clause without blanks counts as one word because nothing is installed that cuts it."""
    segmenter = language.table.get("written", {}).get("segmenter")
    if not segmenter or can_segment(language):
        return ()
    long = next((word for word in words if _in_script(word) and len(word) > _CLAUSE[segmenter]), None)
    if long is None:
        return ()
    advice = f'put blanks between words, or: pip install "mien[{language.tag}]" ({segmenter})'
    return (Note("note", f"{long[:20]!r} counts as one word: {advice}"),)


def segmented(token: Token, language: Language) -> Iterator[Token]:
    """A piece of text as its words, where it is in the language's own script and can be cut."""
    if not can_segment(language) or not _in_script(token.said or token.text):
        yield _with_particle(token, language)
        return
    if token.said and language.tag == "ja":  # kana already, with blanks
        yield token
        return
    text = token.said or token.text
    parts = _chinese(text) if language.tag == "zh" else _japanese(text)
    place = token.start
    for number, (surface, said) in enumerate(parts):
        end = place + len(surface)
        span = (token.start, token.end) if token.said else (place, end)
        pause = token.pause if number == len(parts) - 1 else ""
        yield Token(surface, *span, pause, said)
        place = end


def _in_script(text: str) -> bool:
    return re.search("[\u3040-\u30ff\u3400-\u9fff]", text) is not None


def _chinese(text: str) -> list[tuple[str, str]]:
    import rjieba

    return [(word, word) for word in rjieba.cut(text)]


def _japanese(text: str) -> list[tuple[str, str]]:
    """Each word with the particles and endings that lean on it, and how it is read."""
    words: list[tuple[str, str]] = []
    for part in _janome().tokenize(text):
        said = part.surface if part.phonetic == "*" else part.phonetic.replace("ヲ", "オ")
        if words and any(kind in part.part_of_speech for kind in _LEANING):
            words[-1] = words[-1][0] + part.surface, words[-1][1] + said
        else:
            words.append((part.surface, said))
    return words


@cache
def _janome() -> Any:
    from janome.tokenizer import Tokenizer

    return Tokenizer()


def _with_particle(token: Token, language: Language) -> Token:
    """は and へ at the end of a word are particles, said "wa" and "e", but for the words that the table names."""
    particles: dict[str, str] = language.table.get("particles", {})
    text = token.said or token.text
    if len(text) > 1 and text[-1:] in particles and text not in language.table.get("no_particle", ()):
        return replace(token, said=text[:-1] + particles[text[-1]])
    return token
