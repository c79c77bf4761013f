"""Regions of a head, for reports and tables: where a vertex of the default skin lies."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from mien.face.head_space import head_space
from mien.fit.surface_fit import SurfaceFit

__all__ = ["head_regions", "region_distances"]


@cache
def head_regions() -> dict[str, NDArray[np.bool_]]:
    """Vertices of the default skin by region; hand-made, by place on the default head. None lies in two."""
    space = head_space()
    x, y, z = space.rest.T
    outer = space.outer() & (space.ears < 0.3)
    loops = np.concatenate([space.lid_loop_left, space.lid_loop_right])
    to_lids = np.linalg.norm(space.rest[:, None] - space.rest[loops][None, ::4], axis=2).min(axis=1)
    to_lips = np.linalg.norm(space.rest[:, None] - space.rest[space.lip_loop][None, ::2], axis=2).min(axis=1)
    nose = (np.abs(x) < 20) & (y < 2) & (y > -50) & (z > 12)
    regions = {
        "mouth": outer & (to_lips < 14),
        "eyes": outer & (to_lids < 11),
        "nose": outer & nose,
        "forehead": outer & (y > 8) & (y < 70) & (z > -30),
        "cheeks and jaw": outer & (z > -62) & (y <= 8) & (y > -108),
        "ears": space.ears >= 0.3,
        "skull": outer & (y > -35),
        "neck": outer & (y <= -35),
    }
    taken = np.zeros(len(x), dtype=np.bool_)
    for name, chosen in regions.items():
        regions[name] = chosen & ~taken
        taken |= chosen
    return regions


def region_distances(fit: SurfaceFit) -> dict[str, tuple[float, float, float]]:
    """Per region the mean and the 95th percentile of the distance to the head, mm, and the share that was matched."""
    found = {}
    for name, chosen in head_regions().items():
        values = fit.distance[chosen]
        there = values[~np.isnan(values)]
        nothing = float("nan")
        mean, high = (float(there.mean()), float(np.percentile(there, 95))) if len(there) else (nothing, nothing)
        found[name] = (mean, high, len(there) / max(len(values), 1))
    return found
