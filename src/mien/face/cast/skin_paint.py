"""The picture of a person's skin: tone, blood, pores, freckles, age, and the shade of hair that is too short to model.

Hand-made and procedural, painted as a function of the place on the default head (so that every zone lies where it
belongs on any head), then laid out by the default skin's texture coordinates. Colours are sRGB 0..1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, zoom

from mien.face.cast.made_person import Person, looks
from mien.face.cast.noise import layered_noise, smoothstep, value_noise
from mien.face.cast.people import open_sky
from mien.face.cast.scalp import beard_growth, brow_growth, hair_depth
from mien.face.folds import drawn_folds
from mien.face.head_space import head_space
from mien.face.render.raster_maps import draw_triangles

__all__ = ["SIZE", "paint_skin", "skin_tone"]

SIZE = 2048  # texels
_PAINTED = 1024  # texels of all that is not finer than a millimetre; pores are laid over it
LIP_TINT = np.array([0.0, 0.20, 0.20], dtype=np.float32)
"""What the default skin's vertex colours take away on lips; the paint is the lighter there."""

# How colours of the default skin's zones stand to its base: for fair skin, and for dark skin.
_ZONES = {
    "red": ((0.985, 0.720, 0.715), (1.01, 0.80, 0.80)),
    "pale": ((1.06, 1.12, 1.13), (1.10, 1.10, 1.08)),
    "sallow": ((0.985, 1.005, 0.95), (0.97, 0.97, 0.95)),
    "lid": ((0.82, 0.715, 0.745), (0.78, 0.74, 0.76)),
    "brown": ((0.80, 0.66, 0.55), (0.78, 0.74, 0.70)),
}
_LIPS = ((0.745, 0.450, 0.415), (0.400, 0.225, 0.205))
_INSIDE, _DEEP = np.array([0.64, 0.28, 0.27]), np.array([0.27, 0.075, 0.07])
# How much of each fold stays in the face of somebody of 85.
_STAYING = {"forehead": 0.55, "crows": 0.7, "below-eye": 0.7, "smile": 0.45, "sneer": 0.25, "between": 0.35}
_SHADE = np.array([0.52, 0.33, 0.30])

Floats = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class _Sheet:
    """What is known at every texel that the default skin covers (k of them), whoever the person is."""

    covered: NDArray[np.bool_]  # (size, size)
    nearest: tuple[NDArray[np.int32], NDArray[np.int32]]  # for texels that the skin does not cover
    place: Floats  # (k, 3) mm on the default head
    lips: Floats
    ears: Floats
    inside: Floats
    open_sky: Floats


@cache
def _sheet(size: int) -> _Sheet:
    space = head_space()
    uv = space.skin.uv.astype(np.float64)
    grid = draw_triangles(uv * size, np.ones(len(uv)), space.triangles, size, size)
    covered = grid.triangle >= 0
    corners = space.triangles[grid.triangle[covered]]
    shares = grid.weights[covered]
    fields = np.column_stack([space.rest, space.lips, space.ears, space.inside_mouth, open_sky()]).astype(np.float32)
    texels = np.zeros((len(corners), fields.shape[1]), dtype=np.float32)
    for k in range(3):
        texels += shares[:, k, None] * fields[corners[:, k]]
    _, (rows, columns) = distance_transform_edt(~covered, return_indices=True)
    return _Sheet(covered, (rows, columns), np.ascontiguousarray(texels[:, :3]), *texels[:, 3:].T)


def skin_tone(tone: float) -> NDArray[np.float64]:
    """Colour of skin, sRGB, by tone 0 fair .. 1 dark."""
    table = np.array(looks()["skin"]["tones"])
    return np.array([np.interp(tone, table[:, 0], table[:, k]) for k in (1, 2, 3)])


