"""A face made from a person's numbers: the default head reshaped, with its own skin, eyes, brows, hair and clothes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mien.face.cast.beard import beard_part
from mien.face.cast.eyes import iris_picture, wet_line
from mien.face.cast.hair import hair_parts
from mien.face.cast.made_person import Person, looks
from mien.face.cast.noise import smoothstep
from mien.face.cast.people import head_weights
from mien.face.cast.skin_paint import paint_skin, skin_tone
from mien.face.contact import lip_seam
from mien.face.head_reshaping import reshaped_face
from mien.face.head_space import SKIN, HeadSpace, head_space
from mien.face.model import Face, Material, Part, Target
from mien.face.surface import vertex_normals

__all__ = ["make_face"]

_POSES: tuple[dict[str, float], ...] = (
    {},
    {"jawOpen": 0.3, "mouthSmileLeft": 1.0, "mouthSmileRight": 1.0},
    {"jawOpen": 0.7},
    {"jawOpen": 0.3, "mouthLowerDownLeft": 1.0, "mouthLowerDownRight": 1.0},
)
_OFF_NECK = 1.0  # mm that a collar stands off the skin at least
_ROOM = 2.5  # mm of flesh in front of gums
_LEFT_OUT = ("hair", "hair_clumps")
_BROWS = np.array([0.90, 0.88, 0.86])

Floats = NDArray[np.floating]


def make_face(person: Person) -> Face:
    """The face of a person, moved by the same channels as the default face; the same person gives the same face.

    Examples
    --------
    >>> from mien.face.cast.made_person import made_up
    >>> face = make_face(made_up("m", 44, "asian", seed=3))
    >>> "jawOpen" in face.part("skin").targets
    True
    """
    space = head_space()
    weights = head_weights(person.sex, person.age, person.shares, person.features, (person.weight, person.muscle))
    face = reshaped_face(space, _sealed(space, space.shape(weights)), person.name).face
    parts = {part.name: part for part in face.parts if part.name not in _LEFT_OUT}
    back = _too_far_forward(space, face)
    for name in ("teeth_upper", "teeth_lower", "tongue"):
        parts[name] = replace(parts[name], vertices=parts[name].vertices - np.array([0, 0, back], np.float32))
    parts[SKIN] = replace(parts[SKIN], material=_skin_material(person, parts[SKIN].material))
    parts["shirt"] = _dyed(_fitted(space, parts["shirt"], parts[SKIN]), person)
    parts["brows"] = _brows(parts["brows"], person)
    parts["lashes"] = replace(parts["lashes"], material=replace(parts["lashes"].material, colour=(0.075, 0.06, 0.055)))
    iris = iris_picture(parts[face.eyes[0].part].material.texture, person)
    for eye in face.eyes:
        parts[eye.part] = replace(parts[eye.part], material=replace(parts[eye.part].material, texture=iris))
    parts["tears"] = wet_line(space, face, person)
    parts["caruncles"] = _toned(parts["caruncles"], person)
    face = replace(face, parts=tuple(parts.values()))
    added = hair_parts(space, face, person)
    beard = beard_part(space, face, person)
    return replace(face, parts=(*face.parts, *added, *((beard,) if beard else ())))


def _sealed(space: HeadSpace, skin: NDArray[np.float64]) -> NDArray[np.float64]:
    """The skin with lips that lie on each other at rest as the default's do, pair by pair, but closer in depth.

    First where the default's lips touch, then once more where their edges are measured.
    """
    lips = lip_seam()
    marks = [name for name in space.face.sites if name.startswith("lip_upper_inner")]
    edges = [
        np.array([space.face.sites[mark.replace("upper", side)][1] for mark in marks]) for side in ("upper", "lower")
    ]
    touching = [np.r_[lips.upper.indices, edges[0]], np.r_[lips.lower.indices, edges[1]]]
    for (upper, lower), nearest, least, rounds in ((touching, 4, 0.2, 12), (edges, 3, 1.5, 8)):
        wanted = (space.rest[upper] - space.rest[lower]) * np.array([1.0, 1.0, 0.25])
        for _ in range(rounds):
            apart = skin[upper] - skin[lower] - wanted
            moved = np.zeros_like(skin)
            for edge, pull, share in ((upper, lips.upper_pull, -0.5), (lower, lips.lower_pull, 0.5)):
                near = np.flatnonzero(pull > 0.01)
                away, pairs = cKDTree(space.rest[edge]).query(space.rest[near], k=nearest)
                weight = 1 / np.maximum(away, least) ** 3
                weight /= weight.sum(axis=1, keepdims=True)
                moved[near] += 2 * pull[near, None] * share * np.einsum("nk,nkc->nc", weight, apart[pairs])
            skin = skin + moved
    return skin


def _posed(part: Part, pose: Mapping[str, float]) -> NDArray[np.float64]:
    vertices = part.vertices.astype(np.float64)
    for name, weight in pose.items():
        if name in part.targets:
            vertices[part.targets[name].vertices] += weight * part.targets[name].offsets
    return vertices


def _too_far_forward(space: HeadSpace, face: Face) -> float:
    """By how much the teeth must go back to keep off the skin in front of them what the default's do, mm."""

    def room(owner: Face) -> NDArray[np.float64]:
        found = []
        for pose in _POSES:
            skin = _posed(owner.part(SKIN), pose)
            facing = vertex_normals(skin, space.triangles)[:, 2] > 0.3
            front = skin[facing & (space.inside_mouth < 0.3) & (space.lips < 0.6) & (space.rest[:, 2] > 0)]
            tree = cKDTree(front[:, :2])
            for name in ("teeth_upper", "teeth_lower"):
                points = _posed(owner.part(name), pose)
                points = points[(points[:, 2] > points[:, 2].max() - 14) & (np.abs(points[:, 0]) < 20)]
                away, near = tree.query(points[:, :2])
                found.append((front[near, 2] - points[:, 2])[away < 4].min())
        return np.array(found)

    wanted = np.minimum(room(space.face), _ROOM)
    return float(np.clip((wanted - room(face)).max(), 0, 6))


