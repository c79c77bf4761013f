"""Where the phones of a text lie in a sound: the likeliest way through the text's pronunciations, for any length.

Viterbi's algorithm over what a network says of each row (`mien.speech.frame_classifier`). Words follow one another with
or without a pause; a word has one or more pronunciations; a phone lasts `SHORTEST` rows or longer, a diphthong twice
that. Where one vowel is heard, others are not much less likely: speakers differ in them. Between words there
may be speech that the text does not have: any phones, each row a little less likely than the likeliest one, so that
words left out of a text do not pull their neighbours apart. Only what lies within `BEAM` of the best way is followed,
and what is older than half a minute is settled: time and memory grow with length and no faster.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mien.core.utterance import PAUSE
from mien.speech.connected_speech import leaves_out, loses_its_first, together
from mien.text.phones import is_vowel
from mien.text.pronunciation import Pronunciation

__all__ = ["BEAM", "OTHER", "SHORTEST", "Found", "TextGraph", "search"]

OTHER = "?"
"""Label of speech that the text does not have."""
SHORTEST = 3
BEAM = 400.0
"""Natural logarithm; no true way was seen that far below the best."""
OTHER_ROW, OTHER_START = 2.5, 15.0
"""What a row of other speech costs, and what its beginning costs."""
DIPHTHONGS = ("AW", "AY", "EY", "OW", "OY")
OTHER_VOWEL = 2.5
"""How much less likely than the likeliest vowel any other is at most (natural logarithm)."""
_SETTLE = 2000  # rows after which what lies far back is settled

Single = NDArray[np.float32]


@dataclass(frozen=True)
class Found:
    """A phone, a pause or other speech: its rows from ``first`` to before ``last``; ``word`` is -1 outside words.

    ``goes_on``: the second half of what the one before it begins; nothing of a whole way does.
    """

    label: str
    word: int
    first: int
    last: int
    goes_on: bool = False


class _Spoken(NamedTuple):
    """A pronunciation and where its phones begin among all."""

    phones: Pronunciation
    nodes: list[int]


class TextGraph:
    """Which phone may follow which.

    Parameters
    ----------
    choices : sequence of sequences of tuple of str
        The pronunciations of each word.
    labels : sequence of str
        In the order of the columns of what is heard; the search adds one for `OTHER`.
    connected : bool
        Whether words may change where they meet, as in English (`mien.speech.connected_speech`).
    """

    def __init__(
        self, choices: Sequence[Sequence[Pronunciation]], labels: Sequence[str], connected: bool = False
    ) -> None:
        index = {label: number for number, label in enumerate((*labels, OTHER))}
        self.labels: list[str] = []
        self.words: list[int] = []
        self.goes_on: list[bool] = []
        before: list[list[int]] = []

        def add(label: str, word: int, preceding: Sequence[int], goes_on: bool = False) -> int:
            self.labels.append(label)
            self.words.append(word)
            self.goes_on.append(goes_on)
            before.append(list(preceding))
            return len(before) - 1

        def gap(ends: Sequence[int]) -> list[int]:
            pause, other = add(PAUSE, -1, ends), add(OTHER, -1, ends)
            before[pause].append(other)
            before[other].append(pause)
            return [*ends, pause, other]

        def meet(tail: _Spoken, head: _Spoken) -> None:
            last, following = tail.phones[-1], head.phones[0]
            if len(head.phones) > 1 and (joint := together(last, following)):
                both = add(joint, words[tail.nodes[-1]], before[tail.nodes[-1]])
                before[head.nodes[1]].append(both)
            if len(head.phones) > 1 and loses_its_first(last, following):
                before[head.nodes[1]].append(tail.nodes[-1])
            if len(tail.phones) > 1 and leaves_out(tail.phones[-2], last, following):
                before[head.nodes[0]].append(tail.nodes[-2])

        words = self.words
        ends, tails = gap([-1]), list[_Spoken]()
        for number, pronunciations in enumerate(choices):
            lasts, heads = [], list[_Spoken]()
            for phones in pronunciations:
                preceding, nodes = ends, list[int]()
                for phone in phones:
                    preceding = [add(phone, number, preceding)]
                    nodes += preceding
                    if phone in DIPHTHONGS:
                        preceding = [add(phone, number, preceding, True)]
                lasts += preceding
                heads.append(_Spoken(phones, nodes))
            for tail, head in product(tails, heads) if connected else ():
                meet(tail, head)
            ends, tails = gap(lasts), heads
        vowels = [number for label, number in index.items() if is_vowel(label)]
        self.vowels = np.array(vowels, dtype=np.intp)
        self.columns = np.array([index[label] for label in self.labels])
        self.starts = np.array([-1 in row for row in before])
        self.ends = np.array([place for place in ends if place >= 0])
        rows = [[place for place in row if place >= 0] for row in before]
        width = max(map(len, rows))
        self.before = np.array([row + [-1] * (width - len(row)) for row in rows])
        self.reach = _reach(rows)
        """The last phone that may follow any phone up to this one."""


def _reach(before: Sequence[Sequence[int]]) -> NDArray[np.intp]:
    """The last place that may follow any up to each one, shape (places,)."""
    after = list(range(len(before)))
    for place, row in enumerate(before):
        for earlier in row:
            after[earlier] = max(after[earlier], place)
    return np.maximum.accumulate(np.array(after, dtype=np.intp))


def search(heard: Single, graph: TextGraph, beam: float = BEAM) -> list[Found] | None:
    """The likeliest way through a text.

    Parameters
    ----------
    heard : ndarray, shape (rows, labels)
        Log likelihood of each label in each row.
    graph : TextGraph
    beam : float
        Ways further below the best one are given up.

    Returns
    -------
    list of Found or None
        In order, without gaps; None if no way through the whole text is left at the end of the sound.
    """
    ways = _Ways(graph, beam)
    for row in heard:
        said = np.append(row, row.max() - np.float32(OTHER_ROW))
        vowels = said[graph.vowels]
        said[graph.vowels] = np.maximum(vowels, vowels.max(initial=-np.inf) - np.float32(OTHER_VOWEL))
        ways.step(said)
    return _whole(ways.end())


def _whole(found: list[Found] | None) -> list[Found] | None:
    """Halves made one."""
    if found is None:
        return None
    made: list[Found] = []
    for part in found:
        if part.goes_on:
            made[-1] = replace(made[-1], last=part.last)
        else:
            made.append(part)
    return made


class _Ways:
    """The ways that are followed: phones ``low`` to before ``high`` in each of `SHORTEST` stages."""

    def __init__(self, graph: TextGraph, beam: float) -> None:
        self.graph, self.beam = graph, beam
        self.low, self.high = 0, 0
        self.scores = np.zeros((SHORTEST, 0), np.float32)
        self.steps: list[tuple[int, NDArray[np.int8], NDArray[np.bool_]]] = []
        self.row = 0
        self.settled: list[Found] = []
        self.first = 0  # row of the first step that is kept
        self.cost = np.where(np.array(graph.labels) == OTHER, np.float32(OTHER_START), np.float32(0))

    def step(self, heard: Single) -> None:
        graph = self.graph
        low, high = self.low, self.high
        if self.row == 0:
            top = int(np.flatnonzero(graph.starts).max()) + 1
        else:
            top = int(graph.reach[high - 1]) + 1
        last = np.full(top - low + 1, -np.inf, np.float32)  # the last place is "no phone"
        last[: high - low] = self.scores[-1]
        before = graph.before[low:top] - low
        before = np.where((before < 0) | (before >= high - low), top - low, before)
        entering = last[before]
        source = entering.argmax(axis=1)
        new = np.full((SHORTEST, top - low), -np.inf, np.float32)
        new[0] = entering[np.arange(top - low), source]
        if self.row == 0:
            new[0] = np.where(graph.starts[low:top], np.float32(0), np.float32(-np.inf))
        new[0] -= self.cost[low:top]
        new[1:, : high - low] = self.scores[:-1]
        stayed = np.zeros(top - low, bool)
        stayed[: high - low] = self.scores[-1] >= new[-1, : high - low]
        new[-1] = np.maximum(new[-1], last[:-1])
        new += heard[graph.columns[low:top]]
        best = new.max()
        new -= best
        alive = np.flatnonzero(new.max(axis=0) > -self.beam)
        first, after = int(alive[0]), int(alive[-1]) + 1
        new[new < -self.beam] = -np.inf
        self.scores = new[:, first:after]
        self.steps.append((low + first, source[first:after].astype(np.int8), stayed[first:after]))
        self.low, self.high = low + first, low + after
        self.row += 1
        if len(self.steps) >= 2 * _SETTLE:
            self._settle()

    def end(self) -> list[Found] | None:
        """The best way to the end of the text."""
        ends = self.graph.ends[(self.graph.ends >= self.low) & (self.graph.ends < self.high)]
        if not len(ends) or not np.isfinite(self.scores[-1, ends - self.low].max()):
            return None
        best = int(ends[self.scores[-1, ends - self.low].argmax()])
        self._keep(best, SHORTEST - 1, len(self.steps))
        return self.settled

    def _settle(self) -> None:
        """Settle the first half of the rows that are kept, on the best way; ways that disagree are given up."""
        stages, places = np.nonzero(np.isfinite(self.scores))
        scores = self.scores[stages, places]
        at_stage, at_phone = stages.copy(), places + self.low
        for low, source, stayed in self.steps[:_SETTLE:-1]:
            final = at_stage == SHORTEST - 1
            stay = final & stayed[at_phone - low]
            new = (at_stage == 0) & ~stay
            came = self.graph.before[at_phone, source[at_phone - low]]
            at_stage = np.where(stay, at_stage, np.where(new, SHORTEST - 1, at_stage - 1))
            at_phone = np.where(new, came, at_phone)
        best = int(scores.argmax())
        other = (at_stage != at_stage[best]) | (at_phone != at_phone[best])
        self.scores[stages[other], places[other]] = -np.inf
        self._keep(int(at_phone[best]), int(at_stage[best]), _SETTLE + 1)
        del self.steps[: _SETTLE + 1]
        self.first += _SETTLE + 1

    def _keep(self, phone: int, stage: int, last: int) -> None:
        """Add the way to a phone, as it stands before step ``last``, to what is settled."""
        found: list[Found] = []
        labels, words, row = self.graph.labels, self.graph.words, last
        while row > 0:
            row -= 1
            low, source, stayed = self.steps[row]
            if stage == SHORTEST - 1 and stayed[phone - low]:
                continue
            if stage > 0:
                stage -= 1
                continue
            begun = Found(labels[phone], words[phone], self.first + row, self.first + last, self.graph.goes_on[phone])
            found.append(begun)
            last, stage = row, SHORTEST - 1
            phone = int(self.graph.before[phone, source[phone - low]])
        if last > 0:  # it began in what was settled before
            self.settled[-1] = replace(self.settled[-1], last=self.first + last)
        self.settled += found[::-1]
