from __future__ import annotations

import numpy as np
import pytest

from mien.metrics.repetitions import LEAST, Repetitions
from mien.metrics.scored_takes import prepare
from mien.metrics.trajectory import correlation, separation
from tests.metrics.synthetic import spoken


def test_a_word_is_told_from_its_other_repetitions_at_its_own_times() -> None:
    others = [prepare(spoken(f"slow{i}", ("ma", "tea", "ma"), duration=0.2)) for i in range(LEAST)]
    quick = prepare(spoken("quick", ("ma", "tea", "ma"), duration=0.14))
    mouth, known = Repetitions([*others, quick]).mouth(quick)
    assert known[quick.speech].all()
    recorded, told = (separation(p, *quick.sites.opening)[quick.speech] for p in (quick.positions, mouth))
    assert correlation(recorded, told) > 0.97
    assert np.abs(recorded - told).mean() < 0.8


def test_a_take_never_tells_itself() -> None:
    alone = [prepare(spoken(f"t{i}", (word,))) for i, word in enumerate(("ma", "tea", "me"))]
    _, known = Repetitions(alone).mouth(alone[0])
    assert not known.any()


def test_the_closest_company_is_asked_first() -> None:
    def lifted(name: str, words: tuple[str, ...], rise: float):  # type: ignore[no-untyped-def]
        take = spoken(name, words)
        object.__setattr__(take.markers, "positions", take.markers.positions + rise)
        return prepare(take)

    same = [lifted(f"same{i}", ("tea", "ma"), 1.0) for i in range(LEAST)]
    far = [lifted(f"far{i}", ("me", "ma"), 100.0) for i in range(9)]
    asked = lifted("asked", ("tea", "ma"), 0.0)
    mouth, _ = Repetitions([*same, *far, asked]).mouth(asked)
    rise = (mouth - asked.positions)[asked.inside({"ma"})].mean()
    assert rise == pytest.approx(1.0, abs=0.5)
