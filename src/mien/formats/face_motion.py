"""What the writers of 3D formats share: normals of morph targets, turns as quaternions, facts for a player."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.animation.animation import Animation
from mien.core.errors import Note
from mien.face.deformers import lost_by_targets
from mien.face.model import Face, Part
from mien.face.posing import Poser

__all__ = ["TargetNormals", "linear_light", "lost_tree", "playing_facts", "quaternions"]

Floats = NDArray[np.float32]

# A target's change of a unit normal below this is left out: a third of a degree, half of what 8-bit shading shows.
_LEAST_NORMAL_CHANGE = 0.006
_SAMPLED = 40  # frames on which the loss of a parameter tree is measured


def lost_tree(animation: Animation, face: Face, file: str) -> tuple[Note, ...]:
    """What the file loses of a face that moves by a parameter tree: measured on a sample of the frames."""
    if face.tree is None:
        return ()
    track = animation.channels
    sample = track.values[:: max(1, len(track) // _SAMPLED)]
    worst = lost_by_targets(face, track.names, sample)
    told = f"{file} moves targets on straight lines where the parameter tree turns them about axes"
    return (Note("note", f"{told}: up to {worst:.1f} mm apart in this animation"),)


class TargetNormals:
    """Unit normals of every part at rest, and what each morph target does to them."""

    def __init__(self, face: Face) -> None:
        self._names = tuple(sorted({name for part in face.parts for name in part.targets}))
        self._poser = Poser(face, self._names)
        self._place = {part.name: number for number, part in enumerate(face.parts)}
        self._rest = self._poser.pose(np.zeros(len(self._names)))
        self._changes: dict[str, list[Floats]] = {}

    def at_rest(self, part: Part) -> Floats:
        """Unit normals of the part, shape (vertices, 3)."""
        return self._rest.parts[self._place[part.name]].normals

    def change(self, part: Part, name: str) -> Floats:
        """What the target adds to the normals at weight 1, shape (vertices, 3)."""
        if name not in self._changes:
            posed = self._poser.pose([float(other == name) for other in self._names])
            changes = [now.normals - rest.normals for now, rest in zip(posed.parts, self._rest.parts, strict=True)]
            for change in changes:
                change[np.linalg.norm(change, axis=1) < _LEAST_NORMAL_CHANGE] = 0.0
            self._changes[name] = changes
        return self._changes[name][self._place[part.name]]


def linear_light(srgb: NDArray[Any]) -> NDArray[np.float64]:
    """Linear light from sRGB values, both 0..1 (IEC 61966-2-1); glTF keeps factors and vertex colours linear."""
    srgb = np.clip(np.asarray(srgb, dtype=np.float64), 0.0, 1.0)
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def quaternions(matrices: Sequence[NDArray[np.float64]]) -> Floats:
    """Unit quaternions x, y, z, w, each on the side of the one before it, so that linear keys take the short way."""
    from scipy.spatial.transform import Rotation

    turns = np.asarray(Rotation.from_matrix(np.array(matrices)).as_quat())
    flips = np.cumprod(np.where((turns[1:] * turns[:-1]).sum(axis=1) < 0, -1.0, 1.0))
    turns[1:] *= flips[:, None]
    return turns.astype(np.float32)


def playing_facts(animation: Animation) -> dict[str, Any]:
    """What a player needs to lay the sound under the motion, and who made it."""
    speech = animation.utterance
    return {
        "audioStartSeconds": 0.0,
        "audioDurationSeconds": speech.duration,
        "fps": animation.rate.fps,
        "text": speech.text,
        "language": speech.language,
        "words": [{"start": float(word.start), "end": float(word.end), "label": word.label} for word in speech.words],
        "performer": animation.provenance.performer,
        "seed": int(animation.provenance.seed),
        "version": animation.provenance.version,
    }
