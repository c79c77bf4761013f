"""The learned mouth on a face: what was learned from a recorded speaker drives the face's morph targets.

Two answers are mixed:

* *marker motion*: the speaker's markers are laid onto the face by the similarity transform that best brings the mouth
  at rest to the places of the markers on the face (`mien.capture.layouts`); their displacements are what the face has
  to
  do, by bounded least squares (`mien.face.retargeting`). It is the speaker's own motion, as large or small as theirs
  was, and knows lips only as far as the tracker did;
* *key shapes*: the speaker's learned influence curves (`mien.motion.mouth.influence`) blend the face's own authored key
  shapes. This is how the paper uses its curves ("blending these key shapes by concatenating the learned co-articulation
  models", Deng et al. 2006, section VI): timing and co-articulation are the speaker's, the range is the face's.

What markers cannot tell stays authored: the tongue's shapes, and the exact shape of the face's lips where they must be
sealed.
"""

from __future__ import annotations

from collections.abc import Sequence

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
from mien.motion.mouth.articulation import articulation_table, parts_of
from mien.motion.mouth.hand_made_mouth import AuthoredMouth, MouthMotion
from mien.motion.mouth.influence import influence_of
from mien.motion.mouth.speech_model import synthesise
from mien.motion.performer_file import LearnedSpeech

__all__ = ["CLARITY", "KEY_SHAPE_SHARE", "LearnedMouth"]

Floats = NDArray[np.float64]

KEY_SHAPE_SHARE = 0.8
"""Default share of the face's key shapes against the speaker's marker motion. Authored: chosen by looking."""
CLARITY = 4.0
"""Default power of the influences under which key shapes are blended: 1 as learned (least squares averages over many
takes and mumbles), more for clearer speech. Authored: chosen by looking."""
NOT_BY_MARKERS = (*channels.BEYOND_ARKIT, "tongueOut", "cheekPuff", "mouthClose", "jawForward")
"""Mouth channels that are not sought: markers do not see the tongue; muscles beyond ARKit's serve expressions; lips
shut over an open jaw are left to seals."""
SEAL_SHARPNESS = 2.0
"""Power of the seal with which the authored closed shape takes over: above 1 it waits until the lips nearly meet."""