class _Paint:
    """Colour under way, and the brushes."""

    def __init__(self, person: Person) -> None:
        self.sheet, self.person = _sheet(_PAINTED), person
        self.base = skin_tone(person.tone).astype(np.float32)
        self.colour = np.tile(self.base, (len(self.sheet.place), 1))
        self.sites = {name: head_space().rest[vertex] for name, (_, vertex) in head_space().face.sites.items()}

    def zone(self, name: str) -> NDArray[np.float64]:
        """A zone's colour on this skin."""
        fair, dark = (np.array(ratio) for ratio in _ZONES[name])
        return np.asarray(np.clip(self.base * (fair + (dark - fair) * self.person.tone), 0, 1))

    def mix(self, share: NDArray[np.floating], colour: NDArray[np.floating]) -> None:
        """Lay a colour over, by share 0..1."""
        there = np.flatnonzero(share > 0.002)
        part = np.minimum(share[there], 1).astype(np.float32)[:, None]
        self.colour[there] += (np.asarray(colour, np.float32) - self.colour[there]) * part

    def darken(self, share: NDArray[np.floating], tint: NDArray[np.floating]) -> None:
        """Multiply by ``1 - share * tint``."""
        there = np.flatnonzero(np.abs(share) > 0.002)
        self.colour[there] *= 1 - share[there].astype(np.float32)[:, None] * np.asarray(tint, np.float32)

    def spot(self, x: float, y: float, z: float, across: tuple[float, float, float]) -> Floats:
        """A soft spot 0..1 on both sides of the face, about (±x, y, z), this wide (mm) along each axis."""
        place = self.sheet.place
        away = (np.abs(np.abs(place[:, 0]) - x) / across[0]) ** 2
        away += ((place[:, 1] - y) / across[1]) ** 2 + ((place[:, 2] - z) / across[2]) ** 2
        return np.asarray(np.exp(-away), dtype=np.float32)


def paint_skin(person: Person) -> NDArray[np.uint8]:
    """The picture, shape (SIZE, SIZE, 3).

    Examples
    --------
    >>> from mien.face.cast.made_person import person_named
    >>> paint_skin(person_named("amara")).shape
    (2048, 2048, 3)
    """
    paint = _Paint(person)
    _zones(paint)
    _mottle(paint)
    _age(paint)
    _growth(paint)
    _lips(paint)
    _shadows(paint)
    paint.colour /= 1 - paint.sheet.lips[:, None] * LIP_TINT
    picture = np.zeros((_PAINTED, _PAINTED, 3), dtype=np.float32)
    picture[paint.sheet.covered] = np.clip(paint.colour, 0, 1)
    return _with_pores(picture[paint.sheet.nearest], person)


def _with_pores(picture: Floats, person: Person) -> NDArray[np.uint8]:
    """The picture twice as large, with what is finer than its texels."""
    sheet = _sheet(SIZE)
    fine = layered_noise(sheet.place, 1.3, person.seed + 3, layers=2)
    pores = np.maximum(value_noise(sheet.place, 0.5, person.seed + 4) - 0.25, 0)
    x, y, z = sheet.place.T
    where = np.exp(-((x / 30) ** 2) - ((y + 26) / 24) ** 2 - ((z - 36) / 36) ** 2)
    where += 0.5 * np.exp(-((x / 40) ** 2) - ((y - 42) / 24) ** 2 - ((z - 30) / 40) ** 2)
    depth = (0.09 + 0.10 * np.minimum(where, 1)) * (1 + 0.25 * person.ageing) * (1 - 0.7 * sheet.lips)
    tone = np.ones((SIZE, SIZE), dtype=np.float32)
    tone[sheet.covered] = 1 + 0.03 * fine - depth * pores
    large = np.stack([zoom(picture[..., c], 2, order=1, grid_mode=True, mode="nearest") for c in range(3)], axis=2)
    return np.rint(np.clip(large * tone[..., None], 0, 1) * 255).astype(np.uint8)


def _zones(paint: _Paint) -> None:
    """Where the blood is near: cheeks, nose, ears, chin; lighter forehead and nose bridge; darker lids."""
    person, spot, sites = paint.person, paint.spot, paint.sites
    nose, chin, cheek = sites["nose_tip"], sites["chin"], sites["cheek_left"]
    eye = (sites["eye_inner_left"] + sites["eye_outer_left"]) / 2
    red, pale, lid = paint.zone("red"), paint.zone("pale"), paint.zone("lid")
    flush = 1.0 + 0.35 * person.ageing - 0.3 * person.tone
    uneven = 1 + 0.5 * layered_noise(paint.sheet.place, 13.0, person.seed + 5, layers=2)
    paint.mix(0.24 * flush * uneven * spot(cheek[0] - 2, cheek[1] + 6, cheek[2] + 6, (21, 17, 40)), red)
    paint.mix(0.34 * flush * uneven * spot(0, nose[1], nose[2], (15, 10, 13)), red)
    paint.mix(0.34 * flush * spot(13, nose[1] - 6, nose[2] - 16, (6, 6, 9)), red)
    paint.mix(0.24 * flush * uneven * spot(0, chin[1], chin[2], (18, 12, 20)), red)
    paint.mix(0.55 * paint.sheet.ears, red)
    paint.mix(0.28 * spot(0, 48, 25, (45, 26, 40)), pale)
    paint.mix(0.26 * spot(0, -10, 35, (6, 22, 22)), pale)
    paint.mix(0.20 * spot(eye[0] + 14, eye[1] - 16, eye[2] + 4, (14, 8, 20)), pale)
    paint.mix(0.35 * smoothstep(-100, -135, paint.sheet.place[:, 1]), paint.zone("sallow"))
    tired = 1 + 0.5 * person.ageing
    paint.mix(0.42 * spot(eye[0], eye[1] + 6, eye[2] + 5, (17, 8, 16)), lid)
    paint.mix(0.27 * tired * spot(eye[0] - 5, eye[1] - 9, eye[2] + 4, (12, 5.5, 16)), lid)


