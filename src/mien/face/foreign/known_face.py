"""A face of another maker as it is driven: by names first, and by what targets do where names say nothing.

A target whose name is not known is likened to our channels by what it moves (`target_geometry`). It is used where the
likeness is sure and nothing else on the face does that channel's work; otherwise it is listed as a proposal.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mien.core.channels import MOUTH, WEIGHTS
from mien.core.errors import InputError, Note
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.face.foreign.drawn import drawn_face, not_drawn
from mien.face.foreign.gltf_document import GltfDocument
from mien.face.foreign.recognition import UNKNOWN, UNNAMED, Drive, DrivenMesh, DrivenTarget, ForeignFace, foreign_face
from mien.face.foreign.rig_names import Match, OwnNames
from mien.face.foreign.target_geometry import Likeness, Registration, likenesses
from mien.face.model import Face

__all__ = [
    "BY_MOTION", "FEWEST", "LEAST_MOUTH", "Reach", "all_targets", "face_by_channels", "known_face", "mouth_share",
    "note_on_mouth", "reach",
]  # fmt: skip

BY_MOTION = "what it moves"
"""Stands for a table of names where a target is known by its motion."""
FEWEST = 6
"""Targets below which a face cannot be laid over ours by its motion."""
LEAST_MOUTH = 0.5
"""Share of the mouth's motion in speech below which a face is warned about."""
_WEIGHT = {
    "jawOpen": 0.40, "mouthFunnel": 0.10, "mouthPucker": 0.10, "mouthClose": 0.08, "mouthLowerDownLeft": 0.05,
    "mouthLowerDownRight": 0.05, "mouthUpperUpLeft": 0.04, "mouthUpperUpRight": 0.04, "mouthStretchLeft": 0.03,
    "mouthStretchRight": 0.03, "mouthRollLower": 0.04, "mouthRollUpper": 0.02, "mouthPressLeft": 0.01,
    "mouthPressRight": 0.01,
}  # fmt: skip
"""How much of the speaking mouth each channel carries. Hand-made, by how far it moves the lips in speech."""
_MOUTH_CENTRE, _EYES = np.array([0.0, -62.0, 20.0]), {"Left": (28.5, 0.0, 10.0), "Right": (-28.5, 0.0, 10.0)}
_APERTURE = 10.5
"""Between the lids of the default face at rest, mm."""


@dataclass(frozen=True)
class Reach:
    """How far a face goes.

    Attributes
    ----------
    opening : float
        How far the lips part at full jaw, mm on a face of our size (63 mm between the eyes).
    closing : float
        How far a blink closes the eyes, 0..1 of the opening that a face of our proportions has.
    """

    opening: float
    closing: float


def known_face(source: str | Path | GltfDocument, names: OwnNames | str | Path | None = None) -> ForeignFace:
    """Read a face in a ``.glb``, ``.vrm`` or ``.gltf`` file, known by names and by what its targets do.

    Parameters
    ----------
    source : path-like or GltfDocument
    names : OwnNames or path-like, optional
        A table of the user's own.

    Raises
    ------
    InputError
        If a file cannot be read or does not hold together.
    """
    face = foreign_face(source, names)
    asked = [
        f"{mesh.number}/{place}"
        for mesh in face.meshes
        for place, target in enumerate(mesh.targets)
        if target.still in (UNKNOWN, UNNAMED)
    ]
    if not asked:
        return face
    every = all_targets(face)
    if every is None or len({name for part in every.parts for name in part.targets}) < FEWEST:
        return face
    likely, _ = likenesses(every, asked)
    return _with(face, likely)


def face_by_channels(source: str | Path | GltfDocument, names: OwnNames | str | Path | None = None) -> Face:
    """A face of another maker laid out in mm, its targets named by channels: what every deformer can move.

    Parameters
    ----------
    source : path-like or GltfDocument
    names : OwnNames or path-like, optional
        A table of the user's own.

    Raises
    ------
    InputError
        If a file cannot be read, drawn or moved.
    """
    known = known_face(source, names)
    known.require_motion()
    face = drawn_face(known).by_channels()
    plain = {part.name: re.sub(r"\W+", "_", part.name) for part in face.parts}  # as a tree's file can name them
    return replace(
        face,
        parts=tuple(replace(part, name=plain[part.name]) for part in face.parts),
        eyes=tuple(replace(eye, part=plain[eye.part]) for eye in face.eyes),
    )


def all_targets(face: ForeignFace) -> Face | None:
    """The face in millimetres with all its targets, driven or not, as ``mesh/target``; None if it cannot be decoded."""
    if not_drawn(face):
        return None
    everything = Drive(Match("", "own", {"jawOpen": 1.0}))
    meshes = tuple(
        replace(mesh, targets=tuple(replace(target, drives=target.drives or (everything,)) for target in mesh.targets))
        for mesh in face.meshes
    )
    try:
        return drawn_face(replace(face, meshes=meshes), pictures=False).face
    except InputError:  # whoever draws it says why; it can still be driven by names
        return None


