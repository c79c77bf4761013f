"""What a language adds to an utterance comes through files, changes of pace and joins."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.utterance import Utterance
from mien.formats.native import read_native, write_native
from mien.motion.performer import Performer
from mien.pipeline.perform import perform
from mien.pipeline.spoken_joining import Joiner
from mien.speech.sound_reshaping import Change, reshape
from mien.text.languages import find_language, in_english_phones
from mien.text.normalisation import SpokenText, SpokenWord
from mien.text.score import Score


def finnish() -> Utterance:
    """A second of *yö* between pauses."""
    language = find_language("fi")
    assert language is not None
    native = Tier(
        "phones",
        (Interval(0, 0.2, "SIL"), Interval(0.2, 0.5, "y"), Interval(0.5, 0.8, "ø"), Interval(0.8, 1.0, "SIL")),
    )
    phones, shapes = in_english_phones(native, language)
    words = Tier("words", (Interval(0.2, 0.8, "yö"),))
    return Utterance("yö", Audio.silence(1.0, 16_000), words, phones, "fi", "voice", native=native, shapes=shapes)


def test_the_native_file_keeps_a_language(tmp_path: Path) -> None:
    said = replace(finnish(), sung=True)
    animation = perform(said, Score(), Performer.hand_made(), FrameRate.of(25))
    write_native(animation, tmp_path / "a.json")
    back = read_native(tmp_path / "a.json")
    assert back.utterance.native == said.native
    assert back.utterance.shapes == said.shapes
    assert back.utterance.sung
    again = perform(back.utterance, Score(), Performer.hand_made(), FrameRate.of(25))
    assert np.array_equal(again.channels.values, animation.channels.values)


def test_a_change_of_pace_moves_native_phones_along() -> None:
    slow = reshape(finnish(), [Change(0.2, 0.5, rate=0.5)])
    assert slow.native is not None
    assert slow.native.intervals[1].end == pytest.approx(0.8)
    assert slow.shapes == finnish().shapes


def test_segments_of_two_languages_join() -> None:
    english = replace(
        finnish(),
        language="en-US",
        phones=Tier("phones", (Interval(0, 0.2, "SIL"), Interval(0.2, 0.8, "AA"), Interval(0.8, 1.0, "SIL"))),
        native=None,
        shapes=(),
    )
    joiner = Joiner(16_000)
    spoken = SpokenText("yö", (SpokenWord("yö", 0, 2),))
    joiner.add(english, spoken, 0, None)
    joiner.add(finnish(), spoken, 1, None)
    joined = joiner.finish(english, "ah yö")
    assert joined.native is not None
    assert [p.label for p in joined.native] == ["SIL", "AA", "SIL", "y", "ø", "SIL"]
    assert [names for names in joined.shapes if names] == [("front_round",), ("front_round_mid",)]


def test_a_front_rounded_vowel_moves_the_mouth_otherwise_than_a_back_one() -> None:
    front = perform(finnish(), Score(), Performer.hand_made(), FrameRate.of(25)).channels.values
    back = perform(replace(finnish(), shapes=()), Score(), Performer.hand_made(), FrameRate.of(25)).channels.values
    assert np.abs(front - back).max() > 0.15


def test_shapes_that_do_not_count_as_many_as_phones_are_refused() -> None:
    with pytest.raises(InputError, match="key shapes for 4 phones"):
        replace(finnish(), shapes=((),))
    strange = replace(finnish(), shapes=((), ("front_rond",), (), ()))
    with pytest.raises(InputError, match="unknown key shape"):
        perform(strange, Score(), Performer.hand_made(), FrameRate.of(25))
