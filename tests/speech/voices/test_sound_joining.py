"""Joining sentences: silence, level, pauses and shifted times."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from mien.core.timeline import Interval
from mien.core.utterance import PAUSE
from mien.speech.voices.sentences import Sentence, Word
from mien.speech.voices.sound_joining import LEVEL, Piece, join_pieces

RATE = 8000


def om(mark: str) -> Sentence:
    return Sentence((Word("om", ("AA", "M"), mark),))


def piece(before: float, tone: float, after: float, mark: str = ".", level: float = 0.1) -> Piece:
    sine = level * np.sin(2 * np.pi * 200 * np.arange(round(tone * RATE)) / RATE)
    samples = np.concatenate([np.zeros(round(before * RATE)), sine, np.zeros(round(after * RATE))])
    half = before + tone / 2
    phones = (Interval(before, half, "AA"), Interval(half, before + tone, "M"))
    return Piece(samples, RATE, phones, (Interval(before, before + tone, "om"),), om(mark))


def test_times_follow_the_sound_through_trimming_and_joining() -> None:
    speech = join_pieces([piece(0.5, 0.4, 0.7), piece(0.1, 0.3, 0.0)])
    assert speech.phones is not None
    assert speech.words is not None
    samples = speech.audio.samples
    for word in speech.words:
        inside = samples[round(word.start * RATE) + 10 : round(word.end * RATE) - 10]
        assert np.sqrt(np.mean(inside**2)) > 0.4
    for pause in (p for p in speech.phones if p.label == PAUSE):
        quiet = samples[round(pause.start * RATE) + 10 : round(pause.end * RATE) - 10]
        assert np.abs(quiet).max() < 0.01


def test_phones_cover_the_whole_sound_without_gaps() -> None:
    speech = join_pieces([piece(0.5, 0.4, 0.7, "?"), piece(0.0, 0.3, 0.2)])
    assert speech.phones is not None
    phones = speech.phones.intervals
    assert phones[0].start == 0
    assert phones[-1].end == pytest.approx(speech.audio.duration)
    assert all(one.end == pytest.approx(two.start) for one, two in itertools.pairwise(phones))
    assert [p.label for p in phones] == [PAUSE, "AA", "M", PAUSE, "AA", "M", PAUSE]


def test_ends_are_short_silences_and_marks_set_the_pauses() -> None:
    def gap(mark: str) -> float:
        speech = join_pieces([piece(1.0, 0.4, 1.0, mark), piece(1.0, 0.4, 1.0)])
        assert speech.words is not None
        first, second = speech.words.intervals
        assert 0.1 <= first.start <= 0.3
        assert 0.1 <= speech.audio.duration - second.end <= 0.3
        return second.start - first.end

    assert gap(".") > gap(",") > gap("") > 0


@pytest.mark.parametrize("level", [0.001, 0.9, 5.0])
def test_peak_is_three_decibels_below_full_scale(level: float) -> None:
    speech = join_pieces([piece(0.1, 0.4, 0.1, level=level)])
    assert np.abs(speech.audio.samples).max() == pytest.approx(LEVEL, rel=0.01)


def test_without_times_there_are_no_tiers() -> None:
    bare = Piece(piece(0.1, 0.2, 0.1).samples, RATE, (), (), om("."))
    speech = join_pieces([bare])
    assert speech.phones is None
    assert speech.words is None


def test_one_sentence_without_times_takes_them_from_all() -> None:
    bare = Piece(piece(0.1, 0.2, 0.1).samples, RATE, (), (), om("."))
    speech = join_pieces([piece(0.1, 0.2, 0.1), bare])
    assert speech.phones is None
    assert speech.words is None


def test_a_silent_piece_stays_silent() -> None:
    speech = join_pieces([Piece(np.zeros(800), RATE, (), (), om("."))])
    assert not speech.audio.samples.any()


def test_breaks_stand_in_the_pauses_and_count_the_words() -> None:
    speech = join_pieces([piece(0.5, 0.4, 0.7), piece(0.1, 0.3, 0.2, "?"), piece(0.1, 0.3, 0.2)])
    assert speech.phones is not None
    assert [pause.words for pause in speech.breaks] == [1, 2]
    assert all(
        phone is not None and phone.label == PAUSE
        for phone in map(speech.phones.at, (b.seconds for b in speech.breaks))
    )
