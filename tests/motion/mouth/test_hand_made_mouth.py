from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mien.core import channels
from mien.core.timeline import FrameRate
from mien.motion.mouth.hand_made_mouth import HandMadeMouth, cosine_interpolation
from mien.text.phones import phone_table
from tests.utterances import utterance

MOUTH = HandMadeMouth()
ARPABET = sorted(phone_table())


def test_every_phone_has_a_shape_and_there_are_fourteen_shapes() -> None:
    """Deng's thirteen classes, and /l/ apart from /t d n/ so that its tongue shows."""
    english = 14
    used = {name for phone in ARPABET for name in MOUTH.visemes_of(phone)}
    assert len(used) == english


def test_cosine_interpolation_by_hand() -> None:
    times = np.array([0.0, 0.1, 0.2, 0.25, 0.3, 0.4, 0.9])
    values = cosine_interpolation(times, [(0.1, 0.2), (0.3, 0.3), (0.5, 0.6)], np.array([[1.0], [3.0], [0.0]]))
    assert values[:, 0] == pytest.approx([1, 1, 1, 2, 3, 1.5, 0])


@given(st.lists(st.tuples(st.sampled_from([*ARPABET, "SIL"]), st.floats(0.01, 0.6)), min_size=1, max_size=20))
def test_any_phones_give_finite_weights_in_range(phones: list[tuple[str, float]]) -> None:
    motion = MOUTH.perform(utterance(*phones), FrameRate.of(30))
    assert motion.values.min() >= 0
    assert motion.values.max() <= 1
    still = [channels.ALL.index(name) for name in channels.UPPER_FACE + channels.HEAD]
    assert not motion.values[:, still].any()


@pytest.mark.parametrize("fps", [24, 25, 30, 60])
@pytest.mark.parametrize("phone", ["P", "B", "M", "F", "V"])
@pytest.mark.parametrize("start", [0.2, 0.213, 0.227, 0.239])
def test_even_the_shortest_closure_is_seen_on_a_frame(fps: int, phone: str, start: float) -> None:
    motion = MOUTH.perform(
        utterance(("SIL", start), ("AA", 0.12), (phone, 0.03), ("AA", 0.12), ("SIL", 0.2)), FrameRate.of(fps)
    )
    assert motion.seal.max() == pytest.approx(1.0)
    key = MOUTH.visemes[MOUTH.visemes_of(phone)[0]].shape
    assert motion.values[np.argmax(motion.seal)] == pytest.approx(key)


def test_a_long_vowel_opens_further_than_a_short_one() -> None:
    jaw = channels.ALL.index("jawOpen")
    peaks = [
        MOUTH.perform(utterance(("T", 0.1), ("AA", length), ("T", 0.1)), FrameRate.of(100)).values[:, jaw].max()
        for length in (0.03, 0.06, 0.12, 0.3)
    ]
    assert peaks[0] < peaks[1] < peaks[2]
    assert peaks[2] == pytest.approx(peaks[3])


def test_the_mouth_rests_in_a_long_pause() -> None:
    motion = MOUTH.perform(utterance(("AA", 0.3), ("SIL", 1.0), ("AA", 0.3)), FrameRate.of(50))
    assert not motion.values[30:50].any()


def test_a_diphthong_passes_through_both_shapes_in_order() -> None:
    values = MOUTH.perform(utterance(("AW", 0.4)), FrameRate.of(100)).values
    jaw, pucker = (values[:, channels.ALL.index(name)] for name in ("jawOpen", "mouthPucker"))
    assert np.argmax(jaw) < np.argmax(pucker)


def test_silence_alone_is_rest() -> None:
    motion = MOUTH.perform(utterance(("SIL", 1.0)), FrameRate.of(30))
    assert not motion.values.any()
    assert not motion.seal.any()
