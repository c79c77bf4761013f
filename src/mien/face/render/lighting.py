"""The lights of the studio, read from a hand-made table (``assets/render/lights/portrait.toml``)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.face.render.colour import linear_from_srgb
from mien.face.render.tables import fields_of, known_tables, numbers, table_of

__all__ = ["Lighting", "known_lightings"]

Floats = NDArray[np.float32]
_LAMP = {"direction": 3, "colour": 3}
_SECTIONS: dict[str, dict[str, int]] = {
    "exposure": {"": 1},
    "background": {"top": 3, "bottom": 3},
    "key": _LAMP,
    "fill": _LAMP,
    "rim": _LAMP,
    "dome": {"lights": 1, "zenith": 3, "horizon": 3, "ground": 3},
    "skin": {"reach_mm": 3, "wrap": 3, "bounce": 3},
}
"""Sections of a lighting's table, and how many numbers each field has."""


@dataclass(frozen=True)
class Lighting:
    """Distant lights and a background.

    Attributes
    ----------
    directions : ndarray of float32, shape (lights, 3)
        Unit vectors from the face to each light: key, fill, rim, then the dome.
    colours : ndarray of float32, shape (lights, 3)
        Linear light.
    sky : ndarray of float32, shape (3, 3)
        Rows zenith, horizon, ground: what a shiny surface mirrors of the dome.
    background : ndarray of float32, shape (2, 3)
        Linear colours of the upper and lower edge of the picture.
    reach_mm, wrap : ndarray of float32, shape (3,)
        How far red, green and blue travel below skin, and how far they reach round the edge of the lit side.
    bounce : ndarray of float32, shape (3,)
        Light that flesh sends back into a place that sees nothing but flesh.
    exposure : float
    """

    directions: Floats
    colours: Floats
    sky: Floats
    background: Floats
    reach_mm: Floats
    wrap: Floats
    bounce: Floats
    exposure: float

    @classmethod
    def portrait(cls) -> Lighting:
        """The studio that comes with mien.

        Examples
        --------
        >>> Lighting.portrait().directions.shape
        (11, 3)
        """
        return cls.named("portrait")

    @classmethod
    def named(cls, name: str) -> Lighting:
        """A lighting of ``assets/render/lights`` (all hand-made by eye), or of a ``.toml`` file of the user's.

        Raises
        ------
        InputError
            If there is no such lighting, or its table cannot be used.

        Examples
        --------
        >>> Lighting.named("soft").exposure
        1.0
        """
        table = _checked(table_of("lights", name), name)
        dome = table["dome"]
        sky = np.array([dome["zenith"], dome["horizon"], dome["ground"]], dtype=np.float32)
        around = _spread(int(dome["lights"][0]))
        named = [table[name] for name in ("key", "fill", "rim")]
        directions = np.concatenate([[light["direction"] for light in named], around])
        # A matt surface under a dome of radiance 1 shows 1: n lights over the sphere of 4 pi, over pi.
        colours = np.concatenate([[light["colour"] for light in named], _sky_colour(around, sky) * 4 / len(around)])
        return cls(
            directions=(directions / np.linalg.norm(directions, axis=1, keepdims=True)).astype(np.float32),
            colours=colours.astype(np.float32),
            sky=sky,
            background=linear_from_srgb(np.array([table["background"]["top"], table["background"]["bottom"]])),
            reach_mm=np.array(table["skin"]["reach_mm"], dtype=np.float32),
            wrap=np.array(table["skin"]["wrap"], dtype=np.float32),
            bounce=np.array(table["skin"]["bounce"], dtype=np.float32),
            exposure=table["exposure"][""][0],
        )

    def before(self, colour: tuple[int, int, int]) -> Lighting:
        """The same light before one colour, sRGB bytes."""
        linear = linear_from_srgb(np.array(colour) / 255)
        return replace(self, background=np.tile(linear, (2, 1)).astype(np.float32))


def _checked(table: dict[str, Any], where: object) -> dict[str, dict[str, list[float]]]:
    """Every number of a lighting's table as a list, under its section and field."""
    found: dict[str, dict[str, list[float]]] = {"exposure": {}}
    for section, fields in fields_of(table, tuple(_SECTIONS), where).items():
        counts = _SECTIONS[section]
        given = {"": fields} if section == "exposure" else fields_of(fields, tuple(counts), f"{where}: [{section}]")
        found[section] = {
            name: numbers(given[name], n, f"{section} {name}".strip(), where) for name, n in counts.items()
        }
    if not 1 <= found["dome"]["lights"][0] <= 64:
        raise InputError(f"{where}: a dome has 1 to 64 lights, not {found['dome']['lights'][0]:g}")
    if not all(any(found[name]["direction"]) for name in ("key", "fill", "rim")):
        raise InputError(f"{where}: a direction of three zeros points nowhere")
    return found


def _spread(count: int) -> NDArray[np.float64]:
    """Directions spread evenly over the sphere (a Fibonacci spiral), shape (count, 3)."""
    number = np.arange(count)
    height = 1 - (2 * number + 1) / count
    turn = number * np.pi * (3 - np.sqrt(5))
    radius = np.sqrt(1 - height**2)
    return np.stack([radius * np.sin(turn), height, radius * np.cos(turn)], axis=1)


def _sky_colour(directions: NDArray[np.float64], sky: Floats) -> NDArray[np.float64]:
    up = directions[:, 1:2]
    return np.asarray(np.where(up > 0, sky[1] + up * (sky[0] - sky[1]), sky[1] - up * (sky[2] - sky[1])), np.float64)


def known_lightings() -> tuple[str, ...]:
    """Names of the lightings that come with mien, the usual one first."""
    return known_tables("lights")
