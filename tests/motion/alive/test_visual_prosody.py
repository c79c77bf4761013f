from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mien
from mien.core import channels
from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.utterance import Utterance
from mien.motion.alive.visual_prosody import HandMadeProsody
from mien.speech.stressed_vowels import stressed_words

RATE = 16_000
BROW, PITCH, ROLL = (channels.ALL.index(name) for name in ("browInnerUp", "headPitch", "headRoll"))


def sung_line(text: str, accented: int, seconds: float = 0.4) -> Utterance:
    """A vowel for each word, a hum of 120 Hz at -26 dBFS; the accented one 7 semitones higher and 8 dB louder."""
    words = text.split()
    pieces, spans, phones = [np.zeros(RATE // 5)], [], [Interval(0, 0.2, "SIL")]
    for number, word in enumerate(words):
        hertz, level = (180.0, 0.18) if number == accented else (120.0, 0.07)
        time = np.arange(round(seconds * RATE)) / RATE
        pieces.append(level * sum(np.sin(2 * np.pi * hertz * k * time) / k for k in range(1, 8)))
        start = 0.2 + number * seconds
        spans.append(Interval(start, start + seconds, word.strip(".?").lower()))
        phones.append(Interval(start, start + seconds, "AA"))
    end = 0.2 + len(words) * seconds
    audio = Audio(np.concatenate([*pieces, np.zeros(RATE)]), RATE)
    phones.append(Interval(end, audio.duration, "SIL"))
    return Utterance(text, audio, Tier("words", tuple(spans)), Tier("phones", tuple(phones)), "en-US", "aligned")


LINE = sung_line("Bob found gold down here.", accented=2)


def moved(line: Utterance, seed: int = 0, fps: float = 50, strength: float = 1.0) -> np.ndarray:
    return HandMadeProsody(strength).perform(line, stressed_words(line), FrameRate.of(fps), np.random.default_rng(seed))


def test_the_high_and_loud_word_is_the_accent() -> None:
    accents = HandMadeProsody().accents(stressed_words(LINE))
    assert max(accents, key=lambda accent: accent.prominence).word == "gold"


def test_brows_and_head_move_with_the_accent() -> None:
    times = FrameRate.of(50).times(len(moved(LINE)))
    raised = [moved(LINE, seed)[:, BROW] for seed in range(30)]
    nodded = [moved(LINE, seed)[:, PITCH] for seed in range(30)]
    assert 10 < sum(brow.max() > 0.1 for brow in raised) < 30
    assert all(0.9 < times[brow.argmax()] < 1.5 for brow in raised if brow.max() > 0.2)
    assert sum(head[(times > 0.9) & (times < 1.5)].min() < -1 for head in nodded) > 20
    assert min(head.min() for head in nodded) > -8


def test_a_question_raises_the_brows_at_its_end() -> None:
    line = sung_line("Bob found gold down here?", accented=0)
    end = line.words.intervals[-1].end
    frame = round((end + 0.05) * 50)
    asked, told = moved(line), moved(replace(line, text="Bob found gold down here."))
    assert asked[frame, BROW] > 0.2
    assert asked[frame, ROLL] != 0
    assert told[frame, PITCH] < -0.8
    assert told[frame, BROW] < 0.05


def test_eyes_stay_where_they_look() -> None:
    motion = moved(LINE)
    up, down = (channels.ALL.index(f"eyeLook{way}Left") for way in ("Up", "Down"))
    assert motion[:, PITCH] == pytest.approx(28 * (motion[:, down] - motion[:, up]))


def test_the_same_motion_at_every_frame_rate_and_in_proportion_to_its_strength() -> None:
    assert moved(LINE, fps=25) == pytest.approx(moved(LINE, fps=50)[::2])
    assert moved(LINE, strength=0.5) == pytest.approx(0.5 * moved(LINE))
    assert not moved(LINE, strength=0.0).any()
    assert np.array_equal(moved(LINE), moved(LINE))


def test_nothing_is_said_nothing_moves() -> None:
    quiet = Audio.silence(1.0, RATE)
    pause = Tier("phones", (Interval(0, 1.0, "SIL"),))
    assert not moved(Utterance("", quiet, Tier("words", ()), pause, "en-US", "none")).any()
    said = Tier("words", (Interval(0.2, 0.5, "hm"),))
    assert np.isfinite(moved(Utterance("hm", quiet, said, pause, "en-US", "aligned"))).all()
    assert np.isfinite(moved(Utterance("hm", quiet, said, pause, "xx", "aligned"))).all()


@pytest.mark.parametrize("strength", ["loud", 1.5, -0.1, None])
def test_a_strength_out_of_range_is_refused(strength: object) -> None:
    with pytest.raises(InputError, match="visual prosody"):
        mien.animate(LINE.audio, text="a", prosody=strength)  # type: ignore[arg-type]
