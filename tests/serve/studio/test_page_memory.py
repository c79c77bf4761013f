from dataclasses import replace

import numpy as np

from mien.animation.edits import BorderEdit, EditLayer, Place
from mien.animation.edits.borders import with_borders
from mien.core.audio import Audio
from mien.core.timeline import FrameRate
from mien.motion.mouth.hand_made_mouth import HandMadeMouth
from mien.serve.studio.page_memory import RememberingMouth
from tests.animation.edits.layers import say

RATE = FrameRate.of(30)


class Counting(HandMadeMouth):
    asked = 0

    def perform(self, utterance, rate):
        self.asked += 1
        return super().perform(utterance, rate)


def test_asked_once_for_the_same_and_anew_for_anything_else():
    inner = Counting()
    mouth, line = RememberingMouth(inner), say("i never said that")
    first = mouth.perform(line, RATE)
    assert mouth.perform(replace(line, text="other"), RATE) is first
    assert inner.asked == 1
    moved, _, _ = with_borders(EditLayer((BorderEdit(Place("never"), "end", 0.03),)), line)
    assert not np.array_equal(mouth.perform(moved, RATE).values, first.values)
    mouth.perform(line, FrameRate.of(25))
    mouth.perform(replace(line, audio=Audio(line.audio.samples, line.audio.rate)), RATE)
    assert inner.asked == 4
    assert np.array_equal(mouth.perform(line, RATE).values, HandMadeMouth().perform(line, RATE).values)


def test_only_the_last_few_are_kept():
    inner = Counting()
    mouth = RememberingMouth(inner, most=2)
    lines = [say("i never"), say("i said"), say("that")]
    for line in (*lines, lines[0]):
        mouth.perform(line, RATE)
    assert inner.asked == 4
