"""`Face`: a head made of parts, moved by channels.

Units and axes: millimetres; x to the speaker's left, y up, z forward out of the face; the origin lies midway between
the eyeballs' centres. Left and right are the speaker's own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mien.face.parameter_tree import ParameterTree

__all__ = ["Eye", "Face", "Material", "Part", "Target"]

Floats = NDArray[np.float32]
Indices = NDArray[np.int32]


@dataclass(frozen=True)
class Material:
    """How a surface takes light.

    Attributes
    ----------
    name : str
    colour : tuple of 3 float
        sRGB 0..1; multiplies the texture.
    texture : ndarray of uint8, shape (height, width, 3 or 4), or None
        sRGB; (0, 0) of the texture coordinates is its upper left corner, as in glTF. A fourth number is opacity.
    roughness : float
        0 mirror-like .. 1 matt.
    specular : float
        Strength of the highlight, 0..1.
    scatter : float
        How much light bleeds through, as in skin: 0 none .. 1 (softens the edge between light and shade, reddens it).
    folds : float
        How deep skin folds (`mien.face.folds`): 1 as on the default face, more on older skin.
    opacity : float
        Of the whole surface, 0..1; multiplies the texture's.
    """

    name: str
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0)
    texture: NDArray[np.uint8] | None = None
    roughness: float = 0.6
    specular: float = 0.3
    scatter: float = 0.0
    folds: float = 1.0
    opacity: float = 1.0


@dataclass(frozen=True)
class Target:
    """A morph target, sparse: these vertices move by these millimetres at weight 1."""

    vertices: Indices  # (k,)
    offsets: Floats  # (k, 3)


@dataclass(frozen=True)
class Part:
    """One mesh of the face: skin, one eye, a row of teeth with its gum, tongue, lashes, brows.

    Attributes
    ----------
    name : str
    vertices : ndarray of float32, shape (n, 3)
        At rest, millimetres.
    triangles : ndarray of int32, shape (t, 3)
        Counter-clockwise seen from outside.
    uv : ndarray of float32, shape (n, 2)
    colours : ndarray of float32, shape (n, 3)
        sRGB 0..1 per vertex, multiplies the material's (all ones where unused).
    material : Material
    targets : mapping of str to Target
        By channel name; channels that do not move the part are absent.
    head_weight : ndarray of float32, shape (n,)
        1 where the vertex turns with the head, 0 where it stays with the trunk, between on the neck.
    """

    name: str
    vertices: Floats
    triangles: Indices
    uv: Floats
    colours: Floats
    material: Material
    head_weight: Floats
    targets: Mapping[str, Target] = field(default_factory=dict)


@dataclass(frozen=True)
class Eye:
    """How an eyeball turns: about its centre, by degrees at weight 1 of the eyeLook channels of its side."""

    part: str
    side: str  # "Left" or "Right"
    centre: tuple[float, float, float]  # mm
    look_up: float
    look_down: float
    look_in: float
    look_out: float


@dataclass(frozen=True)
class Face:
    """A head that channels can move.

    Attributes
    ----------
    name : str
    parts : tuple of Part
    eyes : tuple of Eye
        Eyeballs turn rigidly; their parts have no targets.
    head_pivot : tuple of 3 float
        The point about which the head turns, mm (top of the neck).
    sites : mapping of str to (part name, vertex index)
        Named places on the mesh, for markers and tests (lips, lids, chin, nose, brows).
    licence : str
    """

    name: str
    parts: tuple[Part, ...]
    eyes: tuple[Eye, ...]
    head_pivot: tuple[float, float, float]
    sites: Mapping[str, tuple[str, int]]
    licence: str
    tree: ParameterTree | None = None

    def part(self, name: str) -> Part:
        """The part of that name."""
        return next(part for part in self.parts if part.name == name)