class LearnedMouth:
    """Mouth motion from phones, as learned from recordings, for a face with known marker places.

    Parameters
    ----------
    learned : LearnedSpeech
    face : Face or None
        None takes the default face. On another one the markers are placed by `mien.face.marker_sites`.
    key_shape_share : float
        0: the speaker's marker motion alone; 1: the face's key shapes under the speaker's influence curves alone.

    clarity : float
        How sharply one key shape gives way to the next: 1 as learned, more for clearer speech.
    speech_model : str or None
        What moves the markers: ``coarticulation``, ``graph`` or ``both``; None takes the performer's own. Key shapes
        are blended by the learned influence curves whatever it is.

    Raises
    ------
    InputError
        If a marker of the performer has no place on the face, or a setting is out of range.
    """

    def __init__(
        self,
        learned: LearnedSpeech,
        face: Face | None = None,
        key_shape_share: float = KEY_SHAPE_SHARE,
        clarity: float = CLARITY,
        speech_model: str | None = None,
    ) -> None:
        if not 0 <= key_shape_share <= 1:
            raise InputError(f"a share of key shapes runs from 0 to 1, not {key_shape_share:g}")
        if not clarity > 0:
            raise InputError(f"a clarity is above 0 (1: as learned), not {clarity:g}")
        self.learned, self.key_shape_share, self.clarity = learned, key_shape_share, clarity
        self.speech = learned.model(speech_model)
        self.authored = AuthoredMouth()
        layout, markers = load_layout(learned.motion.layout_), learned.motion.markers_
        homeless = [name for name in markers if name not in layout.markers]
        if homeless:
            raise InputError(
                f"performer {learned.name!r}: {', '.join(homeless[:5])} have no place in layout {layout.name!r}"
            )
        face = face or load_face("default")
        placed = place_markers(face, layout, markers)
        self.rest = self._resting()
        self._to_face = best_similarity(self.rest, placed.places, np.ones(len(markers)), scale=True)[:3, :3]
        self._retargeter = Retargeter(face, placed.sites, _sought_channels())

    def perform(self, utterance: Utterance, rate: FrameRate) -> MouthMotion:
        """Mouth channels, lip seal and marker motion for every frame that covers the sound."""
        times = rate.times(rate.frames_covering(utterance.duration))
        positions = synthesise(self.speech, utterance.phones, times, utterance.audio)
        keyed, share = (
            self.by_key_shapes(utterance.phones, times, self.authored.shapes_of(utterance)),
            self.key_shape_share,
        )
        values = keyed * share + self.by_markers(positions, rate) * (1 - share)
        tongue = [channels.ALL.index(name) for name in (*channels.TONGUE, "tongueOut")]
        values[:, tongue] = keyed[:, tongue]
        seal, sealed = self.authored.seals(utterance, rate)
        taken = (seal**SEAL_SHARPNESS)[:, None]
        values = values * (1 - taken) + sealed / np.maximum(seal, 1e-9)[:, None] * taken
        markers = MarkerTrack(self.learned.motion.markers_, positions, rate)
        return MouthMotion(values=values, seal=seal, markers=markers)

    def by_markers(self, positions: Floats, rate: FrameRate) -> Floats:
        """Channels that move the face's marker places as the speaker's markers move, shape (frames, channels)."""
        found = self._retargeter.solve((positions - self.rest) @ self._to_face.T, rate.fps).weights
        values = np.zeros((len(positions), len(channels.ALL)))
        values[:, [channels.ALL.index(name) for name in self._retargeter.channels]] = found
        return values

    def by_key_shapes(self, phones: Tier, times: Floats, names: Sequence[tuple[str, ...]] | None = None) -> Floats:
        """The face's key shapes under the speaker's influence curves, shape (frames, channels).

        ``names`` are the key shapes of each phone, where they are not those of the English phone.

        A part's influence is the mean over the strands, each weighed by how far it moves the mouth.
        """
        curves, table = self.learned.motion.curves_, articulation_table()
        parts = curves.place(phones, times)
        strands = curves.curves(parts.described)
        strength = np.linalg.norm(curves.shapes_, axis=1) * strands[:, 0].std(axis=0)
        if not strength.any():
            return np.zeros((len(times), len(channels.ALL)))
        influence = (influence_of(strands, parts) @ (strength / strength.sum())) ** self.clarity
        influence /= influence.sum(axis=1, keepdims=True)
        symbols = np.argmax(parts.described[:, -len(table.symbols) :], axis=1)
        shapes = np.array([self._key_shape(symbol) for symbol in table.symbols])[symbols]
        if names is not None:
            self._take_own_shapes(shapes, phones, names)
        values: Floats = np.einsum("tp,tpc->tc", influence, shapes[parts.index])
        return values

    def _take_own_shapes(self, shapes: Floats, phones: Tier, names: Sequence[tuple[str, ...]]) -> None:
        """Put the key shapes that the phones ask for in their rows, shape (parts with the pauses around, channels)."""
        ahead, parts = self.learned.motion.curves_.settings.neighbours, parts_of(phones)
        for row, place in enumerate(parts.phones):
            if place < 0 or phones.intervals[place].label == PAUSE:
                continue
            asked = names[place]
            number = int(row > 0 and parts.phones[row - 1] == place)  # the second part of a diphthong
            shapes[ahead + row] = self.authored.visemes[asked[min(number, len(asked) - 1)]].shape

    def _key_shape(self, symbol: str) -> Floats:
        """Authored channels of a part of speech such as ``M`` or ``AY.2``."""
        phone, _, number = symbol.partition(".")
        if phone == PAUSE:
            return self.authored.rest.shape
        names = self.authored.visemes_of(phone)
        return self.authored.visemes[names[min(int(number or 1), len(names)) - 1]].shape

    def _resting(self) -> Floats:
        """The speaker's mouth in a long pause, shape (markers, 3), mm."""
        pause = Tier("phones", (Interval(0.0, 4.0, PAUSE),))
        rest: Floats = self.learned.motion.synthesise(pause, np.array([2.0]))[0]
        return rest


def _sought_channels() -> tuple[str, ...]:
    return tuple(name for name in channels.MOUTH if name not in NOT_BY_MARKERS)
