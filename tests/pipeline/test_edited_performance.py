import numpy as np
import pytest
from hypothesis import given, settings

from mien.animation.edits import EMPTY, Anchor, BorderEdit, ChannelEdit, EditLayer, IntensityEdit, Place
from mien.core.timeline import FrameRate
from mien.motion.performer import Performer
from mien.pipeline.edited_performance import perform_edited, unedited
from mien.pipeline.perform import perform
from mien.text.score import EmotionSpan, Score
from tests.animation.edits.layers import LINE, layers, say

RATE, SCORE = FrameRate.of(30), Score((EmotionSpan("happy", 0.5),))
PERFORMER = Performer.hand_made()
LAYER = EditLayer(
    (
        BorderEdit(Place("never", 1, 3), "end", 0.04),
        IntensityEdit("happy", ((Anchor(Place("i"), 0.0), 0.1), (Anchor(Place("said", 2, 2), 1.0), 1.0))),
        ChannelEdit(
            "jawOpen", "replace", ((Anchor(Place("that", 1, 1), 0.0), 0.8), (Anchor(Place("that", 1, 1), 1.0), 0.8))
        ),
    )
)


def performed(layer, text: str = LINE, length: float = 0.1, score=SCORE):
    return perform_edited(say(text, length), score, PERFORMER, RATE, 7, layer)


def test_an_empty_layer_changes_nothing():
    assert performed(EMPTY) == perform(say(LINE), SCORE, PERFORMER, RATE, 7)


def test_all_three_kinds_are_laid_on():
    plain, edited = perform(say(LINE), SCORE, PERFORMER, RATE, 7), performed(LAYER)
    assert edited.utterance.words.intervals[1].end == pytest.approx(plain.utterance.words.intervals[1].end + 0.04)
    assert edited.score.emotions[0].intensity.values == (0.1, 1.0)
    that = edited.utterance.phones.intervals[10]
    inside = (RATE.times(len(edited.channels)) > that.start) & (RATE.times(len(edited.channels)) < that.end)
    assert edited.channels.channel("jawOpen")[inside] == pytest.approx(0.8)
    assert edited.edits.lost == ()


def test_laid_on_again_it_is_the_same():
    once = performed(LAYER)
    utterance, score = unedited(once)
    again = perform_edited(utterance, score, PERFORMER, RATE, 7, once.edits.layer)
    assert again == once


def test_edits_off_is_the_plain_performance():
    utterance, score = unedited(performed(LAYER))
    assert perform(utterance, score, PERFORMER, RATE, 7) == perform(say(LINE), SCORE, PERFORMER, RATE, 7)


def test_they_survive_another_text_voice_and_emotion():
    layer = performed(LAYER).edits.layer
    other = performed(
        layer, "maybe i never said that i never said".replace("maybe ", "said "), 0.15, Score((EmotionSpan("sad"),))
    )
    assert other.edits.lost == ()
    assert [word.label for word in other.utterance.words][2] == "never"
    assert other.score.emotions[0].name == "sad"
    assert other.score.emotions[0].intensity.values == (0.1, 1.0)


def test_what_has_no_place_is_listed_and_told():
    layer = performed(LAYER).edits.layer
    other = performed(layer, "i said said")
    assert [(loss.edit, loss.point) for loss in other.edits.lost] == [(0, None), (2, None)]
    told = [note.message for note in other.notes if note.kind == "warning"]
    assert any("edit 1 (border)" in message and "'never'" in message for message in told)


@settings(max_examples=25)
@given(layers)
def test_any_layer_gives_motion_in_range_and_the_same_twice(layer):
    one, other = performed(layer), performed(layer)
    assert one == other
    assert np.isfinite(one.channels.values).all()
    if one.edits is not None:
        utterance, score = unedited(one)
        assert perform_edited(utterance, score, PERFORMER, RATE, 7, one.edits.layer) == one


def test_another_emotion_over_an_edited_animation_is_what_the_performer_makes_with_the_layer():
    from mien.api.recoloring import recolor

    layer = performed(LAYER).edits.layer
    changed = recolor(performed(LAYER), "sad", PERFORMER, "hand-made")
    wanted = performed(layer, score=Score((EmotionSpan("sad"),)))
    assert changed.score == wanted.score
    assert np.allclose(changed.channels.values, wanted.channels.values, atol=0.05)
    jaw = wanted.channels.channel("jawOpen") == pytest.approx(0.8)
    assert np.array_equal(changed.channels.channel("jawOpen") == pytest.approx(0.8), jaw)
    assert changed.edits.layer == layer
    assert changed.edits.before.emotions == (EmotionSpan("sad"),)
    assert unedited(changed)[0] == say(LINE)


def test_an_expression_laid_over_takes_the_edits_in():
    from mien.pipeline.perform import express

    animation = express(performed(LAYER), Score((EmotionSpan("sad", 0.5),)), PERFORMER)
    assert animation.edits is None
    assert any("part of the motion" in note.message for note in animation.notes)
