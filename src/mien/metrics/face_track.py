"""`FaceTrack`: a face in motion, brought to common ground so that any two can be compared.

Channels (an animation, face capture) are shown on the default face: its landmarks are where the skin's vertices go.
Markers are laid on the places of their layout by the rigid markers, frame by frame. Either way there are landmarks by
name in millimetres, in the axes of the head (x to the speaker's left, y up, z forward), and the head's own turning
apart from them.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mien.capture.cleaning.normalise import least_squares
from mien.capture.layouts import Layout, find_layout, load_layout
from mien.core.channels import HEAD, WEIGHTS
from mien.core.errors import InputError
from mien.core.timeline import FrameRate, Tier
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.corpus.take import Take
from mien.face.library import load_face
from mien.face.marker_sites import load_marker_places, place_markers

__all__ = ["LANDMARKS", "FaceTrack", "landmark_names", "shown_landmarks"]

Array = NDArray[np.float64]

LANDMARKS = "mediapipe-218"
"""The layout whose markers are the landmarks of a shown face; every other layout's markers are among them."""
_IRISES = range(468, 478)  # gaze is read from the channels
_SAME_INSTANT = 1e-9


@dataclass(frozen=True, eq=False)
class FaceTrack:
    """A face in motion, ready to be compared.

    Attributes
    ----------
    name : str
        What it is called in messages.
    landmarks : MarkerTrack
        In the axes of the head, mm; NaN where one was not seen.
    head : ndarray, shape (frames, 3), or None
        Yaw, pitch and roll in degrees (`mien.core.channels.HEAD`); None where the head's motion is not known.
    channels : ChannelTrack or None
        The 0..1 weights, where the motion came as such.
    phones, words : Tier or None
        What is said, where it is known.
    depth : bool
        Whether depth was measured; a tracker of one camera guesses it.
    """

    name: str
    landmarks: MarkerTrack
    head: Array | None = None
    channels: ChannelTrack | None = None
    phones: Tier | None = None
    words: Tier | None = None
    depth: bool = True

    @classmethod
    def of_channels(cls, channels: ChannelTrack, name: str = "channels", phones: Tier | None = None) -> FaceTrack:
        """Channels as the default face shows them; the head turns only if its channels are among them.

        Examples
        --------
        >>> track = ChannelTrack(("jawOpen",), [[0.0], [0.5]], FrameRate.of(25))
        >>> shown = FaceTrack.of_channels(track)
        >>> lips = shown.places(("2.2", "2.3"))
        >>> bool(np.linalg.norm(lips[1, 0] - lips[1, 1]) > 10)
        True
        """
        head = channels.select(HEAD).values if set(HEAD) & set(channels.names) else None
        return cls(name, shown_landmarks(channels), head, channels, phones)

    @classmethod
    def of_markers(
        cls,
        markers: MarkerTrack,
        name: str = "markers",
        layout: Layout | None = None,
        phones: Tier | None = None,
        *,
        scale: bool = False,
    ) -> FaceTrack:
        """Markers as recorded, mm, the head moving: laid on the layout's places by its rigid markers in every frame.

        Parameters
        ----------
        markers : MarkerTrack
        name : str
        layout : Layout or None
            None takes the smallest known one that has every marker.
        phones : Tier or None
        scale : bool
            Fit a scale in every frame too, for what one camera saw.

        Raises
        ------
        InputError
            If no layout has these markers, or fewer than three rigid ones are among them.
        """
        layout = layout or find_layout(markers.names, name)
        rigid = [marker for marker in layout.rigid if marker in markers.names]
        if len(rigid) < 3:
            raise InputError(
                f"{name}: expected three rigid markers of {layout.name} or more ({', '.join(layout.rigid[:4])}...) to "
                f"take the head's motion out, got {len(rigid)}"
            )
        known = [marker for marker in markers.names if marker in layout.markers]
        chosen = MarkerTrack(known, markers.positions[:, [markers.names.index(m) for m in known]], markers.rate)
        laid = least_squares(chosen, rigid, layout.places[layout.index(known)], scale=scale)
        return cls(name, laid.track, _angles(laid.head), None, phones, depth=not scale)

    @classmethod
    def of_take(cls, take: Take) -> FaceTrack:
        """A take of a corpus: its markers are in the axes of the head already, its head is known apart."""
        head = None if take.head is None else _angles(take.head)
        by_camera = load_layout(take.layout).name == LANDMARKS
        return cls(take.name, take.markers, head, take.channels, take.phones, take.words, depth=not by_camera)

    @property
    def rate(self) -> FrameRate:
        """Frame rate of all that it holds."""
        return self.landmarks.rate

    @property
    def times(self) -> Array:
        """Seconds of every frame, shape (frames,)."""
        return self.rate.times(len(self.landmarks))

    @property
    def seen(self) -> frozenset[str]:
        """Landmarks that were seen in one frame at least."""
        known = np.isfinite(self.landmarks.positions).all(axis=2).sum(axis=0)
        return frozenset(name for name, frames in zip(self.landmarks.names, known, strict=True) if frames)

    def places(self, names: Sequence[str]) -> Array:
        """Landmarks by name, shape (frames, names, 3)."""
        known = {name: place for place, name in enumerate(self.landmarks.names)}
        missing = [name for name in names if name not in known]
        if missing:
            raise InputError(f"{self.name}: lacks the landmarks {', '.join(missing[:4])}")
        return self.landmarks.positions[:, [known[name] for name in names]]

    def resampled(self, rate: FrameRate, frames: int) -> FaceTrack:
        """The same motion at another frame rate, by straight lines between its frames; NaN after its end."""
        if rate == self.rate and frames == len(self.landmarks):
            return self
        times = rate.times(frames)
        channels = self.channels
        if channels is not None:
            held = _between(channels.values, self.times, np.minimum(times, self.times[-1]))
            channels = ChannelTrack(channels.names, held, rate)
        return replace(
            self,
            landmarks=MarkerTrack(self.landmarks.names, _between(self.landmarks.positions, self.times, times), rate),
            head=None if self.head is None else _between(self.head, self.times, times),
            channels=channels,
        )

    def only(self, names: Collection[str]) -> FaceTrack:
        """The same with some of its landmarks."""
        kept = [place for place, name in enumerate(self.landmarks.names) if name in names]
        track = self.landmarks
        landmarks = MarkerTrack([track.names[place] for place in kept], track.positions[:, kept], track.rate)
        return replace(self, landmarks=landmarks)