def _mottle(paint: _Paint) -> None:
    """Uneven colour, freckles and moles."""
    place, person, seed = paint.sheet.place, paint.person, paint.person.seed
    broad = layered_noise(place, 22.0, seed + 1)
    paint.mix((0.15 + 0.1 * person.ageing) * np.maximum(broad, 0), paint.zone("red"))
    paint.mix(0.14 * np.maximum(-broad, 0), paint.zone("pale"))
    patchy = layered_noise(place, 5.5, seed + 2)
    paint.mix((0.10 + 0.08 * person.ageing) * np.maximum(patchy, 0), paint.zone("brown"))
    brown = paint.zone("brown")
    clusters = smoothstep(-0.3, 0.6, value_noise(place, 9, seed + 31))
    seeds = value_noise(place, 2.0, seed + 30)
    centre = (
        paint.spot(24, -20, 25, (26, 16, 30))
        + paint.spot(0, -16, 36, (10, 14, 14))
        + 0.5 * paint.spot(0, 40, 25, (48, 24, 40))
    )
    amount = 0.12 + 0.88 * person.freckles
    paint.mix(0.62 * amount * smoothstep(0.66 - 0.16 * amount, 0.82, seeds) * clusters * np.minimum(centre, 1), brown)
    chance = np.random.default_rng([seed, 7])
    face = np.flatnonzero(
        (place[:, 2] > 5) & (paint.sheet.lips < 0.05) & (np.abs(place[:, 0]) < 60) & (place[:, 1] > -130)
    )
    for _ in range(int(chance.integers(1, 5))):
        middle = place[face[chance.integers(len(face))]]
        away = np.linalg.norm(place - middle, axis=1)
        paint.mix(0.75 * smoothstep(1.0, 0.45, away / chance.uniform(0.7, 1.3)), brown * 0.62)


def _age(paint: _Paint) -> None:
    """Folds that stay, fine lines about the eyes and mouth, and spots."""
    person, place = paint.person, paint.sheet.place
    if person.ageing <= 0:
        return
    tint = np.array([0.20, 0.30, 0.33]) * (1 - 0.25 * person.tone)
    shade = np.zeros((_PAINTED, _PAINTED), dtype=np.float32)
    for fold in drawn_folds()[1]:
        strength = next((share for start, share in _STAYING.items() if fold.name.startswith(start)), 0.15)
        shade += strength * fold.shade  # drawn at this size
    paint.darken(person.ageing * shade[paint.sheet.covered], tint)
    lines = np.maximum(value_noise(place * np.array([0.25, 1.0, 0.25]), 1.5, person.seed + 61) - 0.15, 0)
    upright = np.maximum(value_noise(place * np.array([1.0, 0.22, 0.3]), 1.4, person.seed + 62) - 0.2, 0)
    where = (
        paint.spot(0, 45, 30, (42, 18, 40)) + paint.spot(46, -4, 5, (14, 14, 22)) + paint.spot(30, -14, 16, (16, 7, 20))
    )
    paint.darken(0.18 * person.ageing * lines * np.minimum(where, 1), np.ones(3))
    about = paint.spot(0, -52, 30, (24, 7, 20)) + 0.6 * paint.spot(0, -76, 28, (22, 8, 20))
    paint.darken(0.11 * person.ageing * upright * np.minimum(about, 1), np.ones(3))
    spots = smoothstep(0.62, 0.80, value_noise(place, 6.0, person.seed + 63))
    high = paint.spot(45, 10, 0, (25, 45, 40)) + paint.spot(0, 60, 10, (50, 25, 40))
    paint.mix(0.35 * person.ageing * spots * np.minimum(high, 1), paint.zone("brown"))


