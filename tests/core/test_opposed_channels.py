"""One at most of two opposed channels is above zero in whatever mien performs."""

from __future__ import annotations

import numpy as np
import pytest

import mien
from mien.core.audio import Audio
from mien.core.channels import ALL
from mien.core.opposed_channels import OPPOSED, apart
from mien.motion.performer import Performer
from mien.serve.live.animator import frames_of
from tests.programs import voice_or_skip


def both(values: np.ndarray, names: tuple[str, ...] = ALL) -> float:
    """The most that the weaker one of a pair has."""
    return max(
        float(np.minimum(values[:, names.index(one)], values[:, names.index(other)]).max()) for one, other in OPPOSED
    )


def test_what_is_held_stays_and_the_other_gives_way() -> None:
    values = np.array([[0.5, 0.3], [0.5, 0.3], [0.5, 0.3], [0.0, 0.3]])
    held = np.array([[True, False], [False, True], [True, True], [True, False]])
    result = apart(values, ("jawLeft", "jawRight"), held)
    np.testing.assert_allclose(result, [[0.5, 0.0], [0.0, 0.3], [0.2, 0.0], [0.0, 0.3]])


def test_differences_stay_as_they_were() -> None:
    values = np.random.default_rng(0).uniform(0, 1, (50, len(ALL)))
    result = apart(values, ALL)
    assert both(values) > 0.5
    assert both(result) == 0.0
    assert result.min() >= 0.0
    for one, other in OPPOSED:
        a, b = ALL.index(one), ALL.index(other)
        np.testing.assert_allclose(result[:, a] - result[:, b], values[:, a] - values[:, b])


TEXTS = ("I never said that. Maybe five people heard my voice!", '<gaze target="left">Look</gaze> up.')


@pytest.mark.parametrize("text", TEXTS)
def test_lines(text: str) -> None:
    line = mien.say(text, emotion=["angry:0.6", "sad:0.3"], voice=voice_or_skip("espeak").name)
    assert both(line.channels.values) == 0.0
    assert both(mien.express(line, emotion="happy").channels.values) == 0.0


def test_asking_for_both_is_told() -> None:
    curve = '<curve parameter="{}"><key at="0" value="0.4"/><key at="500" value="0.3"/></curve>'
    script = f"I {curve}{curve}do."
    for names, told in ((("jawLeft", "jawRight"), 1), (("jawLeft", "mouthRight"), 0)):
        line = mien.say(script.format(*names), voice=voice_or_skip("espeak").name, performer="hand-made")
        assert both(line.channels.values) == 0.0
        assert sum("asked for at once" in note.message for note in line.notes) == told


def test_live() -> None:
    sound = Audio(0.1 * np.random.default_rng(0).uniform(-1, 1, 16000), 16000)
    assert both(np.array(list(frames_of(sound, Performer.hand_made())))) == 0.0
