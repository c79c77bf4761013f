"""The options of the public calls that concern the performance, checked and made into what the pipeline takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from mien.animation.edits import EMPTY, EditLayer, read_layer
from mien.core.audio import Audio
from mien.core.errors import InputError, Note
from mien.core.timeline import FrameRate
from mien.motion.alive.idle import HandMadeIdle
from mien.motion.alive.visual_prosody import DEFAULT_STRENGTH, HandMadeProsody
from mien.motion.effort import DECIBELS
from mien.motion.expression.expression import NEUTRAL
from mien.motion.performer import Performer
from mien.motion.performers import load_performer
from mien.pipeline.spoken import Spoken
from mien.text.effort_spans import AS_RECORDED, EffortCurve, EffortSpan, parse_effort
from mien.text.expression_parameters import read_expression_parameters
from mien.text.score import EmotionSpan, Score

__all__ = [
    "DEFAULT_FPS", "Effort", "Emotions", "Rate", "effort_by_hand", "efforts_of", "is_auto", "layer_of",
    "prepared", "rate_of", "score_of", "score_with_voice", "semitones_of", "share_of", "split_auto",
    "with_heard_effort",
]  # fmt: skip

DEFAULT_FPS = 30

Rate = float | str | Fraction | FrameRate
Effort = float | str | EffortCurve | EffortSpan | None
Emotions = str | EmotionSpan | Sequence[str | EmotionSpan] | None


def prepared(
    performer: Performer | str | Path = "default",
    emotion: Emotions = None,
    fps: Rate = DEFAULT_FPS,
    seed: int = 0,
    prosody: float | str = DEFAULT_STRENGTH,
    speech_model: str | None = None,
    alive: str = "all",
    effort: Effort = None,
) -> tuple[Performer, Score, FrameRate]:
    """Performer, direction for the whole and frame rate; every option is checked before any long work begins.

    Parameters
    ----------
    performer, emotion, fps, seed, prosody, speech_model, alive, effort
        As for `mien.say`.

    Raises
    ------
    InputError
        If an option is not understood.
    """
    if seed < 0:
        raise InputError(f"a seed is a whole number, 0 or more, not {seed}")
    rate, score = FrameRate.of(fps), replace(score_of(emotion), efforts=efforts_of(effort))
    if not isinstance(performer, Performer):
        performer = load_performer(performer, speech_model)
    elif speech_model is not None:
        raise InputError("a performer that is loaded has its speech model: give load_performer(name, speech_model)")
    performer.expression.check(score)
    performer = replace(performer, prosody=HandMadeProsody(share_of("visual prosody", prosody)))
    if alive != "all":
        performer = replace(performer, idle=HandMadeIdle.of(alive))
    return performer, score, rate


def share_of(what: str, asked: float | str) -> float:
    """A share that may be given as "off".

    Raises
    ------
    InputError
        If it is no number from 0 to 1.

    Examples
    --------
    >>> share_of("visual prosody", "off"), share_of("visual prosody", "0.5")
    (0.0, 0.5)
    """
    try:
        share = 0.0 if isinstance(asked, str) and asked.strip().lower() == "off" else float(asked)
    except (TypeError, ValueError):
        share = -1.0
    if not 0 <= share <= 1:
        raise InputError(f"{what} is 'off' or a number from 0 to 1, not {asked!r}")
    return share


def rate_of(asked: float | str | None) -> float | None:
    """How fast somebody speaks: a multiple of the usual, or per cent.

    Raises
    ------
    InputError
        If it is no number from 0.2 to 5.

    Examples
    --------
    >>> rate_of("80%"), rate_of(1.2), rate_of(None)
    (0.8, 1.2, None)
    """
    if asked is None:
        return None
    text = str(asked).strip()
    return _number_in("rate", text.removesuffix("%"), 0.2, 5.0, 0.01 if text.endswith("%") else 1.0, "1.2 or 120%")


def semitones_of(asked: float | str | None) -> float | None:
    """How much higher somebody speaks, in semitones.

    Raises
    ------
    InputError
        If it is no number from -24 to 24.

    Examples
    --------
    >>> semitones_of("+2st"), semitones_of(-3)
    (2.0, -3.0)
    """
    return None if asked is None else _number_in("pitch", str(asked).strip().removesuffix("st"), -24.0, 24.0, 1.0, "+2")


def _number_in(what: str, text: str, least: float, most: float, factor: float, example: str) -> float:
    try:
        value = float(text) * factor
    except ValueError:
        value = float("nan")
    if not least <= value <= most:
        raise InputError(f"a {what} is a number from {least:g} to {most:g}, such as {example}, not {text!r}")
    return value


def score_of(emotion: Emotions) -> Score:
    """The emotions that are asked for, with their intensities over time.

    Raises
    ------
    InputError
        If it is no emotion.
    """
    if emotion is None:
        return Score()
    asked = (emotion,) if isinstance(emotion, (str, EmotionSpan)) else emotion
    if not isinstance(asked, Sequence) or not all(isinstance(span, (str, EmotionSpan)) for span in asked):
        raise InputError(f"an emotion is a text such as 'happy:0.6', an EmotionSpan, or several, not {emotion!r}")
    return Score(tuple(span for one in asked for span in _spans(one)))


def _spans(asked: str | EmotionSpan) -> tuple[EmotionSpan, ...]:
    """One emotion, or all those of a file of MPEG-4 expression parameters."""
    if isinstance(asked, EmotionSpan):
        return (asked,)
    if ":" not in asked and asked.strip().lower().endswith(".csv"):
        return read_expression_parameters(asked.strip())
    return (EmotionSpan.parse(asked),)


def efforts_of(effort: Effort) -> tuple[EffortSpan, ...]:
    """The effort that is asked for; nothing for None and ``"auto"``, which leave it to emotions and voice.

    Raises
    ------
    InputError
        If it is no effort.

    Examples
    --------
    >>> efforts_of("1.4")
    (EffortSpan(level=1.4, start=None, end=None, source='asked'),)
    """
    if effort is None or isinstance(effort, EffortSpan):
        return () if effort is None else (effort,)
    if isinstance(effort, str) and effort.strip().lower() in ("auto", "off"):
        return () if effort.strip().lower() == "auto" else (EffortSpan(AS_RECORDED, source="off"),)
    if isinstance(effort, str):
        return (EffortSpan(parse_effort(effort)),)
    if isinstance(effort, EffortCurve) or (isinstance(effort, (int, float)) and not isinstance(effort, bool)):
        return (EffortSpan(effort),)
    raise InputError(f"an effort is 0 to 2, a text such as '0.5@0,1.6@2', 'auto' or 'off', not {effort!r}")


def is_auto(effort: Effort) -> bool:
    """Whether the effort is to be read from the voice, by name."""
    return isinstance(effort, str) and effort.strip().lower() == "auto"


def effort_by_hand(effort: Effort) -> Effort:
    """The same effort, if no recorded voice is needed for it.

    Raises
    ------
    InputError
        If it is ``"auto"``.
    """
    if is_auto(effort):
        raise InputError("'auto' reads the effort from a recorded voice; a synthetic one has none: give 0 to 2")
    return effort


def split_auto(emotion: Emotions) -> tuple[Emotions, bool]:
    """What is asked for besides ``"auto"``, and whether that is among it."""
    asked = (emotion,) if isinstance(emotion, str) else emotion
    if not isinstance(asked, Sequence):
        return emotion, False
    named = [span for span in asked if not (isinstance(span, str) and span.strip().lower() == "auto")]
    return (named, True) if len(named) < len(asked) else (emotion, False)


def score_with_voice(score: Score, audio: Audio) -> tuple[Score, Note]:
    """A score with the emotions that are read from a voice besides, and a note on what was read."""
    from mien.emotion.emotion_over_time import emotion_spans

    spans = emotion_spans(audio)
    told = [
        f"{span.name} from {span.start or 0.0:.2f} to {audio.duration if span.end is None else span.end:.2f} s"
        for span in spans
    ]
    note = Note("note", "emotion read from the voice: " + (", ".join(told) or "none that is sure, so neutral"))
    return replace(score, emotions=(*score.emotions, *spans)), note


def with_heard_effort(score: Score, spoken: Spoken, asked: bool = False) -> tuple[Score, Spoken]:
    """The effort that is read from a recorded voice, under what the score asks for, and a note on what was read.

    Nothing is read where the score has an effort already, nobody speaks, or somebody sings (`mien.pipeline`: a song has
    its own way of opening the mouth). If it was ``asked`` for by name, emotions leave it as it is.
    """
    from mien.speech.vocal_effort import read_effort

    utterance = spoken.utterance
    if score.efforts or utterance.sung or utterance.timing == "none":
        return score, spoken
    read = read_effort(utterance.audio, DECIBELS)
    utterance.audio.rest()
    span = EffortSpan(EffortCurve(read.times, read.levels, "linear"), source="off" if asked else "voice")
    told = read.told + ("" if asked else _replaced((*score.emotions, *spoken.emotions)))
    return replace(score, efforts=(span,)), replace(spoken, utterance=utterance.with_notes(Note("note", told)))


def _replaced(emotions: Sequence[EmotionSpan]) -> str:
    """What emotions do to an effort that was read from the voice, to be said behind it."""
    felt = [span for span in emotions if span.name != NEUTRAL]
    names = ", ".join(dict.fromkeys(span.name for span in felt))
    if not felt:
        return ""
    if len(emotions) == 1 and (felt[0].start, felt[0].end, felt[0].intensity) == (None, None, 1.0):
        return f"; not used: the emotion {names} sets it (--effort auto keeps the voice's)"
    return f"; used as far as no emotion is shown ({names}; --effort auto keeps the voice's)"


def layer_of(edits: EditLayer | str | Path | None) -> EditLayer:
    """A layer of edits, read if it is the path of one; empty for None.

    Raises
    ------
    InputError
        If it is none.
    """
    if edits is None or isinstance(edits, EditLayer):
        return edits or EMPTY
    if not isinstance(edits, (str, Path)):
        raise InputError(f"expected a layer of edits or the path of its file, got {type(edits).__name__}")
    return read_layer(edits)
