"""The recorded person: their neutral face, a head of our space shaped after it, and what each channel does on it."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from mien.capture.cleaning.normalise import best_similarity
from mien.capture.head import fit_head_to_markers
from mien.capture.knowledge import knowledge, source_named
from mien.capture.layouts import Layout, load_layout
from mien.capture.openings import Seen, openings_of
from mien.core.errors import InputError
from mien.core.tracks import MarkerTrack
from mien.face.head_reshaping import reshaped_face
from mien.face.head_space import head_space
from mien.face.library import load_face
from mien.face.marker_sites import place_markers
from mien.face.model import Face
from mien.face.retargeting import basis_at

__all__ = ["Person", "fit_person", "neutral_markers"]

Floats = NDArray[np.float64]

_IRIS = 468  # landmarks from here on sit on eyeballs
_OVAL = (
    338, 297, 332, 284, 251, 389, 356, 454, 323, 361, 288, 397, 365, 379, 378, 400, 377, 148, 176, 149, 150, 136,
    172, 58, 132, 93, 234, 127, 162, 21, 54, 103, 67, 109,
)  # fmt: skip
_LIDS = ((159, 145), (386, 374))
_LOWEST_LIDS = 0.3  # share of the frames that are left out of the neutral upper face
_FEWEST = 12
_LOWER_LIP = (14, 17, 87, 317)
_SPEAKS_MM = 1.0  # standard deviation of the lower lip's height: less is no speech
_ALONG = 0.3  # of the lower lip's way: markers that an opening jaw takes along
_IN_SPEECH, _LEAST_CARRIED = 0.85, 0.3  # of the way beside the lip's that the jaw alone gives, what speech has at least
_SEEN = 0.5  # share of frames in which a marker has to be there
_GAUSS = 1.4826 / np.sqrt(6.0)  # from the median of second differences to a standard deviation


@dataclass(frozen=True, eq=False)
class Person:
    """Whom a recording shows.

    Attributes
    ----------
    layout : str
    source : str
        ``tracker`` or ``optical``.
    markers : tuple of str
        Those that are used.
    neutral : ndarray, shape (markers, 3)
        At rest, as recorded, mm.
    turn : ndarray, shape (3, 3)
        From the recording's axes and size to the face's.
    head : ndarray, shape (components,)
        In the space of heads, standard deviations.
    channels : tuple of str
        Those that are sought.
    basis : ndarray, shape (channels, markers, 3)
        What each does at 1 on this head, mm.
    region : ndarray of int, shape (markers,)
        Of `mien.capture.knowledge.Knowledge.regions`; -1: not heard.
    noise : ndarray, shape (markers, 3)
        Standard deviation from frame to frame, measured, mm.
    openings : tuple of Seen
    depth : float
        How much of the lips' motion in depth is reported (`mien.capture.one_camera.reported_depth`); 0: not known.
    raised : float
        How much the upper lip is reported to rise for each lowering of the lower one by a jaw, beyond what people do
        (`mien.capture.one_camera.reported_raising`).
    """

    layout: str
    source: str
    markers: tuple[str, ...]
    neutral: Floats
    turn: Floats
    head: Floats
    channels: tuple[str, ...]
    basis: Floats
    region: NDArray[np.int64]
    noise: Floats
    openings: tuple[Seen, ...]
    depth: float = 0.0
    raised: float = 0.0

    def with_markers(self, kept: Sequence[int]) -> Person:
        """The same person known by some of the markers (numbers) only.

        Raises
        ------
        InputError
            If too few of them are heard.
        """
        columns = list(kept)
        heard = int((self.region[columns] >= 0).sum())
        if heard < _FEWEST:
            raise InputError(f"capture: {heard} markers of the person are seen in this recording, {_FEWEST} are needed")
        others = np.ones(len(self.markers), dtype=bool)
        others[columns] = False
        return replace(
            self,
            markers=tuple(self.markers[column] for column in columns),
            neutral=self.neutral[columns],
            basis=self.basis[:, columns],
            region=self.region[columns],
            noise=self.noise[columns],
            openings=tuple(
                replace(seen, rows=seen.rows[columns]) for seen in self.openings if not seen.rows[others].any()
            ),
        )

    def apart_from_speech(self) -> Person:
        """The same person for motion that is added to other motion: no distance across lips or lids means shut."""
        loose = (replace(seen, opening=replace(seen.opening, shut_mm=None, shut_by=None)) for seen in self.openings)
        return replace(self, openings=tuple(loose))


def fit_person(
    tracks: Sequence[MarkerTrack],
    layout: Layout | str,
    source: str = "tracker",
    neutral: Floats | None = None,
    face: Face | None = None,
) -> Person:
    """Learn whom recordings show.

    Parameters
    ----------
    tracks : sequence of MarkerTrack
        Of one person, normalised: mm, x to the speaker's left, y up, z forward, the head's motion taken out.
    layout : Layout or str
        Whose markers these are.
    source : {"tracker", "optical"}
        Whether depth was guessed from pictures or measured.
    neutral : ndarray, shape (markers, 3), optional
        The markers at rest; found in the recordings if not given.
    face : Face, optional
        The head itself where it is known; else it is shaped after the markers at rest.

    Raises
    ------
    InputError
        If the tracks are of different markers, or too few of them are usable.
    """
    source_named(source)
    layout = load_layout(layout) if isinstance(layout, str) else layout
    if not tracks:
        raise InputError("capture: expected at least one recording of the person, got none")
    names = tracks[0].names
    if any(track.names != names for track in tracks):
        raise InputError("capture: recordings of one person need the same markers in the same order")
    frames = np.concatenate([track.positions for track in tracks])
    rest = neutral_markers(frames, names, layout) if neutral is None else np.asarray(neutral, dtype=np.float64)
    if rest.shape != (len(names), 3):
        raise InputError(f"capture: expected a neutral face of {len(names)} markers x 3, got {rest.shape}")
    if np.nanmax(rest.max(axis=0) - rest.min(axis=0), initial=0.0) <= 0 and np.isfinite(rest).all():
        raise InputError("capture: all markers of the neutral face lie in one place")
    region = knowledge().regions_at(layout.places[layout.index(names)])
    iris = {name for number, name in layout.landmarks.items() if number >= _IRIS}
    there = np.isfinite(frames).all(axis=2).mean(axis=0) >= _SEEN
    usable = [i for i, name in enumerate(names) if name not in iris and there[i] and np.isfinite(rest[i]).all()]
    heard = sum(region[i] >= 0 for i in usable)
    if heard < _FEWEST:
        raise InputError(
            f"capture: {heard} of {len(names)} markers lie on lips, lids, brows, nose, cheeks or chin and are seen in "
            f"half of the frames; {_FEWEST} or more are needed"
        )
    chosen = tuple(names[i] for i in usable)
    head = np.zeros(0)
    if face is None:
        with threadpool_limits(1):  # the same bits on any number of threads
            head, face = _shaped(rest[usable], chosen, layout, source)
    placed = place_markers(face, layout, chosen)
    turn = best_similarity(rest[usable], placed.places, np.ones(len(usable)), scale=True)[:3, :3]
    sought = [name for name in knowledge().channels[source] if any(name in part.targets for part in face.parts)]
    basis = basis_at(face, placed.sites, sought)
    basis[[n for n, name in enumerate(sought) if name.startswith(("jaw", "mouth"))]] *= _mouth_size(face)
    moving = np.abs(basis).max(axis=(1, 2)) > 0.05
    sought, basis = [n for n, moves in zip(sought, moving, strict=True) if moves], basis[moving]
    if source == "tracker" and "jawOpen" in sought:
        jaw, moved = sought.index("jawOpen"), (frames[:, usable] - rest[usable]) @ turn.T
        basis[jaw] *= _carried(moved, basis[jaw], chosen, layout)[:, None]
    seen = openings_of(layout.landmarks, chosen, rest[usable] @ turn.T, frames[:, usable] @ turn.T)
    return Person(
        layout=layout.name,
        source=source,
        markers=chosen,
        neutral=rest[usable],
        turn=turn,
        head=head,
        channels=tuple(sought),
        basis=basis,
        region=region[usable],
        noise=_noise([track.positions[:, usable] @ turn.T for track in tracks]),
        openings=seen,
    )


def _shaped(rest: Floats, markers: Sequence[str], layout: Layout, source: str) -> tuple[Floats, Face]:
    """The head of the space whose markers lie most like these, and its face."""
    space, rim = head_space(), _rim(layout)
    placed, on_rim = place_markers(space.face, layout, markers), np.array([name in rim for name in markers])
    fitted = fit_head_to_markers(space, placed, rest, source_named(source), on_rim)
    return fitted.weights, reshaped_face(space, fitted.skin, "captured").face


def _mouth_size(face: Face) -> float:
    """How far motion of the mouth counts against the eyes' distance, and not only against the head's own proportions.

    Recordings are brought to size, and scored, by the outer corners of the eyes. A mouth that opens 10 mm in a long
    face opens less of that face: in proportion to the face the default head shows less than was recorded, in
    proportion to the eyes more than a face of its shape would. The geometric mean of both is taken.
    """
    across = [
        abs(f.part(a[0]).vertices[a[1], 0] - f.part(b[0]).vertices[b[1], 0])
        for f, a, b in (
            (f, f.sites["eye_outer_left"], f.sites["eye_outer_right"]) for f in (face, load_face("default"))
        )
    ]
    return float(np.sqrt(across[0] / across[1]))


def _carried(moved: Floats, jaw: Floats, markers: Sequence[str], layout: Layout) -> Floats:
    """How far the jaw takes each marker along beside how far it does on our heads, shape (markers,), 1 at most.

    Chins come along more or less from person to person, and of drawn faces the tracker reports half of a chin's way.
    What is missing of it would be taken for a lip drawn down from a jaw that hardly opens, at each open vowel.
    """
    shares = np.ones(len(markers))
    place = {name: number for number, name in enumerate(markers)}
    lip = [place[layout.landmarks[n]] for n in _LOWER_LIP if layout.landmarks.get(n) in place]
    there = np.isfinite(moved).all(axis=(1, 2))
    height = moved[there, :, 1]
    if not lip or len(height) < _FEWEST or height[:, lip].mean(axis=1).std() < _SPEAKS_MM:
        return shares
    height = height - height.mean(axis=0)
    lowered = height[:, lip].mean(axis=1)
    ours = jaw[:, 1] / jaw[lip, 1].mean()
    along = ours > _ALONG
    slope = (lowered[:, None] * height).sum(axis=0) / (lowered**2).sum()  # not by BLAS: the same bits on any threads
    shares[along] = np.clip(slope[along] / (_IN_SPEECH * ours[along]), _LEAST_CARRIED, 1.0)
    return shares


def _rim(layout: Layout) -> set[str]:
    """Markers on the rim of the face: a tracker's oval."""
    return {layout.landmarks[number] for number in _OVAL if number in layout.landmarks}


