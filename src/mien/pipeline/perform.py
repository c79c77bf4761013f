"""THE pipeline: Utterance + Score + Performer -> Animation. Pure steps; read this first.

mouth       what the phones ask of the mouth, and when the lips must stay shut; a song opens it further
effort      how hard that is articulated, as asked for, as the voice sounds and as the emotions have it
expression  what the emotions ask of the whole face
idle        blinks, glances, a moving head, in the manner of what is felt; no head turns faster than heads do
prosody     brows and nods on the accents and phrase ends of the voice, as large as the effort
blend       expression gives way to speech where the lips are shut; lids close whatever the expression says
direct      curves of the score (gestures, gaze, action units) are laid over the result
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from importlib.metadata import version

import numpy as np
from numpy.typing import NDArray

from mien.animation.animation import Animation, Provenance
from mien.core import channels
from mien.core.emotions import emotion_table
from mien.core.errors import Note
from mien.core.one_thread import one_thread
from mien.core.opposed_channels import OPPOSED, apart
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.core.utterance import Utterance
from mien.motion.alive.manner import steady_head
from mien.motion.effort import articulate, mean_mouth
from mien.motion.expression.expression import NEUTRAL, weights_of
from mien.motion.expression.line import line_of
from mien.motion.mouth.hand_made_mouth import HandMadeMouth, MouthMotion
from mien.motion.mouth.shown_closure import bilabial_seal, close_lips
from mien.motion.mouth.singing import sing
from mien.motion.performer import FeelingMouth, Performer
from mien.speech.stressed_vowels import stressed_words
from mien.text.effort_spans import AS_RECORDED, effort_over
from mien.text.parameter_curves import ParameterCurve, lay_over
from mien.text.score import Score

__all__ = ["blend", "direct", "express", "perform"]

_BLOCK = 4096  # frames
_A_LITTLE = 0.25  # seconds by which a curve may end after its line
_WEIGHTS = slice(0, len(channels.WEIGHTS))
_BLINK = [channels.ALL.index(f"eyeBlink{side}") for side in ("Left", "Right")]
_ROUND = [channels.ALL.index(name) for name in ("mouthPucker", "mouthFunnel")]
_HEAD = [channels.ALL.index(name) for name in channels.HEAD]
_LIDS = [channels.ALL.index(f"{name}{side}") for name in ("eyeWide", "eyeSquint") for side in ("Left", "Right")]


@one_thread
def perform(utterance: Utterance, score: Score, performer: Performer, rate: FrameRate, seed: int = 0) -> Animation:
    """Let a performer speak an utterance as the score directs.

    Parameters
    ----------
    utterance : Utterance
    score : Score
    performer : Performer
    rate : FrameRate
        Of the animation.
    seed : int
        The same seed, input and version give the same animation, bit for bit.

    Returns
    -------
    Animation
        Covers the sound: ``rate.frames_covering(utterance.duration)`` frames.
    """
    for_expression, for_idle, for_prosody = np.random.default_rng(seed).spawn(3)
    mouth = _spoken(utterance, score, performer, rate)
    if utterance.sung:
        mouth = sing(mouth, utterance, rate)
    utterance.audio.rest()
    times = rate.times(len(mouth.values))
    shown = 1 - weights_of(score, times)[0]
    effort = effort_over(score.efforts, performer.expression.effort(score, times), shown, times)
    if (effort != AS_RECORDED).any():
        mouth = articulate(mouth, effort, utterance.phones, rate, mean_mouth(performer.mouth))
    words = stressed_words(utterance) if len(utterance.words) else ()
    line = line_of(utterance, words, mouth.values, rate) if score.emotions else None
    expression = performer.expression.perform(score, utterance.duration, rate, for_expression, line=line)
    utterance.audio.rest()
    idle = performer.idle.perform(utterance, rate, for_idle, score)
    prosody = performer.prosody.perform(utterance, words, rate, for_prosody)
    utterance.audio.rest()
    shut = bilabial_seal(mouth.seal, utterance.phones, times)
    gives_way, values = 1 - performer.expression.sealed_share, expression  # laid over one another in its place
    del line, expression
    blocks = [slice(first, first + _BLOCK) for first in range(0, len(values), _BLOCK)]
    for here in blocks:  # a long line is not held many times over
        felt = values[here] * (1 - mouth.seal[here, None] * gives_way) + prosody[here] * effort[here, None]
        values[here] = close_lips(blend(mouth.values[here], felt, idle[here]), shut[here])
    markers, seal = mouth.markers, mouth.seal
    del mouth, idle, prosody
    values[:, _HEAD] = steady_head(values[:, _HEAD], rate.fps)
    for here in blocks:
        values[here] = direct(values[here], score.curves, times[here], 1 - seal[here, None] * gives_way)
    return Animation(
        channels=ChannelTrack.taking(channels.ALL, values, rate),
        markers=markers,
        utterance=utterance,
        score=score,
        provenance=Provenance(performer.name, seed, version("mien")),
        notes=utterance.notes
        + performer.expression.notes(score)
        + _outside(score, utterance.duration)
        + _opposed(score.curves, times),
    )


def _outside(score: Score, duration: float) -> tuple[Note, ...]:
    """Notes on what was asked for where the line is over."""
    asked = [(span.name, span.start or 0.0, span.intensity) for span in score.emotions]
    asked += [("effort", span.start or 0.0, span.level) for span in score.efforts if span.source == "asked"]
    told = [
        f"{name} was asked for from {start:g} s, but the line ends at {duration:.2f} s: not shown"
        for name, start, _ in asked
        if start >= duration
    ]
    told += [
        f"{name} was asked for at {curve.times[-1]:g} s, but the line ends at {duration:.2f} s: not shown there"
        for name, start, curve in asked
        if not isinstance(curve, float | int) and start < duration < curve.times[-1] - _A_LITTLE
    ]
    told += [
        f"{span.name} was asked for to {span.end:g} s, but the line ends at {duration:.2f} s: shown up to there"
        for span in score.emotions
        if span.end is not None and (span.start or 0.0) < duration < span.end - _A_LITTLE
    ]
    told += [
        f"{curve.parameter} was asked for from {start:g} s, but the line ends at {duration:.2f} s: not shown"
        for curve in score.curves
        if (start := (curve.keys[0][0] - curve.fade) / 1000) >= duration
    ]
    return tuple(Note("warning", message) for message in dict.fromkeys(told))


def _opposed(curves: Sequence[ParameterCurve], times: NDArray[np.float64]) -> tuple[Note, ...]:
    """Notes on opposed channels that curves ask for at once."""
    if not curves:
        return ()
    asked = lay_over(np.zeros((len(times), len(channels.ALL))), channels.ALL, curves, times)
    column = channels.ALL.index
    told = [
        f"{one} and {other} were asked for at once: they are opposed, and what both have is taken off both"
        for one, other in OPPOSED
        if (np.minimum(asked[:, column(one)], asked[:, column(other)]) > 0).any()
    ]
    return tuple(Note("warning", message) for message in told)


def _of_neutral(score: Score) -> tuple[Note, ...]:
    """A note where nothing but neutral was asked for over motion that is there."""
    if not score.emotions or any(span.name != NEUTRAL for span in score.emotions):
        return ()
    return (Note("note", "neutral changes nothing: an expression is laid over the motion, none is taken off it"),)


def _spoken(utterance: Utterance, score: Score, performer: Performer, rate: FrameRate) -> MouthMotion:
    """The mouth that speaks, as it was recorded in the emotions asked for, where it was."""
    mouth = performer.mouth
    if isinstance(mouth, FeelingMouth) and len(mouth.emotions) > 1:
        from mien.motion.graph.felt_takes import felt_over

        return mouth.perform_felt(utterance, rate, felt_over(score, utterance.duration, mouth.emotions))
    return mouth.perform(utterance, rate)


@one_thread
def express(animation: Animation, score: Score, performer: Performer, seed: int = 0) -> Animation:
    """Lay expressions over finished motion, ours or imported (Deng et al. 2004).

    Parameters
    ----------
    animation : Animation
        Where its phones are known, the lips stay shut where they must.
    score : Score
        The emotions; added to those that the animation answers to.
    performer : Performer
        Whose expressions.
    seed : int

    Returns
    -------
    Animation
        The same frames, sound and markers; edits by hand cannot be taken off it any more.
    """
    random, rate, motion = np.random.default_rng(seed), animation.rate, animation.channels.select(channels.ALL).values
    duration = len(motion) / rate.fps
    line, spoken = None, animation.utterance
    if score.emotions and len(spoken.phones):
        line = line_of(spoken, stressed_words(spoken) if len(spoken.words) else (), motion, rate)
    expression = performer.expression.perform(score, duration, rate, random, neutral=False, line=line)[: len(motion)]
    seal = HandMadeMouth().seals(animation.utterance, rate)[0][: len(motion), None]
    share = np.ones((len(motion), 1))
    share[: len(seal)] -= seal
    share = share + (1 - share) * performer.expression.sealed_share
    felt = expression * share * _beside_rounded_lips(motion)
    felt[:, _LIDS] *= 1 - np.clip(motion[:, _BLINK].max(axis=1, keepdims=True), 0, 1)  # blinks are in the motion
    values = motion + felt
    values[:, _BLINK] = 1 - (1 - motion[:, _BLINK]) * (1 - np.clip(felt[:, _BLINK], 0, 1))
    values[:, _WEIGHTS] = np.clip(values[:, _WEIGHTS], 0.0, 1.0)
    values = apart(values, channels.ALL)
    told = "the edits by hand are part of the motion now: the expression lies over them"
    return replace(
        animation,
        channels=ChannelTrack(channels.ALL, values, rate),
        score=replace(animation.score, emotions=animation.score.emotions + score.emotions),
        notes=animation.notes
        + performer.expression.notes(score)
        + _outside(score, duration)
        + _of_neutral(score)
        + ((Note("note", told),) if animation.edits is not None else ()),
        edits=None,
    )


def blend(
    mouth: NDArray[np.float64], expression: NDArray[np.float64], idle: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Lay expression and idle motion over the speaking mouth; all of shape (frames, channels).

    An expression takes what room speech leaves: of a channel that speech holds at 0.3, it moves the other 0.7. So an
    emotional mouth still articulates, and nothing stands at its ceiling. A smile gives way to rounded lips.
    A blink takes the lids from whatever holds them: squint and wide eyes fade as the lids close.
    Weights are kept in [0, 1]; head angles add up.
    """
    room = _beside_rounded_lips(mouth)
    room[:, _WEIGHTS] *= 1 - np.clip(mouth[:, _WEIGHTS], 0.0, 1.0)
    values: NDArray[np.float64] = mouth + expression * room + idle
    blink = np.clip(idle[:, _BLINK].max(axis=1), 0, 1)
    values[:, _LIDS] *= 1 - blink[:, None]
    values[:, _BLINK] = 1 - (1 - np.clip((mouth + expression)[:, _BLINK], 0, 1)) * (1 - blink[:, None])
    values[:, _WEIGHTS] = np.clip(values[:, _WEIGHTS], 0.0, 1.0)
    return values


