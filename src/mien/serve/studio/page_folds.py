"""The folds of a face's skin (`mien.face.folds`) as numbers for a page, which lays them on the texture itself."""

from __future__ import annotations

from base64 import b64encode
from functools import cache
from typing import Any

import numpy as np

from mien.face.folds import TINT, drawn_folds, layout_digest
from mien.face.library import load_face

__all__ = ["folds_of_face"]

_SIZE = 512
_FAINT = 0.02


@cache
def folds_of_face(name: str) -> dict[str, Any]:
    """Which texels each fold darkens, in whole numbers of 1/127, and the channels that make it; {} without folds.

    Parameters
    ----------
    name : str
        One of mien's own faces.
    """
    layout, folds = drawn_folds()
    skins = [part.material for part in load_face(name).parts if layout_digest(part.uv) == layout]
    if not skins or skins[0].texture is None:
        return {}
    told = []
    for fold in folds:
        step = len(fold.shade) // _SIZE
        shade = fold.shade.reshape(_SIZE, step, _SIZE, step).mean(axis=(1, 3)).ravel() * skins[0].folds
        texels = np.flatnonzero(np.abs(shade) > _FAINT)
        steps = np.round(np.clip(shade[texels], -1, 1) * 127).astype(np.int8)
        packed = {"texels": _packed(texels.astype("<u4")), "shade": _packed(steps)}
        told.append({"drivers": dict(fold.drivers), **packed})
    return {"material": skins[0].name, "size": _SIZE, "tint": TINT.tolist(), "folds": told}


def _packed(values: np.ndarray[Any, Any]) -> str:
    return b64encode(values.tobytes()).decode()
