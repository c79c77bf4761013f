"""Folds of the skin: shade on the texture where a muscle gathers it, as strong as the channels that make it.

Hand-made (``tools/bake_face/folds.py``): what the mesh is too coarse to fold is drawn as the dark of a groove and the
light of its banks. The folds lie on the default face's texture coordinates; a face that has others has none.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from hashlib import sha256
from io import BytesIO

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset
from mien.core.compiled import njit
from mien.face.model import Part

__all__ = ["Fold", "Folds", "folds_of", "layout_digest"]

Floats = NDArray[np.float32]
_BLOCK = 64
_FAINT = 0.015
TINT = np.array([0.17, 0.25, 0.27], dtype=np.float32)
"""How much red, green and blue a full fold takes away: what light there is has gone through skin."""


@dataclass(frozen=True, eq=False)
class Fold:
    """One fold.

    Attributes
    ----------
    name : str
    drivers : mapping of str to float
        Channels that make it, and how much of it each makes at weight 1; the sum counts up to 1.
    shade : ndarray of float32, shape (size, size)
        By how much of `TINT` each texel is darker at full; below 0: lighter.
    """

    name: str
    drivers: Mapping[str, float]
    shade: Floats

    def weight(self, channels: Mapping[str, float]) -> float:
        """How full the fold is, 0..1: skin gathers a little before it folds.

        Examples
        --------
        >>> fold = Fold("chin", {"mouthShrugLower": 1.0}, np.zeros((4, 4), np.float32))
        >>> round(fold.weight({"mouthShrugLower": 0.5, "jawOpen": 1.0}), 2)
        0.35
        """
        total = sum(share * channels.get(name, 0.0) for name, share in self.drivers.items())
        return float(min(max(total, 0.0), 1.0) ** 1.5)


class Folds:
    """The folds of one texture: which texels change, and how, in every size of it.

    Parameters
    ----------
    folds : tuple of Fold
    sizes : ndarray, shape (levels, 3)
        First texel, width and height of each level of the texture.

    Attributes
    ----------
    texels : ndarray, shape (texels,)
        Those that folds change, in order.
    starts : ndarray of int32, shape (texels + 1,)
        Which of the entries each has.
    owners, shades : ndarray, shape (entries,)
        Number of the fold, and its shade there.
    """

    def __init__(self, folds: tuple[Fold, ...], sizes: NDArray[np.int32]) -> None:
        self.folds = folds
        texels, owners, shades = [], [], []
        for number, fold in enumerate(folds):
            box = _box(fold.shade)
            for first, wide, tall in sizes.tolist():
                rows, columns, shade = _resized(fold.shade, box, tall, wide)
                texels.append(first + rows * wide + columns)
                owners.append(np.full(len(rows), number))
                shades.append(shade)
        entry = np.concatenate(texels)
        order = np.argsort(entry, kind="stable")
        self.texels, starts = np.unique(entry[order], return_index=True)
        self.starts = np.append(starts, len(entry)).astype(np.int32)
        self.owners, self.shades = np.concatenate(owners)[order].astype(np.int32), np.concatenate(shades)[order]

    def weights(self, channels: Mapping[str, float]) -> Floats:
        """How full each fold is, shape (folds,)."""
        return np.array([fold.weight(channels) for fold in self.folds], dtype=np.float32)

    def lay(self, weights: Floats, smooth: NDArray[np.uint8], texels: NDArray[np.uint8], first: int = 0) -> None:
        """Write what folds can change into all ``texels`` from ``first`` on.

        ``smooth`` is what `self.texels` of them are without folds.
        """
        begin = int(np.searchsorted(self.texels, first))
        _lay(begin, self.texels, self.starts, self.owners, self.shades, weights, TINT, smooth, texels)


@njit(cache=True, nogil=True)
def _lay(begin, places, starts, owners, shades, weights, tint, smooth, texels):  # type: ignore[no-untyped-def]
    for number in range(begin, len(places)):
        dark = np.float32(0.0)
        for entry in range(starts[number], starts[number + 1]):
            dark += weights[owners[entry]] * shades[entry]
        dark = min(max(dark, np.float32(-1.0)), np.float32(1.0))
        for colour in range(3):
            value = smooth[number, colour] * (np.float32(1.0) - dark * tint[colour])
            texels[places[number], colour] = np.uint8(min(max(value, np.float32(0.0)), np.float32(255.0)))


def layout_digest(uv: NDArray[np.float32]) -> str:
    """What tells texture coordinates apart."""
    return sha256(np.round(uv.astype(np.float64), 4).tobytes()).hexdigest()


def folds_of(part: Part, sizes: NDArray[np.int32]) -> Folds | None:
    """The folds of a part that has the default skin's texture coordinates and a texture; None for any other.

    A material whose ``folds`` is 0 has none.

    Parameters
    ----------
    part : Part
    sizes : ndarray, shape (levels, 3)
        First texel, width and height of each level of its texture.
    """
    layout, folds = drawn_folds()
    if part.material.texture is None or not part.material.folds or layout_digest(part.uv) != layout:
        return None
    return Folds(tuple(replace(f, shade=part.material.folds * f.shade) for f in folds), sizes)


@cache
def drawn_folds() -> tuple[str, tuple[Fold, ...]]:
    """Texture coordinates that the folds lie on, as `layout_digest` tells them, and the folds."""
    data = asset("render/folds.npz").read_bytes()
    with np.load(BytesIO(data), allow_pickle=False) as arrays:
        size = int(arrays["size"])
        found = []
        for name in sorted(key.removesuffix(".shade") for key in arrays.files if key.endswith(".shade")):
            shade = np.zeros(size * size, dtype=np.float32)
            shade[arrays[f"{name}.texels"]] = arrays[f"{name}.shade"].astype(np.float32) / 127
            drivers = dict(pair.split("=") for pair in arrays[f"{name}.drivers"].tobytes().decode().split())
            found.append(Fold(name, {c: float(share) for c, share in drivers.items()}, shade.reshape(size, size)))
        return arrays["layout"].tobytes().decode(), tuple(found)


def _box(picture: Floats) -> tuple[slice, slice]:
    """Where a picture is not 0, in whole blocks."""
    sides = np.flatnonzero(picture.any(axis=1)), np.flatnonzero(picture.any(axis=0))
    down, aside = (slice(s.min() // _BLOCK * _BLOCK, (s.max() // _BLOCK + 1) * _BLOCK) for s in sides)
    return down, aside


def _resized(
    picture: Floats, box: tuple[slice, slice], tall: int, wide: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
    """Rows, columns and values of what is not 0 of a square picture in another size; nothing where it is tiny."""
    size = len(picture)
    nothing = np.zeros(0, dtype=np.int64)
    if tall != wide or tall < size // _BLOCK or (max(tall, size) % min(tall, size)):
        return nothing, nothing, np.zeros(0, dtype=np.float32)
    part, top, left = picture[box], box[0].start, box[1].start
    if tall < size:
        step = size // tall
        part = part.reshape(part.shape[0] // step, step, part.shape[1] // step, step).mean(
            axis=(1, 3), dtype=np.float32
        )
        top, left = top // step, left // step
    elif tall > size:
        step = tall // size
        grown = np.kron(part, np.ones((step, step)))
        moved = [np.roll(grown, (down, aside), (0, 1)) for down in (0, 1) for aside in (0, 1)]
        part, top, left = np.mean(moved, axis=0).astype(np.float32), top * step, left * step
    rows, columns = np.nonzero(np.abs(part) > _FAINT)
    return rows + top, columns + left, part[rows, columns].astype(np.float32)