def neutral_markers(frames: Floats, names: Sequence[str], layout: Layout) -> Floats:
    """The person at rest, shape (markers, 3).

    The lower face is the median of frames with shut lips and little motion. Brows and lids wander slowly and are at
    rest most of the time, so the upper face (the layout's group ``upper``) is the median of all frames but those with
    the lowest lids: give neutral recordings, or the neutral face, of a person who is not neutral.

    Raises
    ------
    InputError
        If no frame shows the lips.
    """
    groups, place = layout.motion_groups(), {name: number for number, name in enumerate(names)}
    if groups.upper_lip not in place or groups.lower_lip not in place:
        raise InputError(
            f"capture: no markers {groups.upper_lip} and {groups.lower_lip}: a lip above and one below are needed"
        )
    upper, lower = place[groups.upper_lip], place[groups.lower_lip]
    opening = np.linalg.norm(frames[:, upper] - frames[:, lower], axis=1)
    seen = np.isfinite(opening)
    if not seen.any():
        raise InputError("capture: no frame shows both lips: no neutral face can be found")
    step = np.full(len(frames), np.inf)
    step[1:] = _median(np.linalg.norm(np.diff(frames, axis=0), axis=2), axis=1)
    shut = seen & (opening <= max(np.quantile(opening[seen], 0.15), opening[seen].min() + 0.2))
    still = shut & (step <= _median(step[shut]))
    chosen = frames[still if still.any() else shut]
    middle = _median(chosen, axis=0)
    away = _median(np.linalg.norm(chosen - middle, axis=2), axis=1)
    near = chosen[away <= np.nanquantile(away, 0.5)]
    rest = _median(near, axis=0)
    upper_face = [place[name] for name in layout.groups["upper"] if name in place]
    rest[upper_face] = _median(_eyes_open(frames, place, layout)[:, upper_face], axis=0)
    return np.asarray(rest)


def _eyes_open(frames: Floats, place: Mapping[str, int], layout: Layout) -> Floats:
    """The frames without the lowest lids; all where lids are not marked."""
    pairs = [[place.get(layout.landmarks.get(n, "")) for n in pair] for pair in _LIDS]
    gaps = [
        frames[:, upper, 1] - frames[:, lower, 1] for upper, lower in pairs if upper is not None and lower is not None
    ]
    if not gaps:
        return frames
    gap = np.mean(gaps, axis=0)
    return frames[gap >= np.nanquantile(gap, _LOWEST_LIDS)] if np.isfinite(gap).any() else frames


def _median(values: Floats, axis: int | None = None) -> Any:
    """The median of what was seen; NaN, without a warning, where nothing was."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return np.nanmedian(values, axis=axis)


def _noise(tracks: Sequence[Floats]) -> Floats:
    """Standard deviation of each coordinate: by the median second difference, which motion hardly changes."""
    bends = [np.abs(np.diff(track, 2, axis=0)) for track in tracks if len(track) > 2]
    if not bends:
        return np.zeros(tracks[0].shape[1:])
    return np.asarray(_GAUSS * np.nan_to_num(_median(np.concatenate(bends), axis=0)))
