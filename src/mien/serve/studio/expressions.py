"""What emotions do to a silent face: for the page's pictures of them, and for showing one before it is performed."""

from __future__ import annotations

from typing import Any

from mien.core.audio import Audio
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.utterance import PAUSE, Utterance
from mien.motion.performer import Performer
from mien.pipeline.perform import perform
from mien.text.score import EmotionSpan, Score

__all__ = ["expressions_of"]

_SECONDS = 2.0
_RATE = FrameRate.of(25)


def expressions_of(performer: Performer) -> dict[str, Any]:
    """``{"channels": names, "emotions": {name: values}}``: what is added to the face at intensity 1, mean over time."""
    sound = Audio.silence(_SECONDS, 16_000)
    silent = Utterance("", sound, Tier("words", ()), Tier("phones", (Interval(0.0, _SECONDS, PAUSE),)), "en", "none")

    def held(*emotions: str) -> Any:
        score = Score(tuple(EmotionSpan(name, 1.0) for name in emotions))
        return perform(silent, score, performer, _RATE, 0).channels

    plain = held()
    rest = plain.values.mean(axis=0)
    names = [name for name in performer.expression.names if name != "neutral"]
    added = {name: held(name).values.mean(axis=0) - rest for name in names}
    return {
        "channels": list(plain.names),
        "emotions": {name: [round(float(value), 4) for value in values] for name, values in added.items()},
    }
