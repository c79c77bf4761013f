"""Who the default face is: a table of MakeHuman identity targets and how much of each goes in. All hand-made."""

from __future__ import annotations

import numpy as np
from makehuman import Floats, Ints, MakeHuman

# Sex, age and origin are mixed first, as MakeHuman does; the rest are local touches by eye.
ORIGINS = {"african": 0.30, "asian": 0.25, "caucasian": 0.45}
_SEXES = {"female": 0.62, "male": 0.38}
_TOUCHES: dict[str, float] = {
    "head/head-oval": 0.25,
    "mouth/mouth-scale-horiz-incr": 0.45,
    "eyes/{side}-eye-scale-incr": 0.75,
    "eyes/{side}-eye-height2-incr": 0.15,
    "mouth/mouth-angles-up": 0.40,
    "neck/neck-scale-horiz-decr": 0.15,
}


def neutral(data: MakeHuman) -> Floats:
    """Vertices of the character at rest, shape (n, 3), millimetres, the two halves made equal."""
    shape = data.vertices.copy()
    for sex, share in _SEXES.items():
        shape += share * data.target(f"macrodetails/universal-{sex}-young-averagemuscle-averageweight")
        for origin, part in ORIGINS.items():
            shape += share * part * data.target(f"macrodetails/{origin}-{sex}-young")
    for name, amount in _TOUCHES.items():
        for filled in {name.format(side=side) for side in "lr"}:
            shape += amount * data.target(filled)
    partner = data.mirror()
    return np.asarray((shape + mirrored(shape, partner)) / 2)


def mirrored(field: Floats, partner: Ints) -> Floats:
    """A field of positions or offsets seen in a mirror that stands on the face's middle plane."""
    return np.asarray(field[partner] * np.array([-1.0, 1.0, 1.0]))


def mirror_shapes(shapes: dict[str, Floats], partner: Ints) -> dict[str, Floats]:
    """Make each Left/Right pair of shapes mirror images, and every other shape even on both sides."""
    even = {}
    for name, offsets in shapes.items():
        if (name.startswith(("jaw", "mouth")) and name[5:] in ("Left", "Right")) or name in ("jawLeft", "jawRight"):
            other = name.replace("Left", "Right") if "Left" in name else name.replace("Right", "Left")
        elif name.endswith("Left"):
            other = name[:-4] + "Right"
        elif name.endswith("Right"):
            other = name[:-5] + "Left"
        else:
            other = name
        even[name] = (offsets + mirrored(shapes[other], partner)) / 2
    return even
