from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.utterance import PAUSE
from mien.speech.aligned_phone import AlignedPhone
from mien.speech.transcript_doubts import _poor_runs, doubts, misfits, noise_below
from mien.text.normalisation import spoken_words

RATE = 16_000
WORDS = "seven again one two three four five"


def speech_like(seconds: float, silent: tuple[float, float] | None = None) -> Audio:
    samples: NDArray[np.float64] = np.random.default_rng(0).normal(0, 0.1, round(seconds * RATE))
    if silent:
        samples[round(silent[0] * RATE) : round(silent[1] * RATE)] *= 1e-4
    return Audio(samples, RATE)


def row(scores: list[float], phones_per_word: int = 4, pause_before: float = 0.0) -> list[AlignedPhone]:
    """Phones of 0.1 s with given scores, after a pause."""
    phones = [AlignedPhone(PAUSE, 0.0, pause_before, -1, -0.2)] if pause_before else []
    for i, score in enumerate(scores):
        start = pause_before + 0.1 * i
        phones.append(AlignedPhone("AH", start, start + 0.1, i // phones_per_word, score))
    return phones


def test_good_scores_raise_no_doubt() -> None:
    assert misfits(speech_like(2.8), row([-0.4] * 28)) == []


def test_one_odd_phone_raises_no_doubt() -> None:
    assert misfits(speech_like(2.8), row([-0.4] * 10 + [-40.0] + [-0.4] * 17)) == []


def test_a_bad_run_is_named_with_its_words() -> None:
    spoken = spoken_words(WORDS)
    note = doubts(speech_like(2.8), spoken, row([-4.0] * 10 + [-0.2] * 18))[-1]
    assert note.kind == "warning"
    assert note.message.startswith("the text does not seem to fit the sound between 0.00 s")
    assert "'seven again one" in note.message
    assert "five" not in note.message


def test_words_laid_on_silence_are_named() -> None:
    (misfit,) = misfits(speech_like(2.8, silent=(0.78, 1.64)), row([-0.4] * 28))
    assert misfit.kind == "words on silence"
    assert (misfit.first_word, misfit.last_word) == (2, 3)


def test_speech_in_a_pause_is_named() -> None:
    first, *others = row([-0.4] * 28, pause_before=1.0)
    (misfit,) = misfits(speech_like(3.8), [replace(first, other=0.9), *others])
    assert (misfit.kind, misfit.start, misfit.end) == ("speech without words", 0.0, 1.0)
    assert misfits(speech_like(3.8), [replace(first, other=0.1), *others]) == []


def test_noise_is_told_by_the_pauses() -> None:
    samples = np.random.default_rng(0).normal(0, 0.1, round(3.8 * RATE))
    samples[:RATE] *= 10 ** (-10 / 20)
    phones = row([-0.4] * 28, pause_before=1.0)
    assert noise_below(Audio(samples, RATE), phones) == pytest.approx(9.5, abs=0.7)
    (note,) = doubts(Audio(samples, RATE), spoken_words(WORDS), phones)
    assert (note.kind, "seems noisy" in note.message) == ("note", True)


def test_a_quiet_pause_raises_no_doubt() -> None:
    assert misfits(speech_like(3.8, silent=(0.0, 1.0)), row([-0.4] * 28, pause_before=1.0)) == []


def test_phones_that_are_each_a_little_unlikely_add_up() -> None:
    scores = [-0.5] * 12 + [-2.4] * 14 + [-0.5] * 12
    assert not _poor_runs(_row(scores[:12]), -2.6)
    found = _poor_runs(_row(scores), -2.6)
    assert [(misfit.first_word, misfit.last_word) for misfit in found] == [(12, 25)]


def test_one_odd_phone_does_not_add_up() -> None:
    assert not _poor_runs(_row([-0.5] * 9 + [-30.0] + [-0.5] * 9), -2.6)


def _row(scores: list[float]) -> list[AlignedPhone]:
    return [AlignedPhone("AA", 0.1 * n, 0.1 * n + 0.1, n, score, 0.0) for n, score in enumerate(scores)]
