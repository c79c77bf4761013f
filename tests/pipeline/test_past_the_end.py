from __future__ import annotations

import pytest

from mien.core.timeline import FrameRate
from mien.motion.performers import load_performer
from mien.pipeline.perform import perform
from mien.text.effort_spans import EffortSpan, parse_effort
from mien.text.parameter_curves import ParameterCurve
from mien.text.score import EmotionSpan, Score
from tests.utterances import utterance


@pytest.mark.parametrize(
    ("score", "told"),
    [
        (Score((EmotionSpan.parse("happy[5-9]"),)), "happy was asked for from 5 s"),
        (Score((EmotionSpan.parse("happy[0.1-9]"),)), "happy was asked for to 9 s"),
        (Score((EmotionSpan.parse("happy:0.2@0,0.9@7"),)), "happy was asked for at 7 s"),
        (Score(efforts=(EffortSpan(parse_effort("0.5@0,1.4@7")),)), "effort was asked for at 7 s"),
        (Score(curves=(ParameterCurve("jawOpen", ((8000.0, 1.0), (9000.0, 0.0))),)), "jawOpen was asked for from 8 s"),
        (Score((EmotionSpan.parse("happy:0.2@0,0.9@0.1"),)), ""),
    ],
)
def test_what_is_asked_for_past_the_end_is_told(score: Score, told: str) -> None:
    notes = perform(utterance(("AA", 0.5)), score, load_performer("hand-made"), FrameRate.of(10)).notes
    late = [note.message for note in notes if "but the line ends at" in note.message]
    assert (late[0].startswith(told), len(late)) == (True, 1) if told else not late
