"""Phones and phone pairs that are there, and those that are not."""

from __future__ import annotations

from mien.core.timeline import Interval, Tier
from mien.corpus.speech_inventory import COMMON_PAIRS, common_pairs, inventory_of


def said(*labels: str) -> Tier:
    return Tier("phones", tuple(Interval(i / 10, (i + 1) / 10, label) for i, label in enumerate(labels)))


def test_what_is_missing_is_named_most_common_first() -> None:
    inventory = inventory_of([said("SIL", "S", "T", "AA", "SIL"), said("M", "AA")])
    assert (inventory.takes, round(inventory.seconds, 3), inventory.pairs) == (2, 0.5, 3)
    assert "35" not in inventory.phones_line
    assert inventory.phones_line.startswith("4 of 39, none of AE AH")
    assert "S T" not in inventory.missing_pairs
    assert list(inventory.missing_pairs) == [
        " ".join(p) for p in common_pairs() if " ".join(p) in inventory.missing_pairs
    ]
    assert f"of the {COMMON_PAIRS} most common, none of " in inventory.pairs_line
    assert "and 2" in inventory.pairs_line  # many more


def test_pairs_across_a_pause_are_none() -> None:
    assert inventory_of([said("S", "SIL", "T")]).pairs == 0
