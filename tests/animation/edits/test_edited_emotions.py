import numpy as np
import pytest

from mien.animation.edits import Anchor, EditLayer, IntensityEdit, Place
from mien.animation.edits.edited_emotions import with_intensities
from mien.text.score import EmotionSpan, Score
from tests.animation.edits.layers import say

BASE = say("i never said that")
RISE = IntensityEdit("happy", ((Anchor(Place("i"), 0.0), 0.2), (Anchor(Place("that", 1, 2), 1.0), 0.9)))


def laid(score, *edits, emotions=None, known=None, on=BASE):
    return with_intensities(EditLayer(edits, None, emotions), on, score, known)


def test_points_take_the_place_of_what_was_asked():
    score, lost, _ = laid(Score((EmotionSpan("happy", 1.0, 0.1, 0.5), EmotionSpan("sad"))), RISE)
    happy, sad = score.emotions
    assert happy.intensity.times == pytest.approx((0.2, 1.3))
    assert happy.intensity.values == (0.2, 0.9)
    assert (happy.start, happy.end) == (None, None)
    assert sad == EmotionSpan("sad")
    assert not lost


def test_an_emotion_that_was_not_asked_for_is_added():
    score, _, _ = laid(Score((EmotionSpan("sad"),)), RISE)
    assert [span.name for span in score.emotions] == ["sad", "happy"]


def test_one_emotion_in_place_of_one_other_keeps_the_curve():
    score, lost, notes = laid(Score((EmotionSpan("angry"),)), RISE, emotions=("happy",))
    assert [span.name for span in score.emotions] == ["angry"]
    assert score.emotions[0].intensity.values == (0.2, 0.9)
    assert not lost
    assert "'angry'" in notes[0].message


def test_an_emotion_that_is_gone_is_lost():
    for score in (Score(), Score((EmotionSpan("angry"), EmotionSpan("sad")))):
        kept, lost, _ = laid(score, RISE, emotions=("happy",))
        assert kept == score
        assert "not asked for" in lost[0].why


def test_an_emotion_that_the_performer_lacks_is_lost():
    _, lost, _ = laid(Score(), RISE, known=("sad",))
    assert "can be shown" in lost[0].why


def test_a_point_whose_word_is_gone_is_lost_and_the_others_stay():
    from mien.animation.edits import line_of

    layer = EditLayer((RISE,), line_of(BASE).line, ("happy",))
    score, lost, _ = with_intensities(layer, say("i never said"), Score((EmotionSpan("happy"),)))
    assert [(loss.edit, loss.point) for loss in lost] == [(0, 1)]
    assert score.emotions[0].intensity == 0.2


def test_points_at_one_time_are_one():
    twice = IntensityEdit("sad", ((Anchor(Place("i"), 1.0), 0.1), (Anchor(Place("never"), 0.0), 0.7)))
    score, _, _ = laid(Score(), twice)
    assert np.allclose(score.emotions[0].intensity_at(np.array([0.0, 1.0])), 0.7)


def test_an_intensity_may_stand_still_and_jump():
    points = ((Anchor(Place("i"), 0.0), 0.2), (Anchor(Place("said"), 0.0), 0.9))
    score, _, _ = laid(Score(), IntensityEdit("sad", points, "linear", ("step", None)))
    at = [0.25, 0.69, 0.71, 1.0]
    assert np.allclose(score.emotions[0].intensity_at(np.array(at)), [0.2, 0.2, 0.9, 0.9])
