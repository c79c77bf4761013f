"""--rate and --pitch: the whole line as with <prosody> around it."""

from __future__ import annotations

import pytest

import mien
from mien.core.errors import InputError
from mien.pipeline.options import rate_of, semitones_of
from mien.speech.pitch import pitch_contour


def test_slower_is_longer_and_higher_is_higher() -> None:
    import numpy as np

    plain = mien.say("A blue book.", voice="espeak", alive="off")
    changed = mien.say("A blue book.", voice="espeak", alive="off", rate="80%", pitch=4)
    tagged = mien.say('<prosody rate="80%" pitch="+4st">A blue book.</prosody>', voice="espeak", alive="off")
    assert changed.utterance.duration == pytest.approx(plain.utterance.duration / 0.8, rel=0.05)
    assert changed.utterance.duration == pytest.approx(tagged.utterance.duration, rel=0.1)

    def middle(animation) -> float:
        contour = pitch_contour(animation.utterance.audio)
        heard = contour.hertz_at(np.linspace(0, animation.utterance.duration, 200))
        return float(np.nanmedian(heard[heard > 0]))

    assert 12 * np.log2(middle(changed) / middle(plain)) == pytest.approx(4, abs=0.7)


@pytest.mark.parametrize("asked", ["0", "9", "fast", "nan", "-1", "700%"])
def test_a_rate_that_is_none(asked: str) -> None:
    with pytest.raises(InputError, match=r"a rate is a number from 0\.2 to 5"):
        rate_of(asked)


@pytest.mark.parametrize("asked", ["30", "high", "nan"])
def test_a_pitch_that_is_none(asked: str) -> None:
    with pytest.raises(InputError, match="a pitch is a number from -24 to 24"):
        semitones_of(asked)
