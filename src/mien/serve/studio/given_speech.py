"""`GivenTimes`: words and phones that a person relabelled, split, joined or inserted, over the sound as it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from mien.core.errors import InputError, Note
from mien.core.timeline import Interval, Tier
from mien.core.utterance import Utterance
from mien.serve.studio.field_error import FieldError
from mien.speech.given_times import spoken_as_given

__all__ = ["GivenTimes", "as_corrected", "times_of_tiers"]

Spans = tuple[tuple[float, float, str], ...]
_MOST = 5000
_LONGEST = 60


@dataclass(frozen=True)
class GivenTimes:
    """Corrected tiers: begin and end in seconds, label.

    Attributes
    ----------
    words, phones : tuple of (float, float, str)
        Phones are those of the language, pauses ``SIL``.
    """

    words: Spans
    phones: Spans

    @classmethod
    def of(cls, asked: Any) -> GivenTimes:
        """Read from JSON.

        Raises
        ------
        InputError
            If it does not hold together.
        """
        if not isinstance(asked, dict):
            raise InputError('expected {"words": [[begin, end, label], ...], "phones": [...]}')
        return cls(*(_spans(asked.get(name), name) for name in ("words", "phones")))

    def plain(self) -> dict[str, Any]:
        """As JSON."""
        return {"words": [list(span) for span in self.words], "phones": [list(span) for span in self.phones]}


def _spans(asked: Any, name: str) -> Spans:
    if not isinstance(asked, (list, tuple)) or not 0 < len(asked) <= _MOST:
        raise InputError(f"expected 1 to {_MOST} {name}")
    spans = []
    for span in asked:
        if not isinstance(span, (list, tuple)) or len(span) != 3 or not isinstance(span[2], str):
            raise InputError(f"one of the {name} is no [begin, end, label]")
        begin, end, label = span
        if any(isinstance(at, bool) or not isinstance(at, (int, float)) for at in (begin, end)) or not 0 <= begin < end:
            raise InputError(f"one of the {name} does not begin before it ends")
        spans.append((float(begin), float(end), label.strip()[:_LONGEST]))
    if any(not label for _, _, label in spans):
        raise InputError(f"one of the {name} has no name")
    Tier(name, tuple(Interval(*span) for span in spans))  # in order
    return tuple(spans)


def as_corrected(utterance: Utterance, times: GivenTimes) -> Utterance:
    """An utterance with corrected words and phones; stretched with the sound where that has another length by now.

    Raises
    ------
    FieldError
        If a label is no phone of the language, or the tiers do not fit together.
    """
    share = utterance.duration / max(times.phones[-1][1], times.words[-1][1])

    def tier(name: str, spans: Spans) -> Tier:
        return Tier(name, tuple(Interval(begin * share, end * share, label) for begin, end, label in spans))

    language = None if utterance.native is None else utterance.language
    tiers = tier("words", times.words), tier("phones", times.phones)
    try:
        given = spoken_as_given(utterance.audio, tiers, language=language)
    except InputError as problem:
        raise FieldError("times", str(problem)) from problem
    told = Note("note", "words and phones are as they were given, not as they were found")
    notes = (*utterance.notes, told, *(note for note in given.notes if note.kind != "note"))
    return replace(given, text=utterance.text, language=utterance.language, notes=notes)


def times_of_tiers(utterance: Utterance, tiers: Sequence[Tier], language: str | None) -> dict[str, Any]:
    """The words and phones of a TextGrid, as `GivenTimes.of` reads them.

    Raises
    ------
    FieldError
        If they are not those of this sound.
    """
    try:
        given = spoken_as_given(utterance.audio, tiers, language=language)
    except InputError as problem:
        raise FieldError("sound", f"the TextGrid does not fit: {problem}") from problem
    found = {"words": given.words, "phones": given.spelled_phones}
    return {name: [[one.start, one.end, one.label] for one in tier] for name, tier in found.items()}
