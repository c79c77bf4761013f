"""A voice goes with what is felt: in the published directions, by as much as is felt, where and when it is felt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core.audio import Audio
from mien.core.emotions import emotions
from mien.core.timeline import Interval, Tier
from mien.core.utterance import Utterance
from mien.emotion.emotion_classifier import NEUTRAL
from mien.emotion.emotional_voice import FIGURES, Kept, with_feeling
from mien.motion.performer import Performer
from mien.speech.pitch import pitch_contour
from mien.text.intensity import IntensityCurve
from mien.text.score import UNDIRECTED, EmotionSpan, Score

RATE = 16_000
TABLE = {name: table["voice"] for name, table in emotions().items() if "voice" in table}


def felt(
    name: str, intensity: float | IntensityCurve = 1.0, start: float | None = None, end: float | None = None
) -> Score:
    return Score((EmotionSpan(name, intensity, start, end),))


@pytest.fixture(scope="module")
def line() -> Utterance:
    """Two words with a pause between them, hummed up and down."""
    times = np.arange(round(3.0 * RATE)) / RATE
    pitch = 160 * 2 ** (2 * np.sin(2 * np.pi * 1.3 * times) / 12)
    phase = 2 * np.pi * np.cumsum(pitch) / RATE
    wave = sum(np.sin(n * phase) / n for n in range(1, 20)) * 0.1
    wave[round(1.4 * RATE) : round(1.8 * RATE)] = 0.0
    words = Tier("words", (Interval(0.1, 1.4, "nanna"), Interval(1.8, 2.9, "mama")))
    phones = Tier(
        "phones",
        (Interval(0, 0.1, "SIL"), Interval(0.1, 0.5, "N"), Interval(0.5, 1.4, "AE"), Interval(1.4, 1.8, "SIL"),
         Interval(1.8, 2.2, "M"), Interval(2.2, 2.9, "AA"), Interval(2.9, 3.0, "SIL")),
    )  # fmt: skip
    return Utterance("Nanna, mama.", Audio(wave, RATE), words, phones, "en-US", "aligned")


def heard(utterance: Utterance) -> dict[str, float]:
    contour = pitch_contour(utterance.audio)
    height = contour.semitones(100.0)[contour.voiced]
    word = utterance.words.intervals[0]
    return {
        "pitch": float(np.median(height)),
        "range": float(np.percentile(height, 85) - np.percentile(height, 15)),
        "rate": 1 / word.duration,
        "pauses": utterance.phones.intervals[3].duration,
        "level": 10 * np.log10(float((utterance.audio.samples.astype(np.float64) ** 2).mean())),
    }


@pytest.mark.parametrize("emotion", sorted(TABLE))
def test_what_is_measured_moves_as_the_table_says(line: Utterance, emotion: str) -> None:
    plain, moved = heard(line), heard(with_feeling(line, felt(emotion)))
    asked = FIGURES | TABLE[emotion]
    assert moved["pitch"] - plain["pitch"] == pytest.approx(asked["pitch"], abs=2.0)
    assert moved["rate"] / plain["rate"] == pytest.approx(asked["rate"], rel=0.03)
    assert moved["pauses"] / plain["pauses"] == pytest.approx(asked["pauses"], rel=0.1)
    if abs(asked["level"]) >= 2:
        assert np.sign(moved["level"] - plain["level"]) == np.sign(asked["level"])
    if abs(np.log(asked["range"])) > 0.2:
        assert np.sign(moved["range"] - plain["range"]) == np.sign(asked["range"] - 1)


def test_every_emotion_of_the_face_but_neutral_has_a_voice() -> None:
    assert set(TABLE) == set(Performer.hand_made().expression.names) - {NEUTRAL}
    assert all(set(row) <= set(FIGURES) for row in TABLE.values())


def test_words_and_phones_keep_to_the_sound(line: Utterance) -> None:
    moved = with_feeling(line, felt("sad"))
    assert [word.label for word in moved.words] == [word.label for word in line.words]
    assert moved.phones.intervals[0].start == 0
    assert moved.phones.intervals[-1].end == moved.duration
    for before, after in zip(moved.phones.intervals, moved.phones.intervals[1:], strict=False):
        assert before.end == pytest.approx(after.start)
    pause = moved.phones.intervals[3]
    inside = moved.audio.samples[round((pause.start + 0.05) * RATE) : round((pause.end - 0.05) * RATE)]
    assert np.abs(inside).max() < 0.02  # the pause of the tier is the pause of the sound


def test_half_as_much_is_felt_half_as_much_is_heard(line: Utterance) -> None:
    plain, full = heard(line), heard(with_feeling(line, felt("afraid")))
    for half in (with_feeling(line, felt("afraid", 0.5)), with_feeling(line, felt("afraid"), amount=0.5)):
        assert heard(half)["pitch"] - plain["pitch"] == pytest.approx((full["pitch"] - plain["pitch"]) / 2, abs=0.4)


def test_without_feeling_the_same_voice_bit_for_bit(line: Utterance) -> None:
    for same in (
        with_feeling(line, UNDIRECTED),
        with_feeling(line, felt("neutral")),
        with_feeling(line, felt("sad", 0.0)),
        with_feeling(line, felt("sad"), amount=0.0),
    ):
        assert same.audio == line.audio
        assert same.phones == line.phones


def test_only_while_it_is_felt_and_seconds_are_those_of_the_result(line: Utterance) -> None:
    moved = with_feeling(line, UNDIRECTED, felt("sad", start=2.2))
    assert moved.words.intervals[0] == line.words.intervals[0]
    assert moved.words.intervals[1].duration > 1.1 * line.words.intervals[1].duration
    before = round(1.9 * RATE)
    assert np.corrcoef(moved.audio.samples[:before], line.audio.samples[:before])[0, 1] > 0.99
    rising = with_feeling(line, felt("afraid", IntensityCurve((0.0, 1.4, 2.2), (0.0, 0.0, 1.0))))
    contour = pitch_contour(rising.audio)
    word = rising.words.intervals[1]
    late = (contour.times > word.start + 0.4) & (contour.times < word.end)
    early = contour.times < rising.words.intervals[0].end
    assert np.nanmedian(contour.semitones(160.0)[late]) > np.nanmedian(contour.semitones(160.0)[early]) + 3


def test_what_the_user_has_set_is_left_alone(line: Utterance) -> None:
    kept = [Kept(0.0, 3.0, frozenset({"rate", "pitch"}))]
    moved = with_feeling(line, felt("sad"), kept=kept)
    assert moved.duration == line.duration
    assert heard(moved)["pitch"] == pytest.approx(heard(line)["pitch"], abs=0.3)
    assert heard(moved)["level"] < heard(line)["level"] - 3


def test_a_loud_voice_does_not_clip(line: Utterance) -> None:
    loud = replace(line, audio=Audio(line.audio.samples / np.abs(line.audio.samples).max(), RATE))
    assert np.abs(with_feeling(loud, felt("angry")).audio.samples).max() < 0.98


def test_the_same_seed_gives_the_same_voice(line: Utterance) -> None:
    first, again, other = (with_feeling(line, felt("afraid"), seed=seed) for seed in (1, 1, 2))
    assert first.audio == again.audio
    assert first.audio != other.audio


def test_silence_and_a_line_without_words() -> None:
    pause = Tier("phones", (Interval(0, 1.0, "SIL"),))
    nothing = Utterance("", Audio.silence(1.0, RATE), Tier("words", ()), pause, "en-US", "none")
    moved = with_feeling(nothing, felt("angry"))
    assert not moved.audio.samples.any()


def test_a_voice_that_carries_less_changes_less_in_the_same_direction(line: Utterance) -> None:
    plain = heard(line)["pitch"]
    full, part = (
        heard(with_feeling(line, felt("happy"), carried=share))["pitch"] - plain for share in ({}, {"pitch": 0.5})
    )
    assert full > 4.0
    assert 0.3 * full < part < 0.7 * full
