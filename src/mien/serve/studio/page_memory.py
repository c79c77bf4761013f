"""A mouth and a voice that remember what they did last: emotions and drawn intensities leave them as they are."""

from __future__ import annotations

from collections import OrderedDict
from threading import Lock

from mien.core.audio import Audio
from mien.core.timeline import FrameRate
from mien.core.utterance import Utterance
from mien.motion.mouth.hand_made_mouth import MouthMotion
from mien.motion.performer import MouthModel
from mien.serve.studio.lru_store import Kept

__all__ = ["RememberingMouth", "RememberingVoice"]


class RememberingMouth:
    """Another mouth, asked once for the same phones, sound and rate.

    Parameters
    ----------
    mouth : MouthModel
        Must give the same for the same utterance and rate, as all do.
    most : int
        How many performances are kept.
    """

    def __init__(self, mouth: MouthModel, most: int = 4) -> None:
        self.mouth, self._most = mouth, most
        self._kept: OrderedDict[tuple[object, ...], tuple[Audio, MouthMotion]] = OrderedDict()
        self._lock = Lock()

    def perform(self, utterance: Utterance, rate: FrameRate) -> MouthMotion:
        """As the other mouth."""
        audio = utterance.audio  # kept with its motion, so that no other sound comes by its id
        key = id(audio), utterance.phones, utterance.shapes, utterance.words, utterance.native, utterance.sung, rate
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key][1]
        motion = self.mouth.perform(utterance, rate)
        motion.values.setflags(write=False)
        motion.seal.setflags(write=False)
        with self._lock:
            self._kept[key] = audio, motion
            while len(self._kept) > self._most:
                self._kept.popitem(last=False)
        return motion


class RememberingVoice:
    """`mien.speech.synthesis.synthesise`, asked once for the same plain text: what is felt is given to it afterwards.

    Parameters
    ----------
    most : int
        How many texts are kept.
    """

    def __init__(self, most: int = 16) -> None:
        self._kept: Kept[Utterance] = Kept("speech", most)

    def __call__(self, text: str, **asked: object) -> Utterance:
        """As `synthesise` does."""
        from mien.speech.synthesis import synthesise

        key = repr((text, sorted(asked.items())))
        if key in self._kept:
            return self._kept.get(key)
        said = synthesise(text, **asked)  # type: ignore[arg-type]
        self._kept.put(said, name=key)
        return said
