"""A parameter tree made from a face of morph targets: the skeleton by rigid motions, the rest by translations.

* head: three rotations about the pivot (yaw, pitch, roll, one inside the other), which carry what ``head_weight`` says;
  a fixed ``trunk`` holds the rest;
* jaw: the rotation that fits the target ``jawOpen`` where it moves most (Kabsch's rigid motion; its screw's axis; the
  half that fits worst is left out, so that teeth count more than skin). Every vertex rides it by the share that
  explains its offset best; what a rotation cannot say stays a leaf (``jawOpen.1``...);
* eyes: rotations about their centres;
* lids: ``eyeBlink`` turns about the eyeball's centre, so that a lid runs on an arc and not through the ball; the rest
  of that target is a leaf;
* every other target: a field of offsets is a sum of at most three products of one direction and one weight per vertex
  (its singular vectors), so at most three translations show it exactly. Fewer are taken where they hold `KEPT` of it.

Leaves hang on the jaw where it carries most of what they move, else on the head. A leaf under the jaw turns with it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.channels import ALL, HEAD
from mien.face.model import Eye, Face
from mien.face.parameter_tree import Influence, Parameter, ParameterTree

__all__ = ["KEPT", "Screw", "jaw_motion", "translations_of", "tree_of_face"]

Floats = NDArray[np.float64]
Fields = dict[str, Floats]  # offsets (n, 3) by part

KEPT = 0.999999
"""Share of a target's squared offsets that its translations hold before more are added (three hold all)."""
_SMALLEST = 5e-3  # mm at value 1: weights that move a vertex less are left out
_TRIMS = 4  # times that the worse half is left out of the jaw's fit
_LEAST_TURN = 1.0  # degrees: a jaw that turns less is taken to slide


@dataclass(frozen=True)
class Screw:
    """A rigid motion as a rotation about an axis: degrees, unit axis, a point on it (mm), and the misfit (mm, RMS)."""

    degrees: float
    axis: tuple[float, float, float]
    pivot: tuple[float, float, float]
    misfit: float


def tree_of_face(face: Face, literal: bool = False) -> ParameterTree:
    """Derive a parameter tree from a face's targets.

    Parameters
    ----------
    face : Face
    literal : bool
        As for `ParameterTree`.

    Examples
    --------
    >>> from mien.face.library import load_face
    >>> tree = tree_of_face(load_face("default"))
    >>> [p.name for p in tree.parameters if p.skeletal][:5]
    ['trunk', 'headYaw', 'headPitch', 'headRoll', 'jaw']
    """
    fields = _fields(face)
    skeleton, leaves = _skeleton(face), []
    riding: Fields = {}
    jaw_parent = HEAD[-1]
    if "jawOpen" in fields:
        screw = jaw_motion(fields["jawOpen"], _rest(face))
        if screw is not None:
            riding = _shares(face, fields["jawOpen"], screw)
            skeleton += _with_jaw(face, skeleton.pop(), screw, riding)
            fields["jawOpen"] = _remainder(face, fields["jawOpen"], screw, riding)
            jaw_parent = "jaw"
    for eye in face.eyes:
        skeleton += _eye(face, eye)
        blink = f"eyeBlink{eye.side}"
        if blink in fields:
            lid, fields[blink] = _lid(face, eye, fields[blink])
            leaves.append(lid)
    for name, field in fields.items():
        parent = jaw_parent if riding and name != "jawOpen" and _on_jaw(field, riding) else HEAD[-1]
        leaves += translations_of(name, field, {name: 1.0}, parent)
    return ParameterTree((*skeleton, *leaves), literal)


def translations_of(
    name: str,
    field: Fields,
    drives: dict[str, float],
    parent: str | None,
    most: int = 3,
    kept: float = KEPT,
    smallest: float = 5e-3,
) -> list[Parameter]:
    """Translations ``name.1``, ``name.2``... whose weighted sum is a field of offsets at value 1.

    Parameters
    ----------
    name : str
    field : dict of str to ndarray, shape (n, 3)
        Offsets in millimetres by part.
    drives : dict of str to float
    parent : str or None
    most : int
        1 is the paper's one translation per motion, 3 loses nothing.
    kept : float
        Share of the squared offsets after which no more are added.
    smallest : float
        Vertices that a translation moves less than this at value 1 are left out, mm.
    """
    parts = list(field)
    whole = np.concatenate([field[part] for part in parts]) if parts else np.zeros((0, 3))
    if not np.abs(whole).max(initial=0.0) > smallest:
        return []
    _, sizes, directions = np.linalg.svd(whole.T @ whole)
    count = min(most, 1 + int(np.searchsorted(np.cumsum(sizes) / sizes.sum(), kept)))
    bounds = np.cumsum([0, *(len(field[part]) for part in parts)])
    found = []
    for number, direction in enumerate(directions[:count], 1):
        along = whole @ direction
        reach = np.abs(along).max()
        if reach <= smallest:
            continue
        influences = {}
        for part, first, end in zip(parts, bounds, bounds[1:], strict=False):
            moved = np.flatnonzero(np.abs(along[first:end]) > smallest)
            if len(moved):
                weights = (along[first:end][moved] / reach).astype(np.float32)
                influences[part] = Influence(moved.astype(np.int32), weights)
        x, y, z = (float(c) for c in direction * reach)
        found.append(
            Parameter(f"{name}.{number}", "translation", (x, y, z), parent=parent, drives=drives, influences=influences)
        )
    return found


