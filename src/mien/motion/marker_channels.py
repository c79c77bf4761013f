"""Between a speaker's markers and the channels of a face: where the markers sit on the face, and what moves them.

The way to channels is that of every recording (`mien.capture`), on a face that is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mien.capture.capture import capture_take
from mien.capture.layouts import load_layout
from mien.capture.person import fit_person
from mien.core import channels
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from mien.face.library import load_face
from mien.face.marker_sites import place_markers
from mien.face.model import Face
from mien.face.retargeting import basis_at
from mien.motion.mouth.learned_mouth import BY_CAMERA

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
        sites = place_markers(face, known, markers).sites
        self.names, self.rest = tuple(markers), rest
        still = MarkerTrack(self.names, np.repeat(rest[None], 2, axis=0), FrameRate.of(25))
        source = "tracker" if layout == BY_CAMERA else "optical"
        person = fit_person([still], known, source, neutral=rest, face=face)
        # how low this person's lids come is not known here, so that no lid counts as shut; lips that touch do
        loose = (replace(seen, opening=replace(seen.opening, shut_by=None)) for seen in person.openings)
        self.person = replace(person, openings=tuple(loose))
        self._basis = basis_at(face, sites, channels.WEIGHTS)

    def channels_of(self, displacement: Floats, rate: FrameRate) -> Floats:
        """Channels, shape (frames, channels), of displacements in the speaker's axes, (frames, markers, 3), mm."""
        values = np.zeros((len(displacement), len(channels.ALL)))
        track = MarkerTrack(self.names, self.rest + displacement, rate)
        values[:, : len(channels.WEIGHTS)] = capture_take(track, self.person.layout, head=self.person).channels.values
        return values

    def positions_of(self, values: Floats) -> Floats:
        """Where the speaker's markers would stand, shape (frames, markers, 3), mm: the face's motion, to their size."""
        moved = np.einsum("tc,cmx->tmx", values[:, : len(channels.WEIGHTS)], self._basis)
        return np.asarray(self.rest + moved @ np.linalg.inv(self.person.turn).T)