def _skin_material(person: Person, material: Material) -> Material:
    return replace(
        material,
        texture=paint_skin(person),
        roughness=0.55 + 0.06 * person.ageing - 0.02 * person.tone,
        specular=0.30 + 0.03 * person.tone,
        scatter=0.60 - 0.22 * person.tone,
        folds=0.85 + 0.75 * person.ageing,
    )


def _fitted(space: HeadSpace, shirt: Part, skin: Part) -> Part:
    """The shirt as far off the neck as the default's is off the default neck, where it is near it."""
    own = space.face.part("shirt").vertices.astype(np.float64)
    away, near = cKDTree(space.rest).query(own, k=4)
    share = 1 / np.maximum(away, 0.5) ** 2
    share /= share.sum(axis=1, keepdims=True)
    placed = np.einsum("nk,nkc->nc", share, skin.vertices[near] + own[:, None] - space.rest[near])

    def height(points: NDArray[np.float64], ground: NDArray[np.float64]) -> tuple[Floats, Floats]:
        normal = np.einsum("nk,nkc->nc", share, vertex_normals(ground, space.triangles)[near])
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-6)
        return ((points - np.einsum("nk,nkc->nc", share, ground[near])) * normal).sum(axis=1), normal

    wanted, (low, normal) = height(own, space.rest)[0], height(placed, skin.vertices.astype(np.float64))
    placed = placed + np.maximum(np.maximum(wanted, _OFF_NECK) - low, 0)[:, None] * normal
    held = smoothstep(24.0, 8.0, away[:, 0])[:, None]
    return replace(shirt, vertices=(shirt.vertices + held * (placed - shirt.vertices)).astype(np.float32))


def _dyed(shirt: Part, person: Person) -> Part:
    shade = shirt.colours / np.maximum(shirt.colours.mean(axis=0), 1e-6)
    colours = np.clip(shade * np.asarray(person.shirt, np.float32), 0, 1).astype(np.float32)
    return replace(shirt, colours=colours)


def _toned(part: Part, person: Person) -> Part:
    colours = part.colours * np.float32(1 - 0.35 * person.tone)
    return replace(part, colours=colours.astype(np.float32))


def _brows(brows: Part, person: Person) -> Part:
    """The default brows, thinner or thicker, in the colour of the hair."""
    each = 7  # vertices of one hair (`ribbons` of three steps)
    count = len(brows.vertices) // each
    half = count // 2
    chance = np.random.default_rng([person.seed, 5])
    keep = np.tile(chance.uniform(size=half) < np.clip(0.30 + 0.75 * person.brows, 0, 1), 2)
    rows = (np.flatnonzero(keep)[:, None] * each + np.arange(each)).ravel()
    number = np.full(len(brows.vertices), -1)
    number[rows] = np.arange(len(rows))
    triangles = number[brows.triangles]
    triangles = triangles[(triangles >= 0).all(axis=1)].astype(np.int32)
    hairs = brows.vertices.reshape(count, each, 3)
    middle = (
        hairs[:, 0:2].mean(axis=1, keepdims=True),
        hairs[:, 2:4].mean(axis=1, keepdims=True),
        hairs[:, 4:6].mean(axis=1, keepdims=True),
    )
    wide = np.float32(0.62 + 0.45 * person.brows)
    hairs = np.concatenate(
        [m + wide * (hairs[:, 2 * k : 2 * k + 2] - m) for k, m in enumerate(middle)] + [hairs[:, 6:]], axis=1
    )
    targets = {}
    for name, target in brows.targets.items():
        chosen = number[target.vertices] >= 0
        targets[name] = Target(number[target.vertices[chosen]].astype(np.int32), target.offsets[chosen])
    dark, light = (np.array(colour) for colour in person.hair_colour)
    colour = 0.88 * (dark + 0.65 * (light - dark)) + 0.12 * skin_tone(person.tone)
    silver = np.array(looks()["hair_colours"]["grey"][1])
    red, green, blue = np.clip((colour + 0.8 * person.grey * (silver - colour)) / 0.8 * _BROWS, 0, 1).tolist()
    return replace(
        brows, vertices=hairs.reshape(-1, 3)[rows], triangles=triangles, uv=brows.uv[rows], colours=brows.colours[rows],
        head_weight=brows.head_weight[rows], targets=targets,
        material=replace(brows.material, colour=(red, green, blue)),
    )  # fmt: skip