def jaw_motion(offsets: Fields, rest: Fields) -> Screw | None:
    """The rotation that fits a target best where it moves most; None where that is no rotation to speak of."""
    moved = {part: np.linalg.norm(field, axis=1) for part, field in offsets.items()}
    most = max((length.max(initial=0.0) for length in moved.values()), default=0.0)
    if most <= _SMALLEST:
        return None
    chosen = {part: length > 0.6 * most for part, length in moved.items()}
    before = np.concatenate([rest[part][chosen[part]] for part in offsets])
    after = before + np.concatenate([field[chosen[part]] for part, field in offsets.items()])
    if len(before) < 3:
        return None
    for _ in range(_TRIMS):
        missed = np.linalg.norm(_rigid(before, after)[1], axis=1)
        near = missed <= max(float(np.median(missed)), _SMALLEST)
        before, after = (before[near], after[near]) if near.sum() >= 12 else (before, after)
    turn = _rigid(before, after)[0]
    cosine = np.clip((np.trace(turn) - 1) / 2, -1, 1)
    axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    degrees = float(np.degrees(np.arccos(cosine)))
    if degrees < _LEAST_TURN or not axis.any():
        return None
    axis /= np.linalg.norm(axis)
    shift = after.mean(0) - turn @ before.mean(0)
    shift -= axis * (axis @ shift)  # a slide along the axis is no part of a rotation
    pivot = np.linalg.lstsq(np.eye(3) - turn, shift, rcond=None)[0]
    missed = (before - pivot) @ turn.T + pivot - after
    return Screw(
        degrees,
        (float(axis[0]), float(axis[1]), float(axis[2])),
        (float(pivot[0]), float(pivot[1]), float(pivot[2])),
        float(np.sqrt((missed**2).sum(1).mean())),
    )


def _rigid(before: Floats, after: Floats) -> tuple[Floats, Floats]:
    """The rotation (columns) of the best rigid motion (Kabsch 1976), and what it misses, (n, 3)."""
    from_, to = before - before.mean(0), after - after.mean(0)
    u, _, vt = np.linalg.svd(from_.T @ to)
    turn: Floats = (u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt).T
    return turn, from_ @ turn.T - to


def _rest(face: Face) -> Fields:
    return {part.name: part.vertices.astype(np.float64) for part in face.parts}


def _fields(face: Face) -> dict[str, Fields]:
    """Dense offsets of every target, by channel in the order of `mien.core.channels.ALL`, then by part."""
    names = {name for part in face.parts for name in part.targets}
    found: dict[str, Fields] = {}
    for name in [*(n for n in ALL if n in names), *sorted(names - set(ALL))]:
        found[name] = {}
        for part in face.parts:
            if name in part.targets:
                dense = np.zeros((len(part.vertices), 3))
                np.add.at(dense, part.targets[name].vertices, part.targets[name].offsets.astype(np.float64))
                found[name][part.name] = dense
    return found


def _influence(weights: Floats) -> Influence:
    moved = np.flatnonzero(weights != 0)
    return Influence(moved.astype(np.int32), weights[moved].astype(np.float32))


def _skeleton(face: Face) -> list[Parameter]:
    """Trunk and head; the last one, the roll, carries the head."""
    pivot = face.head_pivot
    eyeballs = {eye.part for eye in face.eyes}
    carried = {part.name: np.clip(part.head_weight.astype(np.float64), 0, 1) for part in face.parts}
    carried = {name: weight for name, weight in carried.items() if name not in eyeballs}
    trunk = {name: _influence(1 - weight) for name, weight in carried.items() if (weight < 1).any()}
    head = {name: _influence(weight) for name, weight in carried.items()}
    yaw, pitch, roll = HEAD
    turns = ((yaw, (0.0, 1.0, 0.0), None), (pitch, (-1.0, 0.0, 0.0), yaw), (roll, (0.0, 0.0, -1.0), pitch))
    chain = [Parameter(name, "rotation", axis, pivot, parent, True, {name: 1.0}) for name, axis, parent in turns]
    last = Parameter(roll, "rotation", (0.0, 0.0, -1.0), pivot, pitch, True, {roll: 1.0}, influences=head)
    return [Parameter("trunk", "fixed", skeletal=True, influences=trunk), *chain[:2], last]


