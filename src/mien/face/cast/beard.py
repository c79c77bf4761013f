"""Beards: strands that grow out of the skin and move with it."""

from __future__ import annotations

import numpy as np

from mien.face.cast.made_person import Person, looks
from mien.face.cast.noise import smoothstep
from mien.face.cast.scalp import beard_growth
from mien.face.cast.strands import Ground, Roots, along, roots_drawn, strands_part
from mien.face.head_space import SKIN, HeadSpace
from mien.face.model import Face, Part, Target

__all__ = ["beard_part"]


def beard_part(space: HeadSpace, face: Face, person: Person) -> Part | None:
    """The beard, moved by the skin that it grows from; None without one."""
    if not person.beard:
        return None
    style, chance = looks()["beards"][person.beard], np.random.default_rng([person.seed, 4])
    ground = Ground(space, face)
    red = 1 - smoothstep(0.05, 0.3, space.lips)
    growth = beard_growth(space.rest, style) * red * (space.inside_mouth < 0.5)
    roots = roots_drawn(ground, growth, int(style["count"]), chance, lambda rest: beard_growth(rest, style))
    keep = (space.lips[roots.corners] * roots.shares).sum(axis=1) < 0.12
    keep &= (space.inside_mouth[roots.corners] * roots.shares).sum(axis=1) < 0.3
    roots = Roots(*(field[keep] for field in vars(roots).values()))
    count, x, y = len(roots.place), roots.rest[:, 0], roots.rest[:, 1]
    upper = (y > -60) & (np.abs(x) < 30)
    aside = np.where(upper, np.sign(x) * smoothstep(0.0, 10.0, np.abs(x)) * 1.1, 0.12 * np.sign(x))
    way = np.stack([aside, np.where(upper, -0.75, -1.0), np.where(upper, 0.1, 0.15)], axis=1)
    growing = beard_growth(roots.rest, style)
    length = float(style["length"]) * chance.uniform(0.6, 1.15, count) * (0.35 + 0.65 * growing)
    length = length * np.where(upper, 0.6, 1.0) * (0.6 + 0.4 * smoothstep(-60.0, -85.0, y))
    heading = along(way, roots.normal) + 0.35 * roots.normal + 0.2 * chance.normal(size=(count, 3))
    heading /= np.linalg.norm(heading, axis=1, keepdims=True)
    curve = np.array([0.0, -0.3, 0.0]) + 0.12 * chance.normal(size=(count, 3))
    t = np.linspace(0, 1, 3)[None, :, None]
    line = (
        roots.place[:, None]
        - 0.3 * roots.normal[:, None]
        + length[:, None, None] * (t * heading[:, None] + t**2 * curve[:, None])
    )
    normals = np.repeat(roots.normal[:, None], 3, axis=1)
    layer = chance.uniform(0.35, 1.0, count)
    part = strands_part(
        "beard", line, normals, float(style["width"]) * chance.uniform(0.8, 1.3, count), layer, person, chance
    )
    each = len(part.vertices) // count
    targets = {}
    for name, target in face.part(SKIN).targets.items():
        offsets = np.zeros((len(space.rest), 3))
        offsets[target.vertices] = target.offsets
        moved = np.einsum("kc,kcd->kd", roots.shares, offsets[roots.corners])
        chosen = np.flatnonzero(np.abs(moved).max(axis=1) > 0.02)
        if len(chosen):
            rows = (chosen[:, None] * each + np.arange(each)).ravel()
            targets[name] = Target(rows.astype(np.int32), np.repeat(moved[chosen], each, axis=0).astype(np.float32))
    return Part(**{**vars(part), "targets": targets, "head_weight": np.ones(len(part.vertices), np.float32)})
