"""Small utterances whose times are known, for tests."""

from __future__ import annotations

from mien.core.audio import Audio
from mien.core.timeline import Interval, Tier
from mien.core.utterance import Utterance


def utterance(*phones: tuple[str, float], rate: int = 16000, text: str = "test") -> Utterance:
    """Phones with their durations in seconds, one after another, over a silent sound."""
    intervals, now = [], 0.0
    for label, duration in phones:
        intervals.append(Interval(now, now + duration, label))
        now += duration
    spoken = [i for i in intervals if i.label != "SIL"]
    words = (Interval(spoken[0].start, spoken[-1].end, text),) if spoken else ()
    return Utterance(
        text=text,
        audio=Audio.silence(now, rate),
        words=Tier("words", words),
        phones=Tier("phones", tuple(intervals)),
        language="en-US",
        timing="aligned",
    )
