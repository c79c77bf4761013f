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
from mien.motion.alive.idle import AuthoredIdle
from mien.motion.alive.visual_prosody import DEFAULT_STRENGTH, AuthoredProsody
from mien.motion.performer import Performer
from mien.motion.performers import load_performer
from mien.text.expression_parameters import read_expression_parameters
from mien.text.score import EmotionSpan, Score

__all__ = [
    "DEFAULT_FPS", "Emotions", "Rate", "layer_of", "prepared", "score_of", "score_with_voice", "split_auto",
]  # fmt: skip

DEFAULT_FPS = 30

Rate = float | str | Fraction | FrameRate
Emotions = str | EmotionSpan | Sequence[str | EmotionSpan] | None


def prepared(
    performer: Performer | str | Path = "default",
    emotion: Emotions = None,
    fps: Rate = DEFAULT_FPS,
    seed: int = 0,
    prosody: float | str = DEFAULT_STRENGTH,
    speech_model: str | None = None,
    alive: str = "all",
) -> tuple[Performer, Score, FrameRate]:
    """Performer, direction for the whole and frame rate; every option is checked before any long work begins.

    Parameters
    ----------
    performer, emotion, fps, seed, prosody, speech_model, alive
        As for `mien.say`.

    Raises
    ------
    InputError
        If an option is not understood.
    """
    if seed < 0:
        raise InputError(f"a seed is a whole number, 0 or more, not {seed}")
    rate, score = FrameRate.of(fps), score_of(emotion)
    if not isinstance(performer, Performer):
        performer = load_performer(performer, speech_model)
    elif speech_model is not None:
        raise InputError("a performer that is loaded has its speech model: give load_performer(name, speech_model)")
    performer.expression.check(score)
    performer = replace(performer, prosody=AuthoredProsody(_strength(prosody)))
    if alive != "all":
        performer = replace(performer, idle=AuthoredIdle.of(alive))
    return performer, score, rate


def _strength(prosody: float | str) -> float:
    if isinstance(prosody, str) and prosody.strip().lower() == "off":
        return 0.0
    try:
        return float(prosody)
    except (TypeError, ValueError) as problem:
        raise InputError(f"visual prosody is 'off' or a number from 0 to 1, not {prosody!r}") from problem


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
