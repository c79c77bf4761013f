from __future__ import annotations

from dataclasses import replace

import numpy as np

from mien.core import channels
from mien.core.audio import Audio
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.utterance import Utterance
from mien.motion.mouth.hand_made_mouth import HandMadeMouth
from mien.motion.mouth.singing import BREATH_JAW, sing

JAW = channels.ALL.index("jawOpen")
RATE = FrameRate.of(50)
SOUND_RATE = 16_000


def song(loud: float) -> Utterance:
    """A soft AA, M, a loud AA, a rest, a soft AA."""
    time = np.arange(round(5.0 * SOUND_RATE)) / SOUND_RATE
    gain = np.select([time < 1, time < 1.2, time < 2.2, time < 4], [0.05, 0.02, loud, 0.0], 0.05)
    tone = sum(np.sin(2 * np.pi * 220 * k * time) / k for k in range(1, 6)) * gain
    labels = [("AA", 1.0), ("M", 1.2), ("AA", 2.2), ("SIL", 4.0), ("AA", 5.0)]
    starts = [0.0, *(end for _, end in labels)]
    tier = Tier("phones", tuple(Interval(a, end, p) for a, (p, end) in zip(starts, labels, strict=False)))
    return Utterance("ah", Audio(tone * 0.3, SOUND_RATE), Tier("words", ()), tier, "en-US", "aligned", sung=True)


def test_the_jaw_follows_the_voice_in_vowels() -> None:
    line = song(0.6)
    spoken = HandMadeMouth().perform(line, RATE)
    sung = sing(spoken, line, RATE)
    more = sung.values[:, JAW] - spoken.values[:, JAW]
    assert more[85] > 1.5 * more[25] > 0
    assert np.array_equal(sung.values[:, JAW][spoken.seal == 1], spoken.values[:, JAW][spoken.seal == 1])
    assert sung.values.max() <= 1


def test_a_breath_is_taken_before_a_line() -> None:
    line = song(0.6)
    sung = sing(HandMadeMouth().perform(line, RATE), line, RATE)
    assert sung.values[round(3.83 * 50), JAW] > 0.8 * BREATH_JAW
    assert sung.values[150, JAW] < 0.02


def test_silence_is_borne() -> None:
    line = replace(song(0.6), audio=Audio.silence(5.0, SOUND_RATE))
    assert np.isfinite(sing(HandMadeMouth().perform(line, RATE), line, RATE).values).all()
