"""The learned mouth on a face: what was learned from a recorded speaker, all of it.

A performer that learned in channels (`mien.motion.mouth.mouth_space`) gives the weights of the face's channels as they
are. One that learned in markers, as the papers have it, has its markers laid onto the face by the similarity transform
that best brings the mouth at rest to their places (`mien.capture.layouts`); their displacements are what the face has
to do, by bounded least squares (`mien.face.retargeting`).

In pauses the mouth comes to rest as the face has it (`resting`): recorded people hold it half open before they speak.
Hand-made key shapes (``assets/performance/visemes.toml``) serve only what no recording shows: the tongue, the lip on
the teeth at labiodentals, and consonants that the performer never heard (`by_hand`) or that English lacks.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.capture.cleaning.normalise import best_similarity
from mien.capture.layouts import load_layout
from mien.core import channels
from mien.core.errors import InputError
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.tracks import MarkerTrack
from mien.core.utterance import PAUSE, Utterance
from mien.face.library import load_face
from mien.face.marker_sites import place_markers
from mien.face.model import Face
from mien.face.retargeting import Retargeter
from mien.motion.mouth.coverage import Coverage, heard_phones
from mien.motion.mouth.hand_made_mouth import HandMadeMouth, MouthMotion
from mien.motion.mouth.mouth_space import ChannelSpace, MarkerSpace
from mien.motion.mouth.speech_model import synthesise
from mien.motion.performer_file import LearnedSpeech
from mien.text.phones import is_vowel

__all__ = ["BY_CAMERA", "NOT_BY_MARKERS", "LearnedMouth", "by_hand", "resting"]

Floats = NDArray[np.float64]

NOT_BY_MARKERS = (*channels.BEYOND_ARKIT, "tongueOut", "cheekPuff", "mouthClose", "jawForward")
"""Mouth channels that are not sought: markers do not see the tongue; muscles beyond ARKit's serve expressions; lips
shut over an open jaw are left to seals."""
DEPTH = 0.1
"""How much the depth of a marker counts where one camera saw it, against its height and its side."""
BY_CAMERA = "mediapipe-218"
"""The layout of markers that one camera saw."""
_BLOCK = 4096  # frames
_TONGUE = [channels.ALL.index(name) for name in (*channels.TONGUE, "tongueOut")]
STAYS, LEAVES, EASE = 0.12, 0.05, 0.2
"""Seconds after speech in which the mouth stays as it learned to, before speech in which it moves so, and in which it
comes to rest and leaves it. Hand-made."""
_LIP_ON_TEETH = ("F", "V")
_ON_TEETH_SHARPNESS = 2.0
"""Power of the share with which the hand-made lip on the teeth takes over: above 1 it waits until the lip is near."""


class LearnedMouth:
    """Mouth motion from phones, as learned from recordings.

    Parameters
    ----------
    learned : LearnedSpeech
    face : Face or None
        On which markers are laid, if it learned in markers; None takes the default face.
    speech_model : str or None
        See `LearnedSpeech.model`; None takes the performer's own.

    Raises
    ------
    InputError
        If a marker of the performer has no place on the face, or it lacks the speech model.
    """

    def __init__(self, learned: LearnedSpeech, face: Face | None = None, speech_model: str | None = None) -> None:
        self.learned = learned
        self.speech = learned.model(speech_model)
        self.hand_made = HandMadeMouth()
        space = self.speech.mouth_
        self._markers = None if isinstance(space, ChannelSpace) else _OnFace(learned, space, face)
        self._columns = [channels.ALL.index(name) for name in space.names] if self._markers is None else []

    @property
    def hand_made_phones(self) -> tuple[str, ...]:
        """Consonants that were never recorded, whose key shapes are hand-made; vowels move like their kin."""
        return by_hand(self.learned.motion.coverage_)

    @property
    def emotions(self) -> tuple[str, ...]:
        """Emotions in which the speech that performs was recorded."""
        recorded = self.learned.recorded
        return () if recorded is None or self.speech is self.learned.motion else recorded.emotions

    def perform(self, utterance: Utterance, rate: FrameRate) -> MouthMotion:
        """Mouth channels and lip seal for every frame that covers the sound; markers, if it learned in them."""
        return self.perform_felt(utterance, rate, None)

    def perform_felt(self, utterance: Utterance, rate: FrameRate, felt: Tier | None) -> MouthMotion:
        """The same with the way of speaking of recorded emotions, where ``felt`` says so (`emotions`)."""
        times = rate.times(rate.frames_covering(utterance.duration))
        motion = synthesise(self.speech, utterance.phones, times, utterance.audio, felt)
        values, markers = self.on_face(motion, rate), None
        if self._markers is not None:
            markers = MarkerTrack(self._markers.space.names, motion, rate)
        del motion
        moves, hand_made = 1 - resting(utterance.phones, times)[:, None], self.hand_made.over(utterance, rate)
        own = utterance.shapes or ((),) * len(utterance.phones)
        unheard = set(self.hand_made_phones)
        unknown = [phone.label in unheard or bool(names) for phone, names in zip(utterance.phones, own, strict=True)]
        on_teeth = [phone.label in _LIP_ON_TEETH for phone in utterance.phones]
        share = self.hand_made.share_of(utterance, rate, unknown)
        share = np.maximum(share, self.hand_made.share_of(utterance, rate, on_teeth) ** _ON_TEETH_SHARPNESS)[:, None]
        seal = np.empty(len(values))
        for first in range(0, len(values), _BLOCK):  # a long line is not held many times over
            here, own_way = slice(first, first + _BLOCK), values[first : first + _BLOCK]
            by_hand_here = hand_made(times[here])
            seal[here] = by_hand_here[:, -1]
            own_way *= moves[here]
            own_way[:, _TONGUE] = by_hand_here[:, _TONGUE]
            values[here] = own_way * (1 - share[here]) + by_hand_here[:, :-1] * share[here]
        return MouthMotion(values=values, seal=seal, markers=markers)

    def on_face(self, motion: Floats, rate: FrameRate) -> Floats:
        """What a speech model gives as channels of the face, shape (frames, channels)."""
        if self._markers is not None:
            return self._markers.channels_of(motion, rate)
        values = np.zeros((len(motion), len(channels.ALL)))
        values[:, self._columns] = motion
        return values


def by_hand(coverage: Coverage) -> tuple[str, ...]:
    """Phones whose key shapes are hand-made: consonants that were never heard.

    A vowel that was never heard is well told from others by how open, round and front it is, and moves as the person
    moves; consonants are not.
    """
    return tuple(phone for phone, count in heard_phones(coverage).items() if not count and not is_vowel(phone))


def resting(phones: Tier, times: Floats) -> Floats:
    """How far the mouth has come to rest in pauses, 0 in speech and about it to 1, shape (frames,).

    Examples
    --------
    >>> said = Tier("phones", (Interval(0.0, 0.5, "SIL"), Interval(0.5, 0.7, "AA"), Interval(0.7, 0.9, "SIL")))
    >>> resting(said, np.array([0.0, 0.2, 0.48, 0.6, 0.75, 2.0])).tolist()
    [1.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    """
    spoken = [phone for phone in phones if phone.label != PAUSE]
    if not spoken:
        return np.ones(len(times))
    ends = np.array([-np.inf, *(phone.end for phone in spoken)])
    starts = np.array([*(phone.start for phone in spoken), np.inf])
    place = np.searchsorted(starts[:-1], times, side="right")  # of the stretch between two phones
    since, until = times - ends[place], starts[place] - times
    come = np.clip((since - STAYS) / EASE, 0.0, 1.0)
    leave = np.clip((until - LEAVES) / EASE, 0.0, 1.0)
    return np.asarray((1 - np.cos(np.pi * np.minimum(come, leave))) / 2)


class _OnFace:
    """Markers of a speaker on a face."""

    def __init__(self, learned: LearnedSpeech, space: object, face: Face | None) -> None:
        assert isinstance(space, MarkerSpace)
        self.space = space
        layout = load_layout(space.layout)
        homeless = [name for name in space.names if name not in layout.markers]
        if homeless:
            raise InputError(
                f"performer {learned.name!r}: {', '.join(homeless[:5])} have no place in layout {layout.name!r}"
            )
        face = face or load_face("default")
        placed = place_markers(face, layout, space.names)
        pause = Tier("phones", (Interval(0.0, 4.0, PAUSE),))
        self.rest: Floats = learned.motion.synthesise(pause, np.array([2.0]))[0]  # the mouth in a long pause
        self.to_face = best_similarity(self.rest, placed.places, np.ones(len(space.names)), scale=True)[:3, :3]
        sought = tuple(name for name in channels.MOUTH if name not in NOT_BY_MARKERS)
        depth = DEPTH if space.layout == BY_CAMERA else 1.0
        self.retargeter = Retargeter(face, placed.sites, sought, depth=depth)

    def channels_of(self, positions: Floats, rate: FrameRate) -> Floats:
        """Channels that move the face's marker places as the speaker's markers move, shape (frames, channels)."""
        found = self.retargeter.solve((positions - self.rest) @ self.to_face.T, rate.fps).weights
        values = np.zeros((len(positions), len(channels.ALL)))
        values[:, [channels.ALL.index(name) for name in self.retargeter.channels]] = found
        return values
