"""The lights of the studio, read from a hand-made table (``assets/render/portrait.toml``)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset_table, assets_in
from mien.core.errors import unknown_name
from mien.face.render.colour import linear_from_srgb

__all__ = ["Lighting", "known_lightings"]

Floats = NDArray[np.float32]


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
        """A lighting that comes with mien, from the table of its name in ``assets/render``; all hand-made by eye.

        Raises
        ------
        InputError
            If there is none of this name.

        Examples
        --------
        >>> Lighting.named("soft").exposure
        1.0
        """
        if name not in known_lightings():
            raise unknown_name("lighting", name, known_lightings())
        return cls._from_table(asset_table(f"render/{name}.toml"))

    @classmethod
    def _from_table(cls, table: dict[str, Any]) -> Lighting:
        dome = table["dome"]
        sky = np.array([dome["zenith"], dome["horizon"], dome["ground"]], dtype=np.float32)
        around = _spread(dome["lights"])
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
            exposure=float(table["exposure"]),
        )


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
    """Names of the lightings that come with mien, the usual one first.

    Examples
    --------
    >>> known_lightings()
    ('portrait', 'dramatic', 'even', 'soft')
    """
    return tuple(sorted(assets_in("render"), key=lambda name: name != "portrait"))