def _growth(paint: _Paint) -> None:
    """The shade that hair, brows and a shaved or short beard give the skin between them."""
    place, person = paint.sheet.place, paint.person
    dark = np.asarray(person.hair_colour[0])
    hair_shade = dark + 0.55 * person.grey * (np.array([0.55, 0.54, 0.53]) - dark)
    ragged = 0.10 * layered_noise(place, 3.0, person.seed + 40) + 0.06 * value_noise(place, 0.7, person.seed + 41)
    edge = 2.0 * layered_noise(place, 7.0, person.seed + 44) + 12 * ragged
    cut = looks()["cuts"][person.hair]
    thin = float(cut.get("soft", 9.0))
    growth = smoothstep(-4.0, thin, hair_depth(place, cut) + edge) * (1 - smoothstep(0.05, 0.4, paint.sheet.ears))
    speck = 0.5 + 0.5 * smoothstep(-0.5, 0.5, value_noise(place, 0.5, person.seed + 42))
    cover = float(cut.get("scalp", 0.9))
    paint.mix(cover * growth * (speck if cover < 0.7 else 1), hair_shade)
    brows = brow_growth(place)
    brow = dark * 0.9 + 0.7 * person.grey * (np.array([0.5, 0.48, 0.46]) - dark * 0.9)
    paint.mix(0.34 * person.brows * smoothstep(0.1, 0.9, brows + ragged * (brows > 0.05)), brow)
    if person.beard:
        style = looks()["beards"][person.beard]
        beard = beard_growth(place, style) * (1 - smoothstep(0.1, 0.5, paint.sheet.lips))
        dots = 0.45 + 0.55 * smoothstep(-0.2, 0.6, value_noise(place, 0.45, person.seed + 43))
        paint.mix(float(style["shade"]) * smoothstep(0.05, 0.75, beard + ragged * (beard > 0.02)) * dots, hair_shade)
    elif person.sex < 0.5 and person.age > 18:  # freshly shaved
        beard = beard_growth(place, looks()["beards"]["full"]) * (1 - smoothstep(0.1, 0.5, paint.sheet.lips))
        cool = paint.base * np.array([0.80, 0.84, 0.87])
        paint.mix(0.34 * (1 - 0.6 * person.tone) * smoothstep(0.05, 0.9, beard + ragged * (beard > 0.02)), cool)


def _lips(paint: _Paint) -> None:
    """Lips with a soft border and fine upright creases, the mouth's inside fading into the dark."""
    place, person, sheet, sites = paint.sheet.place, paint.person, paint.sheet, paint.sites
    lips = smoothstep(0.18, 0.80, sheet.lips + 0.05 * layered_noise(place, 2.0, person.seed + 50, 2))
    creases = value_noise(place * np.array([1.0, 0.12, 0.3]), 0.8, person.seed + 51)
    fair, dark = (np.array(colour) for colour in _LIPS)
    tone = fair + (dark - fair) * smoothstep(0.1, 1.0, np.array(person.tone))
    pale = 0.78 - 0.14 * person.ageing - 0.10 * (1 - person.sex)
    paint.mix(pale * lips, tone)
    paint.darken(lips * (0.07 + 0.05 * person.ageing) * np.maximum(creases, 0), np.ones(3))
    border = np.exp(-(((sheet.lips - 0.45) / 0.28) ** 2))
    edge = tone * np.array([0.76, 0.66, 0.68])
    paint.mix(0.15 * border, edge)
    corner = sites["lip_corner_left"]
    paint.mix(0.45 * paint.spot(corner[0] + 0.5, corner[1] - 1.5, corner[2], (4.0, 3.5, 6.0)), edge)
    inside = smoothstep(0.0, 0.7, sheet.inside)
    paint.mix(inside, _INSIDE)
    depth = smoothstep(5.0, 42.0, sites["lip_lower_inner"][2] - place[:, 2])
    paint.mix(inside * (0.1 + 0.9 * depth), _DEEP)


def _shadows(paint: _Paint) -> None:
    """Part of the shadow in folds, nostrils and behind the ears is painted; the renderer does the rest."""
    sheet = paint.sheet
    shut = np.clip(1 - sheet.open_sky, 0, 1) * (1 - smoothstep(0.2, 0.8, sheet.inside))
    shut = shut * (1 - 0.75 * smoothstep(0.3, 0.9, sheet.lips))
    paint.darken(0.44 * smoothstep(0.2, 1.0, shut), 1 - _SHADE)
