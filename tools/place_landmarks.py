"""Write the landmarks that heads and photographs are fitted by: names, words, and their vertices on the default face.

    python tools/place_landmarks.py src/mien/assets/fitting/landmarks.toml

Vertices are the default face's own sites, or the ones nearest to places chosen by eye (left side and middle, mm).
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from mien.face.head_space import head_space

# name, site or place of the left or middle one, whether it must be given, words
LANDMARKS = (
    ("eye_outer_{side}", "eye_outer_left", True, "outer corner of the eye, where the lids meet"),
    ("eye_inner_{side}", "eye_inner_left", True, "inner corner of the eye, where the lids meet"),
    ("nose_tip", "nose_tip", True, "the foremost point of the nose"),
    ("lip_corner_{side}", "lip_corner_left", True, "corner of the mouth, where the lips meet"),
    ("chin", (0.0, -95.0, 23.0), True, "middle of the chin's front"),
    ("lid_upper_{side}", "lid_upper_left", False, "middle of the upper lid's edge"),
    ("lid_lower_{side}", "lid_lower_left", False, "middle of the lower lid's edge"),
    ("lip_upper_outer", "lip_upper_outer", False, "middle of the upper lip's upper border"),
    ("lip_lower_outer", "lip_lower_outer", False, "middle of the lower lip's lower border"),
    ("lip_upper_inner", "lip_upper_inner", False, "middle of the upper lip's lower edge, where it meets the lower lip"),
    ("lip_lower_inner", "lip_lower_inner", False, "middle of the lower lip's upper edge, where it meets the upper lip"),
    ("nose_bridge", (0.0, 1.0, 24.5), False, "deepest point of the nose's ridge, between the eyes"),
    ("nose_base", (0.0, -46.3, 32.5), False, "where the nose meets the upper lip, in the middle"),
    ("nose_wing_{side}", (18.0, -41.0, 23.0), False, "outermost point of the nostril's wing"),
    ("brow_inner_{side}", "brow_inner_left", False, "inner end of the eyebrow"),
    ("brow_middle_{side}", "brow_middle_left", False, "highest point of the eyebrow"),
    ("brow_outer_{side}", "brow_outer_left", False, "outer end of the eyebrow"),
    ("glabella", (0.0, 18.4, 26.6), False, "foremost point between the eyebrows"),
    ("forehead", (0.0, 59.2, 15.8), False, "middle of the forehead, where the hair begins"),
    ("chin_bottom", (0.0, -105.7, 13.0), False, "lowest point of the chin"),
    ("throat", (0.0, -113.2, -30.4), False, "where the chin's underside turns into the neck"),
    ("jaw_corner_{side}", (57.0, -72.0, -48.0), False, "corner of the jaw below the ear"),
    ("ear_front_{side}", (71.3, -19.9, -55.9), False, "the flap before the ear's opening"),
    ("ear_top_{side}", (81.0, 3.2, -75.9), False, "highest point of the ear"),
    ("ear_lobe_{side}", (72.8, -46.8, -65.9), False, "lowest point of the ear"),
    ("crown", (0.0, 107.4, -68.3), False, "highest point of the head"),
    ("head_back", (0.0, 25.7, -162.9), False, "rearmost point of the head"),
)  # fmt: skip

_HEAD = """# Landmarks by which heads and photographs are fitted; written by tools/place_landmarks.py.
# vertex: of the default face's skin. Left and right are the person's own.
"""


def main() -> None:
    """Read the command line and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    space = head_space()
    mirror = np.array([-1.0, 1.0, 1.0])
    lines = [_HEAD]
    outer = np.flatnonzero(space.outer())
    for name, place, needed, words in LANDMARKS:
        for side in ("left", "right") if "{side}" in name else ("",):
            if isinstance(place, str):
                vertex = space.face.sites[place.replace("left", side or "left")][1]
            else:
                wanted = np.array(place) * (mirror if side == "right" else 1)
                vertex = int(outer[np.argmin(np.linalg.norm(space.rest[outer] - wanted, axis=1))])
            lines.append(f"[{name.format(side=side)}]\nvertex = {vertex}\nneeded = {str(needed).lower()}")
            lines.append(f'words = "{words}"\n')
    parser.parse_args().out.write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
