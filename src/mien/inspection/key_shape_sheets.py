"""Sheets of key shapes on a face: where each phone pulls the mouth, as learned, and hand-made."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from mien.core import channels
from mien.core.timeline import FrameRate
from mien.core.utterance import PAUSE
from mien.face.library import load_face
from mien.face.model import Face
from mien.face.posing import Poser
from mien.face.render.camera import Camera
from mien.face.render.renderer import Renderer
from mien.formats.contact_sheet import contact_sheet
from mien.motion.mouth.articulation import articulation_table
from mien.motion.mouth.learned_mouth import LearnedMouth
from mien.motion.performer_file import LearnedSpeech

__all__ = ["KeyShapes"]

Floats = NDArray[np.float64]

_CELL = (230, 200)  # width, height of one picture
_COLUMNS = 8
_NEARER = 0.62  # of the height that a close-up shows
_RATE = FrameRate.of(30)


class KeyShapes:
    """The key shapes of a performer, on a face.

    Parameters
    ----------
    learned : LearnedSpeech
    face : Face or None
        None takes the default face.

    Raises
    ------
    InputError
        If a marker of the performer has no place on the face.
    """

    def __init__(self, learned: LearnedSpeech, face: Face | None = None) -> None:
        self.learned = learned
        face = face or load_face("default")
        self.mouth = LearnedMouth(learned, face)
        self._poser = Poser(face, channels.ALL)
        width, height = _CELL
        camera = Camera.close_up(face, width / height)
        self._renderer = Renderer(face, width, height, replace(camera, field_mm=_NEARER * camera.field_mm))

    def of_speaker(self) -> dict[str, Floats]:
        """Channels of the speaker's learned targets by part (``"AY.1"``): shape (channels,)."""
        return {symbol: self._on_face(shape) for symbol, shape in self._targets().items()}

    def of_face(self) -> dict[str, Floats]:
        """Channels of the face's own hand-made key shapes by part."""
        return {symbol: self._hand_made(symbol) for symbol in self._targets()}

    def of_classes(self) -> dict[str, Floats]:
        """Channels of the key shapes between which the paper's curves run, by viseme class (or phone)."""
        paper, table = self.learned.coarticulation, articulation_table()
        groups = {**table.visemes, "pause": (PAUSE,)}
        if paper.settings.key_per_phone:
            groups = {phone: (phone,) for phone in paper.keys_}
        found = {}
        for name, members in groups.items():
            shape = paper.mouth_.motion_of(paper.space_.decode(paper.keys_[members[0]][None]))[0]
            found[name if len(members) < 2 else f"{name}: {' '.join(members)}"] = self._on_face(shape)
        return found

    def sheet(self, shapes: Mapping[str, Floats], columns: int = _COLUMNS) -> Image.Image:
        """Lay shapes out, each with its name."""
        pictures = [self._renderer.render(self._poser.pose(values)) for values in shapes.values()]
        return Image.fromarray(contact_sheet(pictures, [name.replace("_", " ") for name in shapes], columns))

    def _targets(self) -> dict[str, Floats]:
        """Where the mouth of the speaker is pulled, as it was learned, by part of speech."""
        table, motion = articulation_table(), self.learned.motion
        targets: dict[str, Floats] = {}
        for phone in _in_classes():
            names = [table.symbols[number] for number in table.parts[phone]]
            targets |= dict(zip(names, motion.key_shapes(phone), strict=True))
        return targets

    def _on_face(self, shape: Floats) -> Floats:
        return np.asarray(self.mouth.on_face(shape[None], _RATE)[0])

    def _hand_made(self, symbol: str) -> Floats:
        phone, _, number = symbol.partition(".")
        hand_made = self.mouth.hand_made
        if phone == PAUSE:
            return hand_made.rest.shape
        names = hand_made.visemes_of(phone)
        return hand_made.visemes[names[min(int(number or 1), len(names)) - 1]].shape


def _in_classes() -> Sequence[str]:
    """All phones, those that look alike side by side, the pause last."""
    return [phone for members in articulation_table().visemes.values() for phone in members] + [PAUSE]
