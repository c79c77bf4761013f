from dataclasses import replace

import numpy as np

from mien.animation.edits.applied import Before
from tests.animation.edits.layers import say


def test_two_are_the_same_only_if_words_and_channels_are() -> None:
    said = say("i said")
    one = Before(said.words, said.phones, said.native, (), {"jawOpen": np.array([0.1, 0.2])})
    assert one == replace(one, channels={"jawOpen": np.array([0.1, 0.2])})
    assert one != replace(one, words=say("i never said").words)
    assert one != replace(one, channels={"jawOpen": np.array([0.1, 0.3])})
    assert one != replace(one, channels={"mouthClose": np.array([0.1, 0.2])})
    assert one != "something else"