def _beside_rounded_lips(mouth: NDArray[np.float64]) -> NDArray[np.float64]:
    """Share of each channel of an expression that remains beside what the mouth says, shape of ``mouth``."""
    table, share = emotion_table()["rounded"], np.ones_like(mouth)
    rounded = np.clip(mouth[:, _ROUND].sum(axis=1, keepdims=True), 0.0, 1.0)
    share[:, [channels.ALL.index(name) for name in table["channels"]]] -= table["gives_way"] * rounded
    return share


def direct(
    values: NDArray[np.float64],
    curves: Sequence[ParameterCurve],
    times: NDArray[np.float64],
    share: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Lay the score's curves over motion, at times of shape (frames,); all else of shape (frames, channels).

    What is added gives way where the lips are shut, by ``share`` as expressions do; what is set is set exactly. Lids
    that a curve closes let go of squint and wide eyes. Weights are kept in [0, 1], and one of two opposed channels at
    most is above zero (`mien.core.opposed_channels`).
    """
    if not curves:
        return apart(values, channels.ALL)
    values = lay_over(values, channels.ALL, curves, times, share)
    asked = lay_over(np.zeros_like(values), channels.ALL, [c for c in curves if c.mode == "add"], times)
    values[:, _LIDS] *= 1 - np.clip(asked[:, _BLINK].max(axis=1, keepdims=True), 0, 1)
    values[:, _WEIGHTS] = np.clip(values[:, _WEIGHTS], 0.0, 1.0)
    untouched = np.full_like(values, -1.0)
    held = lay_over(untouched, channels.ALL, [c for c in curves if c.mode == "set"], times) != untouched
    return apart(values, channels.ALL, held)
