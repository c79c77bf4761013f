"""The tongue: MakeHuman's, made finer, with four hand-made shapes that speech needs."""

from __future__ import annotations

import numpy as np
from head import Head
from makehuman import Floats, MakeHuman
from sculpt import Sculpt, smoothstep, vertex_normals
from subdivision import catmull_clark, triangulate


def build_tongue(data: MakeHuman, head: Head) -> Sculpt:
    """Tongue with its ARKit shapes and those of `mien.core.channels.TONGUE`."""
    used, quads = np.unique(np.array(data.groups["helper-tongue"]), return_inverse=True)
    matrix, fine = catmull_clark(len(used), quads.reshape(-1, 4))
    coarse = Sculpt("tongue", head.identity[used], fine, {k: v[used] for k, v in head.units.items()})
    tongue = coarse.through(matrix, triangulate(fine))
    x, y, z = tongue.vertices.T
    front, back = z.max(), z.min()
    along = (z - back) / (front - back)
    # The underside rises less than the back of the tongue, so that the blade is seen between parted teeth.
    upward = vertex_normals(tongue.vertices, tongue.triangles)[:, 1]
    # The tip goes to the back of the upper teeth and curls over them a little; below it the blade stays in sight.
    tip = smoothstep(0.40, 0.95, along) * (0.30 + 0.70 * smoothstep(-0.7, 0.3, upward))
    tongue.shapes["tongueTipUp"] = _raised(tip, 7.0, 9.2)
    tongue.shapes["tongueBackUp"] = _raised(np.exp(-(((along - 0.30) / 0.22) ** 2)), 8.5, -2.0)
    blade = np.exp(-(((along - 0.62) / 0.20) ** 2)) * (0.5 + 0.5 * smoothstep(-0.7, 0.3, upward))
    tongue.shapes["tongueBladeUp"] = _raised(blade, 7.5, 2.0)
    tongue.shapes["tongueCurl"] = _raised(smoothstep(0.55, 1.0, along), 11.0, -9.0)
    middle = np.exp(-((x / 3.0) ** 2)) * smoothstep(np.median(y), y.max(), y)
    # Little light reaches a mouth: the paint is the lighter for it, most so below, where only what the teeth send
    # back arrives.
    pink, dark, below = np.array([0.88, 0.49, 0.47]), np.array([0.50, 0.21, 0.20]), np.array([0.99, 0.62, 0.60])
    tongue.colours = dark + (pink - dark) * smoothstep(0.10, 0.70, along)[:, None]
    under = (smoothstep(0.3, -0.5, upward) * smoothstep(0.45, 0.8, along))[:, None]
    tongue.colours = tongue.colours + (below - tongue.colours) * under
    tongue.colours = tongue.colours * (1 - 0.12 * middle)[:, None]
    return tongue


def _raised(weight: Floats, up: float, forward: float) -> Floats:
    return np.stack([np.zeros_like(weight), up * weight, forward * weight], axis=1)
