"""Where the words and phones that a layer speaks of are in an utterance."""

from __future__ import annotations

from functools import cached_property

from mien.animation.edits.edited_line import Line, LineWord, line_of, matched_phones, matched_words
from mien.animation.edits.layer import Anchor, EditLayer, Place
from mien.core.utterance import Utterance

__all__ = ["Gone", "Places"]


class Gone(Exception):  # noqa: N818 - not a fault: the line has changed
    """What an edit is tied to is not in the line any more."""


class Places:
    """Finds anchors and borders.

    Parameters
    ----------
    layer : EditLayer
    utterance : Utterance
    """

    def __init__(self, layer: EditLayer, utterance: Utterance) -> None:
        self._phones = utterance.phones.intervals
        self._words = utterance.words.intervals
        self._now = line_of(utterance)
        self._then: Line = self._now.line if layer.line is None else layer.line

    @cached_property
    def _became(self) -> dict[int, int]:
        return matched_words(self._then, self._now.line)

    def seconds(self, anchor: Anchor) -> float:
        """The instant of an anchor; where the pause it lies in is gone, the end of the word before.

        Raises
        ------
        Gone
            If its word or phone is not there any more.
        """
        word = self._word(anchor.place)
        number = self._number(anchor.place, word)
        if number is None:
            return self._words[word - 1].end if word else 0.0
        phone = self._phones[number]
        return phone.end if anchor.share == 1 else phone.start + anchor.share * phone.duration

    def border(self, place: Place, edge: str) -> int:
        """The border at an edge of a phone: the number of the phone that begins there.

        Raises
        ------
        Gone
            If the phone is not there any more, or the border is an end of the sound.
        """
        number = self._number(place, self._word(place))
        if number is None:
            raise Gone(f"{place} is gone")
        border = number if edge == "start" else number + 1
        if border in (0, len(self._phones)):
            raise Gone(f"the {edge} of {place} is the {edge} of the sound, which stays")
        return border

    def _word(self, place: Place) -> int:
        """The entry of the present line that a place's word has become."""
        if place.word is None:
            return 0
        named = [number for number, entry in enumerate(self._then) if entry.word == place.word]
        if len(named) < place.occurrence:
            held = f"it has {len(named)}" if named else "it has none"
            raise Gone(f"the line the edits were made on has no word {place.word!r} number {place.occurrence}: {held}")
        then = named[place.occurrence - 1]
        if then not in self._became:
            raise Gone(f"the word {place.word!r} is not in the line any more")
        return self._became[then]

    def _number(self, place: Place, word: int) -> int | None:
        """The place in the phone tier; None for a pause that is gone."""
        then = self._then_of(place)
        if place.pause:
            if place.index >= len(then.pauses):
                raise Gone(f"the line the edits were made on has no {place}")
            own = self._now.pauses[word]
            return own[place.index] if place.index < len(own) else None
        if place.index >= len(then.phones):
            raise Gone(f"the line the edits were made on has no {place}: the word has {len(then.phones)} phones")
        became = matched_phones(then.phones, self._now.line[word].phones)
        if place.index not in became:
            raise Gone(f"{place}, {then.phones[place.index]}, is not spoken any more")
        return self._now.phones[word][became[place.index]]

    def _then_of(self, place: Place) -> LineWord:
        named = [entry for entry in self._then if entry.word == place.word]
        return named[place.occurrence - 1]
