"""What was heard in learning: which triphones, diphones and pairs of viseme classes, and how often."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Literal, Self

from mien.core.timeline import Tier
from mien.core.utterance import PAUSE
from mien.motion.mouth.articulation import articulation_table

__all__ = ["Coverage", "Evidence", "heard_phones"]

Evidence = Literal["triphone", "diphone", "class", "none"]
"""What a pair of phones rests on; ``none``: neither it nor a pair that looks alike was met often enough."""


class Coverage:
    """Counts of phone sequences.

    Parameters
    ----------
    least : int
        How often a sequence must have been met to count as known.

    Attributes
    ----------
    triphones_, diphones_, classes_ : dict of tuple of str to int

    Examples
    --------
    >>> from mien.core.timeline import Interval
    >>> def tier(*labels):
    ...     return Tier("phones", tuple(Interval(i, i + 1, label) for i, label in enumerate(labels)))
    >>> known = Coverage(least=1).fit([tier("B", "AA", "T")])
    >>> known.of_pairs(["B", "AA", "T"]), known.of_pairs(["P", "AA", "D"]), known.of_pairs(["AA", "S"])
    (('triphone', 'triphone'), ('class', 'class'), ('none',))
    """

    def __init__(self, least: int = 3) -> None:
        self.least = least

    def fit(self, tiers: Sequence[Tier]) -> Self:
        """Count."""
        triphones: Counter[tuple[str, ...]] = Counter()
        diphones: Counter[tuple[str, ...]] = Counter()
        for tier in tiers:
            labels = [phone.label for phone in tier]
            triphones.update(zip(labels, labels[1:], labels[2:], strict=False))
            diphones.update(pairwise(labels))
        return self.restore(triphones, diphones)

    def restore(self, triphones: Mapping[tuple[str, ...], int], diphones: Mapping[tuple[str, ...], int]) -> Self:
        """Take counts that were made before."""
        viseme = articulation_table().viseme_of
        classes: Counter[tuple[str, ...]] = Counter()
        for pair, count in diphones.items():
            classes[tuple(viseme(phone) for phone in pair)] += count
        self.triphones_ = dict(sorted(triphones.items()))
        self.diphones_ = dict(sorted(diphones.items()))
        self.classes_ = dict(sorted(classes.items()))
        return self

    def joined(self, other: Coverage) -> Coverage:
        """What either has heard."""
        counts = [
            Counter(one) + Counter(two)
            for one, two in ((self.triphones_, other.triphones_), (self.diphones_, other.diphones_))
        ]
        return Coverage(self.least).restore(*counts)

    def of_pairs(self, labels: Sequence[str]) -> tuple[Evidence, ...]:
        """For each pair of neighbours the strongest evidence: a known triphone that holds it, itself, its classes."""
        return tuple(self._of_pair(labels, place) for place in range(len(labels) - 1))

    def _of_pair(self, labels: Sequence[str], place: int) -> Evidence:
        around = [tuple(labels[start : start + 3]) for start in (place - 1, place) if start >= 0]
        if any(self.triphones_.get(triphone, 0) >= self.least for triphone in around):
            return "triphone"
        pair = (labels[place], labels[place + 1])
        if self.diphones_.get(pair, 0) >= self.least:
            return "diphone"
        viseme = articulation_table().viseme_of
        if self.classes_.get((viseme(pair[0]), viseme(pair[1])), 0) >= self.least:
            return "class"
        return "none"


def heard_phones(coverage: Coverage) -> dict[str, int]:
    """How often each of the 39 phones was heard in learning; the pause is left out.

    Counted from the pairs: as often as a phone begins one or ends one, whichever is more.
    """
    first: Counter[str] = Counter()
    second: Counter[str] = Counter()
    for (a, b), count in coverage.diphones_.items():
        first[a] += count
        second[b] += count
    return {phone: max(first[phone], second[phone]) for phone in articulation_table().parts if phone != PAUSE}
