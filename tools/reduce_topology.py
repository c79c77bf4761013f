"""Work out which triangles a compact GLB keeps of the parts that all faces of mien share: ``reduced_meshes.npz``.

Run by hand after the triangles of the default face have changed, in a folder where ``npm i meshoptimizer`` was run
(its simplifier keeps a subset of the vertices, so their targets stay as they are): ``python tools/reduce_topology.py``.
An error weighs alike at rest and in each of the motions that the targets make most of.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from mien.core.assets import assets_folder
from mien.core.channels import ARKIT
from mien.face.cast.made_person import cast_names
from mien.face.library import load_face
from mien.face.model import Part
from mien.formats.reduced_meshes import REDUCED, topology

KEPT = {"skin": 15_000, "teeth_upper": 2_200, "teeth_lower": 2_200, "eye_left": 1_600, "eye_right": 1_600}
"""Triangles."""
CAP = 12_000
"""Triangles of the skin under the hair of a face of the cast, of which each cut has its own."""
MOTIONS = 26


def main() -> None:
    """Write the file."""
    face = load_face()
    rows = {topology(face.part(name)): kept(face.part(name), count) for name, count in KEPT.items()}
    for cap in (part for name in cast_names() for part in load_face(name).parts if part.name == "hair_cap"):
        if topology(cap) not in rows:
            rows[topology(cap)] = kept(cap, CAP)
    np.savez_compressed(assets_folder() / REDUCED, allow_pickle=False, **rows)


def kept(part: Part, count: int) -> np.ndarray:
    """The triangles to keep, shape (about count, 3), by the part's own numbers of vertices."""
    moved = np.zeros((len(ARKIT), len(part.vertices), 3))
    for k, name in enumerate(ARKIT):
        if name in part.targets:
            moved[k, part.targets[name].vertices] = part.targets[name].offsets
    flat = moved.transpose(1, 0, 2).reshape(len(part.vertices), -1)
    extent = np.ptp(part.vertices, axis=0).max()
    size, axes = np.linalg.eigh(flat.T @ flat)
    most = flat @ axes[:, np.argsort(-size)[:MOTIONS]] / extent
    further = np.hstack([most, 0.05 * part.uv])
    with tempfile.TemporaryDirectory() as folder:
        for name, values in (("places", part.vertices), ("further", further)):
            (Path(folder) / name).write_bytes(np.ascontiguousarray(values, np.float32).tobytes())
        (Path(folder) / "triangles").write_bytes(part.triangles.astype(np.uint32).tobytes())
        script = Path(__file__).with_suffix(".mjs")
        subprocess.run(["node", str(script), folder, str(count)], check=True, stdout=sys.stderr)
        raw = (Path(folder) / "kept").read_bytes()
    return np.frombuffer(raw, np.uint32).reshape(-1, 3).astype(np.uint16)


if __name__ == "__main__":
    main()
