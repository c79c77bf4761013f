"""The skin's picture: painted as a function of the place on the head, then laid out by the texture coordinates.

Everything is hand-made and procedural; only the masks (lips, lids, ears) come from MakeHuman. Colours are sRGB 0..1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from head import Head
from makehuman import Floats
from noise import layered_noise, value_noise
from raster import openness, rasterise
from scipy.ndimage import distance_transform_edt
from sculpt import smoothstep, vertex_normals

_BASE = np.array([0.815, 0.620, 0.520])
_RED = np.array([0.80, 0.44, 0.37])
_LIGHT = np.array([0.875, 0.700, 0.590])
_SALLOW = np.array([0.80, 0.625, 0.49])
_LID = np.array([0.66, 0.44, 0.385])
_LIP = np.array([0.725, 0.445, 0.405])
_LIP_EDGE = np.array([0.56, 0.285, 0.275])
_INSIDE = np.array([0.80, 0.40, 0.38])
_DEEP = np.array([0.50, 0.17, 0.16])
_SHADE = np.array([0.42, 0.20, 0.16])  # what light turns into in the folds
_STUBBLE = np.array([0.225, 0.155, 0.118])


@dataclass
class Canvas:
    """What is known at every texel that the skin covers (k of them)."""

    place: Floats  # (k, 3) mm
    lips: Floats
    lids: Floats
    ears: Floats
    inside: Floats
    open_sky: Floats
    colour: Floats  # (k, 3)

    def mix(self, share: Floats, colour: Floats) -> None:
        """Lay a colour over, by share 0..1."""
        self.colour += (colour - self.colour) * np.clip(share, 0, 1)[:, None]

    def spot(self, x: float, y: float, z: float, across: tuple[float, float, float]) -> Floats:
        """A soft spot 0..1 on both sides of the face, about (±x, y, z), this wide (mm) along each axis."""
        away = (np.abs(np.abs(self.place[:, 0]) - x) / across[0]) ** 2
        away += ((self.place[:, 1] - y) / across[1]) ** 2 + ((self.place[:, 2] - z) / across[2]) ** 2
        return np.asarray(np.exp(-away))


def paint_skin(
    head: Head, sites: dict[str, Floats], hair: Floats, brows: Floats, tint: Floats, size: int, seed: int
) -> Floats:
    """The picture, shape (size, size, 3).

    Parameters
    ----------
    sites : dict of str to ndarray
        Places of the named sites, mm.
    hair, brows : ndarray, shape (n,)
        How much hair grows at each vertex of the skin, 0..1.
    tint : ndarray, shape (3,)
        What the lips' vertex colours take away (they multiply the paint): put back here.
    """
    skin = head.skin
    normals = vertex_normals(skin.vertices, skin.triangles)
    sky = openness(skin.vertices, normals, skin.triangles)
    masks = np.stack([head.masks[k] for k in ("lips", "eyelids", "ears", "inside-mouth")] + [sky, hair, brows], axis=1)
    assert skin.uv is not None
    fields = np.hstack([skin.vertices, masks])
    _, index, shares = rasterise(skin.uv * size, np.zeros(len(skin.vertices)), skin.triangles, size, size)
    covered = index >= 0
    corners = skin.triangles[index[covered]]
    texels = np.einsum("kc,kcf->kf", shares[covered], fields[corners])
    lips, lids, ears, inside, open_sky = texels[:, 3:8].T
    canvas = Canvas(texels[:, :3], lips, lids, ears, inside, open_sky, np.tile(_BASE, (len(texels), 1)))
    _zones(canvas, sites)
    _mottle(canvas, seed)
    _hair(canvas, texels[:, 8], texels[:, 9], seed)
    _lips(canvas, sites, seed)
    _shadows(canvas)
    canvas.colour /= 1 - canvas.lips[:, None] * tint
    picture = np.zeros((size, size, 3))
    picture[covered] = np.clip(canvas.colour, 0, 1)
    nearest = distance_transform_edt(~covered, return_distances=False, return_indices=True)
    return np.asarray(picture[tuple(nearest)])


def _zones(canvas: Canvas, sites: dict[str, Floats]) -> None:
    """Where the blood is near: cheeks, nose, ears, chin; lighter forehead and nose bridge; darker lids."""
    nose, chin, cheek = sites["nose_tip"], sites["chin"], sites["cheek_left"]
    eye = (sites["eye_inner_left"] + sites["eye_outer_left"]) / 2
    canvas.mix(0.33 * canvas.spot(cheek[0] - 2, cheek[1] + 6, cheek[2] + 6, (21, 17, 40)), _RED)
    canvas.mix(0.38 * canvas.spot(0, nose[1], nose[2], (15, 10, 13)), _RED)
    canvas.mix(0.30 * canvas.spot(13, nose[1] - 6, nose[2] - 16, (6, 6, 9)), _RED)
    canvas.mix(0.22 * canvas.spot(0, chin[1], chin[2], (18, 12, 20)), _RED)
    canvas.mix(0.50 * canvas.ears, _RED)
    canvas.mix(0.30 * canvas.spot(0, 48, 25, (45, 26, 40)), _LIGHT)
    canvas.mix(0.28 * canvas.spot(0, -10, 35, (6, 22, 22)), _LIGHT)
    canvas.mix(0.25 * canvas.spot(eye[0] + 14, eye[1] - 16, eye[2] + 4, (14, 8, 20)), _LIGHT)
    canvas.mix(0.35 * smoothstep(-100, -135, canvas.place[:, 1]), _SALLOW)
    canvas.mix(0.42 * canvas.spot(eye[0], eye[1] + 6, eye[2] + 5, (17, 8, 16)), _LID)
    canvas.mix(0.30 * canvas.spot(eye[0] - 5, eye[1] - 8, eye[2] + 4, (12, 5.5, 16)), _LID)
    canvas.mix(0.55 * np.clip(canvas.lids * 1.4, 0, 1) * canvas.spot(eye[0], eye[1], eye[2] + 3, (16, 6, 12)), _LID)


def _mottle(canvas: Canvas, seed: int) -> None:
    """Uneven colour, pores and a few faint freckles."""
    place = canvas.place
    broad = layered_noise(place, 20.0, seed, layers=3)
    canvas.mix(0.13 * np.maximum(broad, 0), _RED)
    canvas.mix(0.14 * np.maximum(-broad, 0), _LIGHT)
    fine = layered_noise(place, 2.4, seed + 10, layers=3)
    canvas.colour *= 1 + 0.022 * fine[:, None]
    pores = np.maximum(value_noise(place, 0.75, seed + 20) - 0.35, 0)
    canvas.colour *= 1 - 0.075 * pores[:, None]
    freckles = smoothstep(0.62, 0.85, value_noise(place, 2.1, seed + 30)) * smoothstep(
        -0.2, 0.5, value_noise(place, 9, seed + 31)
    )
    centre = canvas.spot(22, -24, 25, (24, 14, 25)) + canvas.spot(0, -22, 36, (8, 9, 12))
    canvas.mix(0.30 * freckles * np.clip(centre, 0, 1), np.array([0.60, 0.38, 0.27]))


def _hair(canvas: Canvas, hair: Floats, brows: Floats, seed: int) -> None:
    """The shade that short hair and brows give the skin between them."""
    ragged = 0.16 * layered_noise(canvas.place, 3.0, seed + 40)
    strands = value_noise(
        np.stack([canvas.place[:, 0] + canvas.place[:, 2], canvas.place[:, 1] * 0.15], axis=1), 0.7, seed + 41
    )
    canvas.mix(0.86 * smoothstep(0.16, 0.66, hair + (ragged + 0.10 * strands) * (hair > 0.01)), _STUBBLE)
    canvas.mix(0.50 * smoothstep(0.1, 0.9, brows + ragged * (brows > 0.05)), _STUBBLE)


def _lips(canvas: Canvas, sites: dict[str, Floats], seed: int) -> None:
    """Lips with a soft border and fine upright creases, the mouth's inside fading into the dark."""
    lips = smoothstep(0.18, 0.80, canvas.lips + 0.05 * layered_noise(canvas.place, 2.0, seed + 50))
    creases = value_noise(np.stack([canvas.place[:, 0], canvas.place[:, 1] * 0.12], axis=1), 0.9, seed + 51)
    tone = _LIP * (1 + 0.03 * creases[:, None])
    lower = smoothstep(-1, -5, canvas.place[:, 1] - sites["lip_lower_inner"][1])
    tone = tone * (1.02 - 0.03 * lower[:, None])
    canvas.mix(0.80 * lips, tone)
    border = np.exp(-(((canvas.lips - 0.45) / 0.28) ** 2))
    canvas.mix(0.16 * border, _LIP_EDGE)
    corner = sites["lip_corner_left"]
    canvas.mix(0.45 * canvas.spot(corner[0] + 0.5, corner[1] - 1.5, corner[2], (4.0, 3.5, 6.0)), _LIP_EDGE)
    inside = smoothstep(0.0, 0.7, canvas.inside)
    canvas.mix(inside, _INSIDE)
    depth = smoothstep(8.0, 70.0, sites["lip_lower_inner"][2] - canvas.place[:, 2])
    canvas.mix(inside * (0.1 + 0.9 * depth), _DEEP)


def _shadows(canvas: Canvas) -> None:
    """Part of the shadow in folds, nostrils and behind the ears is painted; the renderer does the rest."""
    shut = np.clip(1 - canvas.open_sky, 0, 1) * (1 - smoothstep(0.2, 0.8, canvas.inside))
    outer = 1 - 0.75 * smoothstep(0.3, 0.9, canvas.lips)
    shut = shut * outer
    canvas.colour *= 1 - (1 - _SHADE / _BASE) * (0.40 * smoothstep(0.2, 1.0, shut))[:, None]
