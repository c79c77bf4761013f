"""Is the table of a language complete, and how exact is alignment in it? eSpeak NG speaks, and knows its own times."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from pathlib import Path

import numpy as np

from mien.core.errors import InputError
from mien.core.timeline import Interval
from mien.core.utterance import PAUSE, Utterance
from mien.speech.align import align
from mien.speech.synthesis import synthesise
from mien.text.languages import Language, find_language, heard_as, read_in

__all__ = ["LanguageCheck", "boundary_errors", "check_language", "heard_phones"]


@dataclass(frozen=True)
class LanguageCheck:
    """What checking a language found.

    Attributes
    ----------
    language : str
        Its name in English.
    sentences : int
    phones : tuple of (str, str)
        Every phone of the sentences and what it is: English phones, and key shapes of its own.
    boundaries : int
        Between neighbouring phones, as the engine gives them.
    errors : ndarray
        Seconds between the engine's boundary and the aligned one, where both have the same phones about it.
    warned : int
        Sentences whose true text drew a warning.
    """

    language: str
    sentences: int
    phones: tuple[tuple[str, str], ...]
    boundaries: int
    errors: np.ndarray[tuple[int], np.dtype[np.float64]]
    warned: int

    def __str__(self) -> str:
        width = max(len(phone) for phone, _ in self.phones)
        lines = [f"{phone:{width}}  {what}" for phone, what in self.phones]
        errors = self.errors
        lines += [
            "",
            f"{self.language}: {self.sentences} sentences, {self.boundaries} boundaries, "
            f"{len(errors) / max(self.boundaries, 1):.0%} of them found between the same phones",
        ]
        if len(errors):
            lines.append(
                f"boundary error against eSpeak NG's times: median {1000 * np.median(errors):.0f} ms, "
                f"mean {1000 * errors.mean():.0f} ms, within 20 ms {np.mean(errors <= 0.02):.0%}, "
                f"within 50 ms {np.mean(errors <= 0.05):.0%}"
            )
        lines.append(f"true texts that drew a warning: {self.warned} of {self.sentences}")
        return "\n".join(lines)


def check_language(asked: str | Path, sentences: Sequence[str] = ()) -> LanguageCheck:
    """Speak sentences with eSpeak NG, align the sound with the text, compare the times.

    Made speech of one engine, which also reads the text: it shows that the table is whole and the way through it
    holds, less about people.

    Parameters
    ----------
    asked : str or Path
        A tag, or a table of one's own.
    sentences : sequence of str
        What is spoken; its table's ``sample`` if none are given.

    Raises
    ------
    InputError
        If a phone is in none of its tables, the language has no voice, or there is nothing to speak.
    MissingPartError
        If eSpeak NG is not installed.

    Examples
    --------
    >>> check_language("it", ["Buongiorno."]).boundaries > 5
    True
    """
    language = find_language(asked)
    if language is None:
        raise InputError("English is read by its dictionary and has no table to check (docs/languages.md)")
    texts = tuple(sentences) or tuple(language.table.get("sample", ()))
    if not texts:
        raise InputError(f'the language {language.tag}: give sentences, or sample = ["..."] at the top of its table')
    if not language.espeak:
        raise InputError(f'the language {language.tag}: eSpeak NG has no voice for it (espeak = "VOICE" in its table)')
    phones: dict[str, str] = {}
    errors: list[float] = []
    boundaries = warned = 0
    for text in texts:
        for word in read_in(language, text).words:
            phones |= {phone: _made_of(phone, language) for phone in word.phones or ()}
        said = synthesise(text, voice=f"espeak-{language.tag}", language=asked)
        aligned = align(said.audio, text, language=asked)
        errors += boundary_errors(heard_phones(said, language), heard_phones(aligned, language))
        boundaries += len(heard_phones(said, language)) - 1
        warned += any(note.kind == "warning" for note in aligned.notes)
    return LanguageCheck(
        language.name, len(texts), tuple(sorted(phones.items())), boundaries, np.array(errors, np.float64), warned
    )


def heard_phones(utterance: Utterance, language: Language) -> list[Interval]:
    """Its phones as the acoustic model was asked for them, evenly cut where a phone is several."""
    found = []
    for phone in utterance.native or ():
        parts = (PAUSE,) if phone.label == PAUSE else heard_as((phone.label,), language)
        edges = np.linspace(phone.start, phone.end, len(parts) + 1).tolist()
        found += [Interval(a, b, label) for a, b, label in zip(edges[:-1], edges[1:], parts, strict=True)]
    return found


def boundary_errors(one: Sequence[Interval], other: Sequence[Interval]) -> Iterator[float]:
    """Seconds between boundaries whose neighbours are the same phones in both.

    Examples
    --------
    >>> a = [Interval(0, 0.1, "N"), Interval(0.1, 0.3, "OW")]
    >>> b = [Interval(0, 0.125, "N"), Interval(0.125, 0.3, "OW")]
    >>> [round(error, 3) for error in boundary_errors(a, b)]
    [0.025]
    """
    names, others = [p.label for p in one], [p.label for p in other]
    for block in SequenceMatcher(None, names, others, autojunk=False).get_matching_blocks():
        for k in range(1, block.size):
            yield abs(other[block.b + k].start - one[block.a + k].start)


def _made_of(phone: str, language: Language) -> str:
    parts = []
    for segment in language.segments(phone):
        heard = "" if segment.heard == segment.articulation else f", heard as {segment.heard}"
        shapes = f", shape {' '.join(segment.shapes)}" if segment.shapes else ""
        parts.append(f"{segment.articulation}{heard}{shapes}")
    return " + ".join(parts) or "no sound of its own"