def _with(face: ForeignFace, likely: Mapping[str, Likeness]) -> ForeignFace:
    """The face with sure likenesses driven, each channel by the target that is most like it, and the rest listed."""
    done = _channels_done(face)
    taken: dict[str, str] = {}
    for key, likeness in sorted(likely.items(), key=lambda item: (-item[1].cosine, item[0])):
        if likeness.sure and not set(likeness.recipe) & (done | set(taken)):
            taken |= dict.fromkeys(likeness.recipe, key)
    driven = set(taken.values())
    by_name = {_name_of(face, key): likely[key] for key in driven}
    meshes = tuple(_mesh_with(mesh, likely, driven, by_name) for mesh in face.meshes)
    proposals = {key: likeness for key, likeness in likely.items() if key not in driven}
    return replace(face, meshes=meshes, proposals=proposals)


def _channels_done(face: ForeignFace) -> set[str]:
    """Channels that other targets do, by their names; a mouth that visemes move is done as a whole."""
    drives = [drive for mesh in face.meshes for target in mesh.targets for drive in target.drives]
    done = {channel for drive in drives for channel, weight in drive.match.recipe.items() if weight > 0}
    if any(drive.match.kind == "visemes" for drive in drives):
        done |= set(MOUTH)
    return done


def _name_of(face: ForeignFace, key: str) -> str:
    mesh, place = map(int, key.split("/"))
    return face.meshes[mesh].targets[place].name


def _mesh_with(
    mesh: DrivenMesh, likely: Mapping[str, Likeness], driven: set[str], by_name: Mapping[str, Likeness]
) -> DrivenMesh:
    """Targets of one name on other meshes of the head (teeth, lashes, brows) go with the one that is known."""
    targets: list[DrivenTarget] = []
    for place, target in enumerate(mesh.targets):
        likeness = likely[f"{mesh.number}/{place}"] if f"{mesh.number}/{place}" in driven else None
        if likeness is None and target.name and target.still == UNKNOWN:
            likeness = by_name.get(target.name)
        if likeness is not None:
            drive = Drive(Match(f"{BY_MOTION} ({likeness.cosine:.2f})", "shapes", likeness.recipe))
            target = DrivenTarget(target.name, (drive,))
        targets.append(target)
    return replace(mesh, targets=tuple(targets))


def mouth_share(face: ForeignFace) -> float:
    """Share of the mouth's motion in speech that a face can show, 0..1."""
    drives = [drive for mesh in face.meshes for target in mesh.targets for drive in target.drives]
    moved = {channel for drive in drives for channel, weight in drive.match.recipe.items() if weight > 0}
    moved |= {"jawOpen"} if face.jaw_turns else set()
    return float(sum(weight for channel, weight in _WEIGHT.items() if channel in moved) / sum(_WEIGHT.values()))


def note_on_mouth(face: ForeignFace) -> tuple[Note, ...]:
    """A warning where less than `LEAST_MOUTH` of the mouth's motion can be shown."""
    share = mouth_share(face)
    if share >= LEAST_MOUTH:
        return ()
    path = face.document.path
    said = (
        f"{path} can show {share:.0%} of the mouth's motion in speech: 'mien face inspect {path}' says what is missing"
    )
    return (Note("warning", said),)


def reach(face: ForeignFace, registration: Registration) -> Reach | None:
    """How far the face goes at full jaw and at a full blink; None if it cannot be decoded.

    Parameters
    ----------
    face : ForeignFace
    registration : Registration
        As `likenesses` found it.
    """
    if not_drawn(face) or not face.moves:
        return None
    drawn = drawn_face(face, pictures=False)
    size = float(np.mean(1.0 / registration.scale[:2]))
    mouth = registration.back(_MOUTH_CENTRE[None])[0]
    anywhere = 1.0 if registration.trusted else np.inf  # a face unlike ours is looked at as a whole
    lips = _down(drawn.face, drawn.track(_full("jawOpen")), mouth, 16.0 * size * anywhere)
    lids = [
        _down(
            drawn.face,
            drawn.track(_full(f"eyeBlink{side}")),
            registration.back(np.array([centre]))[0],
            15.0 * size * anywhere,
        )
        for side, centre in _EYES.items()
    ]
    opening = (lips.max() - max(lips.min(), 0.0)) / size if len(lips) else 0.0
    closing = min(float(each.max()) if len(each) else 0.0 for each in lids) / (_APERTURE * size)
    return Reach(round(float(opening), 1), round(float(np.clip(closing, 0.0, 1.0)), 2))


def _full(channel: str) -> ChannelTrack:
    values = np.zeros((1, len(WEIGHTS)))
    values[0, WEIGHTS.index(channel)] = 1.0
    return ChannelTrack(WEIGHTS, values, FrameRate.of(30))


def _down(face: Face, track: ChannelTrack, centre: np.ndarray, radius: float) -> np.ndarray:
    """How far down the skin about a place goes, mm, one number for each vertex."""
    eyeballs = {eye.part for eye in face.eyes}
    found = [np.zeros(0)]
    for part in face.parts:
        if part.name in eyeballs or not part.targets:
            continue
        moved = np.zeros(len(part.vertices))
        for name, weight in zip(track.names, track.values[0], strict=True):
            if weight and name in part.targets:
                moved[part.targets[name].vertices] -= weight * part.targets[name].offsets[:, 1]
        near = np.hypot(part.vertices[:, 0] - centre[0], part.vertices[:, 1] - centre[1]) < radius
        found.append(moved[near & (part.vertices[:, 2] > centre[2] - 2.0 * radius)])  # not the back of the head
    return np.concatenate(found)
