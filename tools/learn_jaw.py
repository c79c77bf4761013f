"""Learn what lips tell of a jaw from facegood-mandarin, and write it where capture reads it (NOTICE).

    python tools/learn_jaw.py DATA/facegood-mandarin

A professional speaker's rig curves become channels (tools/learn_mandarin.py) and move the lips of the default face. By
least squares, over all frames with a jaw that is open: which shares of the lower lip's lowering and of the upper lip's
raising, both in units of what jawOpen does to the lower lip, give jawOpen. `mien.capture.one_camera` uses them.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
from learn_mandarin import LAYOUT, as_channels

from mien.capture.layouts import load_layout
from mien.capture.openings import openings_of
from mien.core import channels
from mien.face.library import load_face
from mien.face.marker_sites import place_markers
from mien.face.retargeting import basis_at

TARGET = Path(__file__).parent.parent / "src" / "mien" / "assets" / "capture" / "solver.toml"
OPEN = 0.02


def main() -> None:
    """Fit, print and write."""
    layout, face = load_layout(LAYOUT), load_face("default")
    placed = place_markers(face, layout, layout.markers)
    openings = openings_of(layout.landmarks, layout.markers, placed.places, placed.places[None])
    lips = next(seen for seen in openings if seen.opening.name == "mouth")
    height = basis_at(face, placed.sites, channels.WEIGHTS)[:, :, lips.opening.axis]
    file = np.load(Path(sys.argv[1]) / "curves.npz")
    names = [str(name) for name in file["names"]]
    takes = [file[path.stem] for path in sorted((Path(sys.argv[1]) / "audio").glob("*.flac"))]
    weights = np.concatenate([as_channels(take.astype(np.float64), names) for take in takes])
    number = channels.WEIGHTS.index("jawOpen")
    raising, lowering = height @ np.maximum(lips.rows, 0.0), height @ np.minimum(lips.rows, 0.0)
    jaw, lowered, raised = weights[:, number], weights @ lowering, np.maximum(weights @ raising, 0.0)
    there = jaw > OPEN
    seen = np.stack([lowered, -raised], axis=1)[there] / lowering[number]
    (lower, upper), *_ = np.linalg.lstsq(seen, jaw[there], rcond=None)
    found = seen @ (lower, upper)
    print(f"{there.sum()} frames: lower {lower:.2f}, upper {upper:.2f}, r {np.corrcoef(found, jaw[there])[0, 1]:.3f}")
    text = TARGET.read_text(encoding="utf-8")
    table = f"[jaw]\nlower = {lower:.2f}\nupper = {upper:.2f}\n"
    assert "[jaw]" in text
    TARGET.write_text(re.sub(r"\[jaw\]\nlower = .*\nupper = .*\n", table, text), encoding="utf-8")


if __name__ == "__main__":
    main()
