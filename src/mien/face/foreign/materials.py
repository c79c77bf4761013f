"""Colours and pictures of a foreign face, as far as mien's renderer shows them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.pictures import opened_picture
from mien.face.foreign.gltf_document import GltfDocument
from mien.face.foreign.ktx2 import is_ktx2, ktx2_pixels
from mien.face.model import Material

__all__ = ["Surface", "SurfaceReader", "srgb"]

_LARGEST = 2048  # pixels of a texture's side; larger ones are halved
_SKIN = ("skin", "face", "head", "body", "wolf3d_avatar")
_NOTHING = 0.02  # opacity below which nothing is drawn
_PLAIN_SKIN = (0.80, 0.62, 0.54)  # where a picture of skin cannot be read: hand-made
_PLAIN = (0.62, 0.60, 0.58)


@dataclass(frozen=True)
class Surface:
    """A material as it is drawn.

    Attributes
    ----------
    material : Material
    coordinates : int
        Which TEXCOORD set its picture takes.
    transform : ndarray, shape (2, 3)
        Brings texture coordinates to the picture (KHR_texture_transform).
    hidden : bool
        Whether nothing of it is to be seen.
    """

    material: Material
    coordinates: int = 0
    transform: NDArray[np.float64] | None = None
    hidden: bool = False


def srgb(linear: NDArray[Any]) -> NDArray[np.float64]:
    """SRGB of linear light, both 0..1 (IEC 61966-2-1)."""
    light = np.clip(np.asarray(linear, dtype=np.float64), 0.0, 1.0)
    return np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)


class SurfaceReader:
    """Reads the materials of one document, each once; ``faults`` tells which pictures could not be read."""

    def __init__(self, document: GltfDocument, pictures: bool = True) -> None:
        self.document, self.pictures = document, pictures
        self.faults: list[str] = []
        self._known: dict[int | None, Surface] = {}

    def surface(self, number: object) -> Surface:
        """The material of a primitive; None is glTF's default one."""
        key = number if isinstance(number, int) else None
        if key not in self._known:
            facts = {} if key is None else self.document._entry("materials", key)
            self._known[key] = self._read(facts, key)
        return self._known[key]

    def _read(self, facts: dict[str, Any], number: int | None) -> Surface:
        name = str(facts.get("name") or f"material {number}")
        metal = facts.get("pbrMetallicRoughness") or {}
        old = (facts.get("extensions") or {}).get("KHR_materials_pbrSpecularGlossiness") or {}
        given = metal.get("baseColorTexture") or old.get("diffuseTexture")
        factor = list(metal.get("baseColorFactor") or old.get("diffuseFactor") or [1.0, 1.0, 1.0, 1.0])
        skin = any(word in name.lower() for word in _SKIN) and "hair" not in name.lower()
        colour = srgb(np.array((factor + [1.0] * 4)[:3]))
        picture = self._picture(given, name) if given and self.pictures else None
        if given and picture is None:
            colour = colour * np.array(_PLAIN_SKIN if skin else _PLAIN)
        mode = facts.get("alphaMode", "OPAQUE")
        if picture is not None:
            picture = _with_opacity(picture, mode, float(facts.get("alphaCutoff", 0.5)))
        alpha = float(factor[3]) if len(factor) > 3 and mode != "OPAQUE" else 1.0
        return Surface(
            material=Material(
                name,
                (float(colour[0]), float(colour[1]), float(colour[2])),
                picture,
                roughness=float(np.clip(metal.get("roughnessFactor", 1.0), 0.3, 0.8)),
                scatter=0.4 if skin else 0.0,
                opacity=float(np.clip(alpha, 0.0, 1.0)) if mode == "BLEND" else 1.0,
            ),
            coordinates=_coordinates(given),
            transform=_transform(given),
            hidden=alpha < _NOTHING,
        )

    def _picture(self, given: dict[str, Any], name: str) -> NDArray[np.uint8] | None:
        """The pixels (height, width, 4) of a texture; None with a fault where it cannot be read."""
        try:
            texture = self.document._entry("textures", given.get("index"))
            extensions = texture.get("extensions") or {}
            named = [extensions[name] for name in ("EXT_texture_webp", "KHR_texture_basisu") if name in extensions]
            source = texture.get("source", next((each.get("source") for each in named if isinstance(each, dict)), None))
            if source is None:
                raise InputError(f"its picture is {', '.join(extensions) or 'not there'}")
            image = self.document._entry("images", source)
            if "uri" in image:
                data = self.document.bytes_at(image["uri"], f"picture {source}")
            else:
                data = self.document.view(image.get("bufferView", -1))
            if is_ktx2(data):
                return ktx2_pixels(data, f"picture {source}", _LARGEST)
            with opened_picture(data, f"picture {source}") as opened:
                opened.thumbnail((_LARGEST, _LARGEST))
                return np.array(opened.convert("RGBA"), dtype=np.uint8)
        except InputError as problem:
            self.faults.append(f"material {name!r} is drawn in one colour: {problem}")
            return None


def _with_opacity(picture: NDArray[np.uint8], mode: str, cutoff: float) -> NDArray[np.uint8]:
    """The picture with its opacity where there is one: as it is, or all or nothing where the material is cut out."""
    if mode == "OPAQUE" or picture[:, :, 3].min() == 255:
        return np.ascontiguousarray(picture[:, :, :3])
    picture = _without_fringes(picture)
    if mode == "MASK":
        picture[:, :, 3] = np.where(picture[:, :, 3] >= 255 * cutoff, 255, 0)
    return np.ascontiguousarray(picture)


def _without_fringes(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """See-through pixels in the mean colour of the others: what a program left below zero alpha is often black."""
    share = picture[:, :, 3:].astype(np.float64) / 255.0
    if not share.any():
        return picture
    mean = (picture[:, :, :3] * share).sum(axis=(0, 1)) / share.sum()
    result = picture.copy()
    result[:, :, :3] = np.round(picture[:, :, :3] * share + mean * (1.0 - share)).astype(np.uint8)
    return result


def _coordinates(given: object) -> int:
    if not isinstance(given, dict):
        return 0
    moved = (given.get("extensions") or {}).get("KHR_texture_transform") or {}
    number = moved.get("texCoord", given.get("texCoord", 0))
    return number if isinstance(number, int) and number >= 0 else 0


def _transform(given: object) -> NDArray[np.float64] | None:
    moved = (given.get("extensions") or {}).get("KHR_texture_transform") if isinstance(given, dict) else None
    if not moved:
        return None
    turn, (wide, tall) = float(moved.get("rotation", 0.0)), moved.get("scale", [1.0, 1.0])
    across, down = moved.get("offset", [0.0, 0.0])
    cos, sin = np.cos(turn), np.sin(turn)
    return np.array([[cos * wide, sin * tall, across], [-sin * wide, cos * tall, down]])
