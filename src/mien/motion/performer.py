"""`Performer`: the models that together make one person's way of moving."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import Note
from mien.core.timeline import FrameRate, Tier
from mien.core.utterance import Utterance
from mien.motion.alive.idle import HandMadeIdle
from mien.motion.alive.visual_prosody import HandMadeProsody
from mien.motion.expression.hand_made_performance import hand_made_expression
from mien.motion.expression.line import Line
from mien.motion.mouth.hand_made_mouth import HandMadeMouth, MouthMotion
from mien.speech.stressed_vowels import StressedWord
from mien.text.score import Score

if TYPE_CHECKING:
    from mien.motion.maps.emotion_maps import EmotionMaps

__all__ = ["ExpressionModel", "FeelingMouth", "IdleModel", "MouthModel", "Performer", "ProsodyModel"]


class MouthModel(Protocol):
    """Phones in, mouth motion out."""

    def perform(self, utterance: Utterance, rate: FrameRate) -> MouthMotion:
        """Mouth channels and lip seal for every frame that covers the sound."""


@runtime_checkable
class FeelingMouth(Protocol):
    """A mouth that was recorded in several emotions."""

    @property
    def emotions(self) -> tuple[str, ...]:
        """Those in which speech was recorded."""

    def perform_felt(self, utterance: Utterance, rate: FrameRate, felt: Tier) -> MouthMotion:
        """As `MouthModel.perform`; ``felt`` says where which emotion is asked for."""


class ExpressionModel(Protocol):
    """Emotions in, expression channels out."""

    @property
    def names(self) -> tuple[str, ...]:
        """Emotions that can be asked for."""

    @property
    def sealed_share(self) -> NDArray[np.float64]:
        """Share of each channel that remains while the lips are sealed, shape (channels,)."""

    def check(self, score: Score) -> None:
        """Refuse a score that asks for what the model does not have."""

    def effort(self, score: Score, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """How hard the emotions asked for let the words be articulated, shape (times,); 1 as recorded."""

    def notes(self, score: Score) -> tuple[Note, ...]:
        """What should be known about the emotions asked for."""

    def perform(
        self,
        score: Score,
        duration: float,
        rate: FrameRate,
        random: np.random.Generator,
        *,
        neutral: bool = True,
        line: Line | None = None,
    ) -> NDArray[np.float64]:
        """Expression channels, shape (frames, channels); ``neutral`` False: nothing where no emotion is asked for."""


class IdleModel(Protocol):
    """Blinks, glances, head sway."""

    def perform(
        self, utterance: Utterance, rate: FrameRate, random: np.random.Generator, score: Score = ...
    ) -> NDArray[np.float64]:
        """Idle channels, shape (frames, channels), of somebody who feels what the score says."""


class ProsodyModel(Protocol):
    """Accents and phrase ends of the voice, shown by brows and head."""

    def perform(
        self, utterance: Utterance, words: Sequence[StressedWord], rate: FrameRate, random: np.random.Generator
    ) -> NDArray[np.float64]:
        """Channels, shape (frames, channels)."""


@dataclass(frozen=True)
class Performer:
    """One person's way of moving.

    Attributes
    ----------
    name : str
    mouth, expression, idle, prosody
        The models for speech, emotion, signs of life and the accents of the voice.
    emotion_maps : EmotionMaps or None
        How their recorded motion changes from one emotion to another.

    Examples
    --------
    >>> Performer.hand_made().name
    'hand-made'
    """

    name: str
    mouth: MouthModel
    expression: ExpressionModel
    idle: IdleModel
    prosody: ProsodyModel = field(default_factory=HandMadeProsody)
    emotion_maps: EmotionMaps | None = None

    @classmethod
    def hand_made(cls) -> Performer:
        """The performer that needs no recordings: key shapes, poses and rules made by hand."""
        return cls("hand-made", HandMadeMouth(), hand_made_expression(), HandMadeIdle())