def landmark_names() -> tuple[str, ...]:
    """Names of the landmarks of a shown face: those of `LANDMARKS` that lie on the skin.

    Examples
    --------
    >>> names = landmark_names()
    >>> len(names), names[0]
    (208, '11.1')
    """
    return _sites()[0]


def shown_landmarks(channels: ChannelTrack) -> MarkerTrack:
    """Where the landmarks of the default face are when channels move it, the head held still.

    The skin is posed linearly, so that the landmarks need no more of the mesh than their own vertices: the same places
    as `mien.formats.c3d.face_markers` gives, thousands of times faster.

    Parameters
    ----------
    channels : ChannelTrack
        A channel that it lacks rests.

    Returns
    -------
    MarkerTrack
        Of `landmark_names`, mm, in the axes of the head.
    """
    names, rest, moves = _sites()
    weights = channels.select(WEIGHTS).values
    return MarkerTrack(names, rest + np.einsum("fc,cld->fld", weights, moves), channels.rate)


@cache
def _sites() -> tuple[tuple[str, ...], Array, Array]:
    """Landmarks on the default face: names, places at rest (landmarks, 3), moves (channels, landmarks, 3)."""
    face, layout = load_face("default"), load_marker_places(LANDMARKS)
    eyes = {layout.landmarks[number] for number in _IRISES}
    names = tuple(name for name in layout.markers if name not in eyes)
    sites = place_markers(face, layout, names).sites
    rest = np.array([face.part(part).vertices[vertex] for part, vertex in sites], dtype=np.float64)
    moves = np.zeros((len(WEIGHTS), len(names), 3))
    for landmark, (part, vertex) in enumerate(sites):
        for name, target in face.part(part).targets.items():
            at = np.flatnonzero(target.vertices == vertex)
            if name in WEIGHTS and len(at):
                moves[WEIGHTS.index(name), landmark] = target.offsets[at[0]]
    return names, rest, moves


def _angles(head: Array) -> Array:
    """Yaw, pitch and roll in degrees of transforms (frames, 4, 4), as `mien.face.posing.head_rotation` turns."""
    turns = head[:, :3, :3] / np.cbrt(np.linalg.det(head[:, :3, :3]))[:, None, None]
    yaw = np.arctan2(turns[:, 0, 2], turns[:, 2, 2])
    nod = np.arcsin(np.clip(-turns[:, 1, 2], -1.0, 1.0))
    tip = np.arctan2(turns[:, 1, 0], turns[:, 1, 1])
    return np.asarray(np.degrees(np.stack([yaw, -nod, -tip], axis=1)), dtype=np.float64)


def _between(values: Array, times: Array, wanted: Array) -> Array:
    """Values by straight lines between frames, along the first axis; NaN outside, and beside a NaN."""
    if len(times) == 1:
        return np.where((wanted == times[0]).reshape(-1, *[1] * (values.ndim - 1)), values, np.nan)
    before = np.clip(np.searchsorted(times, wanted + _SAME_INSTANT, side="right") - 1, 0, len(times) - 2)
    share = ((wanted - times[before]) / (times[before + 1] - times[before])).reshape(-1, *[1] * (values.ndim - 1))
    share = np.where(np.abs(share - np.round(share)) < _SAME_INSTANT, np.round(share), share)
    low, high = values[before], values[before + 1]
    mixed = np.where(share == 0, low, np.where(share == 1, high, low * (1 - share) + high * share))
    return np.asarray(np.where((share < 0) | (share > 1), np.nan, mixed))
