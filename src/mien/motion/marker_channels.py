"""Between a speaker's markers and the channels of a face: where the markers sit on the face, and what moves them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mien.capture.cleaning.normalise import best_similarity
from mien.capture.layouts import load_layout
from mien.core import channels
from mien.face.library import load_face
from mien.face.marker_sites import place_markers
from mien.face.model import Face
from mien.face.retargeting import Retargeter, basis_at
from mien.motion.mouth.learned_mouth import NOT_BY_MARKERS

__all__ = ["MarkerChannels"]

Floats = NDArray[np.float64]


class MarkerChannels:
    """The channels of a face that move its marker places as a speaker's markers moved, and the way back.

    Parameters
    ----------
    layout : str
        Name of the marker layout.
    markers : sequence of str
        Of the layout.
    rest : ndarray, shape (markers, 3)
        The speaker's markers at rest, mm.
    face : Face or None
        None takes the default face.
    """

    def __init__(self, layout: str, markers: Sequence[str], rest: Floats, face: Face | None = None) -> None:
        face, known = face or load_face("default"), load_layout(layout)
        known.index(markers)  # names that the layout lacks are told
        placed = place_markers(face, known, markers)
        self.rest, sites = rest, placed.sites
        self.turn = best_similarity(rest, placed.places, np.ones(len(sites)), scale=True)[:3, :3]
        sought = [name for name in channels.ARKIT if name not in NOT_BY_MARKERS and not name.startswith("eyeLook")]
        moved = {name for name in sought if any(name in part.targets for part in face.parts)}
        self.retargeter = Retargeter(face, sites, [name for name in sought if name in moved])
        self.columns = [channels.ALL.index(name) for name in self.retargeter.channels]
        self._basis = basis_at(face, sites, channels.WEIGHTS)

    def channels_of(self, displacement: Floats, fps: float) -> Floats:
        """Channels, shape (frames, channels), of displacements in the speaker's axes, (frames, markers, 3), mm."""
        values = np.zeros((len(displacement), len(channels.ALL)))
        values[:, self.columns] = self.retargeter.solve(displacement @ self.turn.T, fps).weights
        return values

    def positions_of(self, values: Floats) -> Floats:
        """Where the speaker's markers would stand, shape (frames, markers, 3), mm: the face's motion, to their size."""
        moved = np.einsum("tc,cmx->tmx", values[:, : len(channels.WEIGHTS)], self._basis)
        return np.asarray(self.rest + moved @ np.linalg.inv(self.turn).T)
