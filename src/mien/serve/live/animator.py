"""Sound in, frames out, with a stated look-ahead and no clock: the pure half of ``mien live``."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mien.core import channels
from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.core.opposed_channels import apart
from mien.core.timeline import FrameRate
from mien.core.utterance import PAUSE
from mien.motion.expression.endless_motion import endless_expression, endless_idle
from mien.motion.mouth.streaming_mouth import StreamingMouth, without_sound
from mien.motion.performer import Performer
from mien.pipeline.perform import blend
from mien.serve.live.heard_emotion import HeardEmotion, HeardExpression
from mien.speech.phone_stream import PhoneStream
from mien.speech.streaming_features import RATE
from mien.text.score import Score

__all__ = [
    "DEFAULT_LOOK_AHEAD",
    "LONGEST_LOOK_AHEAD",
    "SHORTEST_LOOK_AHEAD",
    "LiveAnimator",
    "LiveSettings",
    "frames_of",
]

DEFAULT_LOOK_AHEAD, SHORTEST_LOOK_AHEAD, LONGEST_LOOK_AHEAD = 0.15, 0.05, 0.3

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LiveSettings:
    """What a live stream is asked for.

    Attributes
    ----------
    look_ahead : float
        Seconds of sound past an instant that are heard before the instant is shown, 0.05 to 0.3.
    rate : FrameRate
    score : Score
        Emotions that do not change with time.
    seed : int
    hear_emotion : bool
        Show the emotion that is heard in the voice (`mien.serve.live.heard_emotion`), in place of the score's.
    """

    look_ahead: float = DEFAULT_LOOK_AHEAD
    rate: FrameRate = field(default_factory=lambda: FrameRate.of(30))
    score: Score = field(default_factory=Score)
    seed: int = 0
    hear_emotion: bool = False

    def __post_init__(self) -> None:
        if not SHORTEST_LOOK_AHEAD <= self.look_ahead <= LONGEST_LOOK_AHEAD:
            raise InputError(
                f"a look-ahead lies between {SHORTEST_LOOK_AHEAD * 1000:g} and {LONGEST_LOOK_AHEAD * 1000:g} ms, "
                f"not {self.look_ahead * 1000:g}"
            )
        if self.hear_emotion and self.score.emotions:
            raise InputError("a live stream shows the emotion that it hears ('auto'), or one that is named: not both")
        for span in self.score.emotions:
            if span.start is not None or span.end is not None or not isinstance(span.intensity, (int, float)):
                raise InputError(f"a live stream has no known length: give {span.name!r} one intensity throughout")


class LiveAnimator:
    """Turns sound into frames as it comes in.

    Parameters
    ----------
    performer : Performer
        Its mouth is driven by the phones alone (`without_sound`).
    settings : LiveSettings or None

    Attributes
    ----------
    phones : Tier
        What the last frame was made from.
    spoken : ndarray, shape (channels,)
        The mouth of the last frame, without expression and signs of life.

    Raises
    ------
    InputError
        If the performer does not have an emotion that is asked for.
    """

    def __init__(self, performer: Performer, settings: LiveSettings | None = None) -> None:
        self.settings = settings or LiveSettings()
        performer.expression.check(self.settings.score)
        rate, random = self.settings.rate, np.random.default_rng(self.settings.seed).spawn(2)
        self.stream = PhoneStream()
        self.phones, self.spoken = self.stream.phones(), np.zeros(len(channels.ALL))
        self._mouth = StreamingMouth(without_sound(performer.mouth), rate)
        self._emotion = HeardEmotion() if self.settings.hear_emotion else None
        self._expression = (
            endless_expression(performer.expression, self.settings.score, rate, random[0])
            if self._emotion is None
            else HeardExpression(performer.expression, rate, random[0], self._emotion)
        )
        self._idle = endless_idle(performer.idle, rate, random[1], self.settings.score)
        self._sealed_share = performer.expression.sealed_share
        self._warm_up(performer)

    def _warm_up(self, performer: Performer) -> None:
        """Do once, to no effect, what takes long the first time: tables are read, code is compiled."""
        heard = PhoneStream(self.stream.classifier)
        heard.push(np.zeros(RATE // 2))
        StreamingMouth(without_sound(performer.mouth), self.settings.rate).frame(0.2, heard.phones())
        blend(*(np.zeros((1, len(channels.ALL))) for _ in range(3)))

    @property
    def heard(self) -> float:
        """Seconds of sound that came in."""
        return self.stream.heard

    def hear(self, samples: NDArray[np.floating]) -> None:
        """Take sound, 16 kHz, -1..1."""
        self.stream.push(samples)
        if self._emotion is not None:
            self._emotion.hear(samples)

    def frame(self, seconds: float) -> Floats:
        """The face at an instant of the sound, shape (channels,); call it once for each frame of the stream.

        Instants run forward or stand still. What was heard past ``seconds`` is the look-ahead; where there is less of
        it than was stated, the phones are less certain.
        """
        self.phones = self.stream.phones()
        self.spoken, seal = self._mouth.frame(seconds, self.phones)
        share = 1 - seal * (1 - self._sealed_share)
        felt, alive = self._expression.next() * share, self._idle.next()
        return np.asarray(apart(blend(self.spoken[None], felt[None], alive[None]), channels.ALL)[0])


def frames_of(audio: Audio, performer: Performer, settings: LiveSettings | None = None) -> Iterator[Floats]:
    """What a live stream would show of a sound: each frame sees the sound up to its instant plus the look-ahead.

    Examples
    --------
    >>> frames = list(frames_of(Audio.silence(0.5, 16000), Performer.hand_made()))
    >>> len(frames), frames[0].shape
    (15, (71,))
    """
    for _, _, values in frames_and_phones(audio, performer, settings):
        yield values


def frames_and_phones(
    audio: Audio, performer: Performer, settings: LiveSettings | None = None
) -> Iterator[tuple[float, str, Floats]]:
    """As `frames_of`, each with its instant and the phone that is heard there."""
    animator = LiveAnimator(performer, settings)
    rate, samples = animator.settings.rate, audio.resampled(RATE).samples.astype(np.float64)
    given = 0
    for number in range(rate.frames_covering(audio.duration)):
        seconds = rate.time_of(number)
        upto = round((seconds + animator.settings.look_ahead) * RATE)
        animator.hear(samples[given:upto])
        given = max(given, min(upto, len(samples)))
        if upto > len(samples):  # the sound is over: silence follows
            animator.hear(np.zeros(upto - max(given, round(animator.heard * RATE))))
        values = animator.frame(seconds)
        phone = animator.phones.at(seconds)
        yield seconds, phone.label if phone else PAUSE, values