def _swept(screw: Screw, rest: Floats) -> Floats:
    """How far the full rotation takes points, (n, 3)."""
    from mien.face.parameter_tree import rotation_matrix

    matrix = rotation_matrix(screw.axis, screw.pivot, screw.degrees)
    return np.asarray(rest @ matrix[:3, :3] + matrix[3, :3] - rest)


def _shares(face: Face, offsets: Fields, screw: Screw) -> Fields:
    """Share 0..1 of the rotation that explains each vertex' offset best, by part; no more than the head carries."""
    rest = _rest(face)
    shares = {}
    for part, field in offsets.items():
        swept = _swept(screw, rest[part])
        share = (field * swept).sum(1) / np.maximum((swept**2).sum(1), 1e-9)
        carried = np.clip(face.part(part).head_weight.astype(np.float64), 0, 1)
        shares[part] = np.where(np.abs(field).max(1) > _SMALLEST, np.clip(share, 0, carried), 0.0)
    return shares


def _remainder(face: Face, offsets: Fields, screw: Screw, shares: Fields) -> Fields:
    rest = _rest(face)
    return {part: field - shares[part][:, None] * _swept(screw, rest[part]) for part, field in offsets.items()}


def _with_jaw(face: Face, head: Parameter, screw: Screw, shares: Fields) -> list[Parameter]:
    """The head, which hands over to the jaw what rides it, and the jaw."""
    carried, ridden = dict(head.influences), {}
    for part, share in shares.items():
        weight = np.zeros(len(share))
        if part in carried:
            weight[carried[part].vertices] = carried[part].weights
        carried[part] = _influence(np.maximum(weight - share, 0))
        ridden[part] = _influence(share)
    kept = Parameter(head.name, head.kind, head.vector, head.pivot, head.parent, True, head.drives, None, carried)
    jaw = Parameter(
        "jaw", "rotation", screw.axis, screw.pivot, head.name, True, {"jawOpen": screw.degrees}, None, ridden
    )
    return [kept, jaw]


def _eye(face: Face, eye: Eye) -> list[Parameter]:
    """Yaw and pitch of an eyeball about its centre, as `mien.face.posing.eye_rotation`."""
    sign = 1.0 if eye.side == "Left" else -1.0
    side, name = eye.side, eye.part
    sideways = {f"eyeLookOut{side}": sign * eye.look_out, f"eyeLookIn{side}": -sign * eye.look_in}
    upright = {f"eyeLookUp{side}": eye.look_up, f"eyeLookDown{side}": -eye.look_down}
    ball = {name: _influence(np.ones(len(face.part(name).vertices)))}
    yaw = Parameter(f"{name}_yaw", "rotation", (0.0, 1.0, 0.0), eye.centre, HEAD[-1], True, sideways)
    pitch = Parameter(f"{name}_pitch", "rotation", (-1.0, 0.0, 0.0), eye.centre, yaw.name, True, upright, None, ball)
    return [yaw, pitch]


def _lid(face: Face, eye: Eye, field: Fields) -> tuple[Parameter, Fields]:
    """The lids' turn about the eyeball's centre, and what it leaves of the target.

    The angle is that of the vertex that goes farthest; the others turn by the share that explains their offset best.
    """
    rest = _rest(face)
    part, vertex = max(
        ((part, int(np.argmax(np.abs(offsets[:, 1])))) for part, offsets in field.items()),
        key=lambda place: abs(field[place[0]][place[1], 1]) if place[0] == "skin" or "skin" not in field else -1.0,
    )
    arm = rest[part][vertex] - np.array(eye.centre)
    moved = arm + field[part][vertex]
    degrees = float(np.degrees(np.arctan2(arm[1], arm[2]) - np.arctan2(moved[1], moved[2])))
    degrees = (degrees + 180.0) % 360.0 - 180.0  # about +x: from above to the front and down
    screw = Screw(degrees, (1.0, 0.0, 0.0), eye.centre, 0.0)
    influences, left = {}, {}
    for name, offsets in field.items():
        swept = _swept(screw, rest[name])
        share = (offsets * swept).sum(1) / np.maximum((swept**2).sum(1), 1e-9)
        share = np.where(np.abs(offsets).max(1) > _SMALLEST, np.clip(share, -1.0, 1.25), 0.0)
        influences[name] = _influence(share)
        left[name] = offsets - share[:, None] * swept
    drives = {f"eyeBlink{eye.side}": degrees}
    lid = Parameter(f"lids_{eye.side.lower()}", "rotation", (1.0, 0.0, 0.0), eye.centre, HEAD[-1], False, drives,
                    None, influences)  # fmt: skip
    return lid, left


def _on_jaw(field: Fields, riding: Fields) -> bool:
    """Whether the jaw carries most of what a field moves."""
    moved = {part: (offsets**2).sum(1) for part, offsets in field.items()}
    total = sum(float(size.sum()) for size in moved.values())
    carried = sum(float((size * riding[part]).sum()) for part, size in moved.items() if part in riding)
    return carried > 0.5 * total
