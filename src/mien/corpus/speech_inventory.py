"""What speech a corpus holds: minutes, phones and phone pairs, and which of them are missing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

from mien.core.timeline import Tier
from mien.text.phones import phone_table
from mien.text.pronunciation import dictionary_entries

__all__ = ["COMMON_PAIRS", "SpeechInventory", "common_pairs", "inventory_of"]

COMMON_PAIRS = 300
"""Phone pairs of the pronouncing dictionary, most frequent first, that are asked for."""
_NAMED = 8


@dataclass(frozen=True)
class SpeechInventory:
    """What was said.

    Attributes
    ----------
    takes : int
    seconds : float
        Of speech, without pauses.
    missing_phones : tuple of str
        Of the 39 English phones.
    pairs : int
        Kinds of phone pairs that were said.
    missing_pairs : tuple of str
        Of the `COMMON_PAIRS`, the most frequent first: ``"S T"``.
    """

    takes: int
    seconds: float
    missing_phones: tuple[str, ...]
    pairs: int
    missing_pairs: tuple[str, ...]

    @property
    def phones_line(self) -> str:
        """Phones in one line."""
        every = len(phone_table())
        none = f", none of {' '.join(self.missing_phones)}" if self.missing_phones else ""
        return f"{every - len(self.missing_phones)} of {every}{none}"

    @property
    def pairs_line(self) -> str:
        """Phone pairs in one line."""
        said = f"{self.pairs} kinds; {COMMON_PAIRS - len(self.missing_pairs)} of the {COMMON_PAIRS} most common"
        if not self.missing_pairs:
            return said
        more = f" and {len(self.missing_pairs) - _NAMED} more" if len(self.missing_pairs) > _NAMED else ""
        return f"{said}, none of {', '.join(self.missing_pairs[:_NAMED])}{more}"


def inventory_of(phones: Iterable[Tier]) -> SpeechInventory:
    """Count what some takes say.

    Parameters
    ----------
    phones : iterable of Tier
        ARPAbet phones of each take, pauses as other labels.

    Examples
    --------
    >>> from mien.core.timeline import Interval
    >>> said = inventory_of([Tier("phones", (Interval(0.0, 0.1, "S"), Interval(0.1, 0.2, "T")))])
    >>> len(said.missing_phones), said.pairs, "S T" in said.missing_pairs
    (37, 1, False)
    """
    known, takes, seconds = phone_table(), 0, 0.0
    singles: set[str] = set()
    pairs: set[tuple[str, str]] = set()
    for tier in phones:
        takes += 1
        seconds += sum(phone.duration for phone in tier if phone.label in known)
        singles |= {phone.label for phone in tier if phone.label in known}
        pairs |= {both for both in pairwise(p.label for p in tier) if both[0] in known and both[1] in known}
    missing = tuple(" ".join(both) for both in common_pairs() if both not in pairs)
    return SpeechInventory(takes, seconds, tuple(sorted(set(known) - singles)), len(pairs), missing)


@cache
def common_pairs() -> tuple[tuple[str, str], ...]:
    """The most frequent phone pairs of the pronouncing dictionary's words."""
    counts: Counter[tuple[str, str]] = Counter()
    for _, phones in dictionary_entries():
        counts.update(pairwise(phones))
    ranked = sorted(counts, key=lambda both: (-counts[both], both))
    return tuple(ranked[:COMMON_PAIRS])
