"""Other characters than the default one, out of the same MakeHuman data: for measuring, and for the space of heads.

`HELD_OUT` names the targets that the space of heads (`head_space.py`) never sees; the persons that figures are measured
on (`PERSONS`) are made with them, so that no figure is of a head that lies in the space.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from character import ORIGINS, neutral
from clothes import _UNDER, _collar_height
from eyelids import fit_lids
from eyes import build_eye, eye_entry, paint_eye
from head import Head, build_head
from makehuman import Floats, MakeHuman
from mouth import line_mouth, seal_lips
from muscles import add_muscles
from sculpt import Sculpt
from strength import strengthen
from subdivision import clip
from teeth import Row, build_row

from mien.face.model import Face, Material

LOWEST = -300.0
HELD_OUT = (
    "nose-hump", "nose-curve", "nose-point-up", "nose-point-down", "chin-cleft", "chin-triangle", "head-square",
    "head-diamond", "cheek-inner", "eye-corner2", "eyefold", "cupidsbow", "ear-shape", "ear-wing", "asym",
    "mouth-philtrum", "forehead-temple", "lowerlip-volume",
)  # fmt: skip


@dataclass(frozen=True)
class Recipe:
    """Sex, age and origin as MakeHuman mixes them, build, and local targets."""

    female: float
    ages: Mapping[str, float]
    origins: Mapping[str, float]
    build: str = "averagemuscle-averageweight"
    touches: Mapping[str, float] = field(default_factory=dict)


PERSONS = {
    "man": Recipe(
        0.0, {"young": 1.0}, {"caucasian": 1.0}, "averagemuscle-averageweight",
        {"nose/nose-hump-incr": 0.7, "chin/chin-cleft-incr": 0.6, "head/head-square": 0.5,
         "eyes/{side}-eye-corner2-down": 0.4, "asym/asym-jaw-1-l": 0.5, "ears/{side}-ear-wing-incr": 0.4},
    ),
    "woman": Recipe(
        1.0, {"young": 1.0}, {"asian": 1.0}, "averagemuscle-minweight",
        {"head/head-diamond": 0.5, "nose/nose-point-up": 0.5, "eyes/{side}-eye-eyefold-down": 0.4,
         "mouth/mouth-cupidsbow-incr": 0.6, "chin/chin-triangle": 0.4},
    ),
    "old-man": Recipe(
        0.0, {"old": 1.0}, {"african": 1.0}, "averagemuscle-maxweight",
        {"nose/nose-curve-convex": 0.5, "cheek/{side}-cheek-inner-decr": 0.5, "asym/asym-mouth-1-l": 0.6,
         "mouth/mouth-lowerlip-volume-incr": 0.5},
    ),
    "child": Recipe(
        0.5, {"child": 1.0}, {"african": 0.3, "asian": 0.3, "caucasian": 0.4}, "averagemuscle-averageweight",
        {"forehead/forehead-temple-incr": 0.4, "mouth/mouth-philtrum-volume-incr": 0.5},
    ),
}  # fmt: skip


def shape_of(data: MakeHuman, recipe: Recipe) -> Floats:
    """All MakeHuman vertices of a character, shape (n, 3), millimetres."""
    shape = data.vertices.copy()
    for sex, share in (("female", recipe.female), ("male", 1 - recipe.female)):
        for age, part in recipe.ages.items():
            if share * part:
                shape += share * part * data.target(f"macrodetails/universal-{sex}-{age}-{recipe.build}")
                for origin, amount in recipe.origins.items():
                    shape += share * part * amount * data.target(f"macrodetails/{origin}-{sex}-{age}")
    for name, amount in recipe.touches.items():
        for filled in sorted({name.format(side=side) for side in "lr"}):
            shape += amount * data.target(filled)
    return shape


def finished_head(data: MakeHuman, person: Floats | None = None) -> Head:
    """A head with its muscles, with lips that seal and lids that close, as the default one is baked."""
    head = build_head(data, LOWEST, person)
    strengthen(head)
    add_muscles(head)
    seal_lips(head)
    fit_lids(head, head.eye_radius * 0.99)
    line_mouth(head, _front_of_teeth(head))
    return head


def _front_of_teeth(head: Head) -> float:
    return float(head.skin.vertices[head.lip_loop][:, 2].max()) - 4.0


def cut_of_default(head: Head) -> tuple[object, object]:
    """Matrix and triangles that cut the default's refined skin as the default face is cut under its collar."""
    return clip(head.skin.triangles, _collar_height(head.skin.vertices) + _UNDER)


def person_face(data: MakeHuman, name: str, default: Head) -> tuple[Face, Head]:
    """A person's true face (its skin on the default skin's vertices, eyes and teeth its own), and its head."""
    head = finished_head(data, shape_of(data, PERSONS[name]))
    return face_of_head(head, name, default), head


def face_of_head(head: Head, name: str, default: Head) -> Face:
    """Skin, eyes, caruncles and teeth of a finished head."""
    matrix, triangles = cut_of_default(default)
    skin = head.skin.through(matrix, triangles)
    skin.shapes = {key: offsets for key, offsets in skin.shapes.items() if np.abs(offsets).max() >= 0.02}
    radius = head.eye_radius * 0.99
    eyes = [build_eye(f"eye_{s}", c, radius) for s, c in zip(("left", "right"), head.eye_centres, strict=True)]
    picture = np.rint(np.clip(paint_eye(512, seed=3), 0, 1) * 255).astype(np.uint8)
    parts = [skin.part(Material("skin", (0.80, 0.62, 0.53), roughness=0.55, specular=0.3, scatter=0.6))]
    parts += [eye.part(Material("eye", texture=picture, roughness=0.08, specular=0.8)) for eye in eyes]
    parts += [row.part(Material("teeth", roughness=0.25, specular=0.5)) for row in _teeth(head)]
    entries = tuple(
        eye_entry(f"eye_{side.lower()}", side, centre)
        for side, centre in zip(("Left", "Right"), head.eye_centres, strict=True)
    )
    return Face(name, tuple(parts), entries, (0.0, -37.4, -73.18), {}, "CC0 1.0")


def _teeth(head: Head) -> tuple[Sculpt, Sculpt]:
    points = head.skin.vertices[head.lip_loop]
    seam, front = float(points[:, 1].mean()), _front_of_teeth(head)
    upper = build_row(Row("teeth_upper", front=front, edge=seam - 2.6, half_width=27.0, depth=46.0))
    return upper, build_row(Row("teeth_lower", front=front - 2.8, edge=seam - 1.4, half_width=25.0, depth=44.0))


def random_recipe(chance: np.random.Generator, local: list[str]) -> Recipe:
    """A made-up character: any sex, age from child to old, origin and build, and a dozen local touches."""
    female = float(chance.choice([0.0, 1.0, chance.uniform()]))
    age = chance.uniform(-0.7, 1.0)
    ages = {"young": 1 - abs(age), "child" if age < 0 else "old": abs(age)}
    origins = dict(zip(ORIGINS, chance.dirichlet([0.6, 0.6, 0.6]), strict=True))
    build = f"{chance.choice(['min', 'average', 'max'])}muscle-{chance.choice(['min', 'average', 'max'])}weight"
    chosen = chance.choice(local, size=14, replace=False)
    touches = {str(name): float(abs(chance.normal(0, 0.45))) for name in chosen}
    return Recipe(female, ages, {k: float(v) for k, v in origins.items()}, build, touches)


def default_shape(data: MakeHuman) -> Floats:
    """The default character."""
    return neutral(data)
