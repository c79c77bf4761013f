"""How far the pictures of a graphics card are from the processor's, and how long each takes.

    python benchmarks/painters.py [--size 640x480]

writes ``docs/tables/painters.md``: three faces, at rest and laughing, from two sides. A difference is that of the
numbers of a picture, in percent of their range.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

import numpy as np

from mien.core.channels import ALL
from mien.core.files import replace_when_complete
from mien.face.deformers import poser_for
from mien.face.library import load_face
from mien.face.render.graphics_card import graphics_card
from mien.face.render.view import PAINTERS, View, parse_size

TABLE = Path(__file__).parent.parent / "docs" / "tables" / "painters.md"
FACES = {"default": "short hair", "priya": "long hair", "yusuf": "curls, full beard"}
LAUGH = {"jawOpen": 0.6, "mouthSmileLeft": 0.8, "mouthSmileRight": 0.8, "cheekSquintLeft": 0.6, "browInnerUp": 0.7}
POSES: dict[str, dict[str, float]] = {"at rest": {}, "laughing": LAUGH}
HEAD = (
    "face", "camera", "pose", "mean difference, %", "99th percentile, %", "pixels apart by over 2 %, %",
    "processor, ms", "gpu, ms",
)  # fmt: skip


def rows(size: tuple[int, int]) -> list[str]:
    found = []
    for name, hair in FACES.items():
        face = load_face(name)
        poser = poser_for(face, ALL)
        for camera in ("head", "three-quarter"):
            renderers = [View(*size, camera=camera, painter=painter).renderer(face) for painter in PAINTERS]
            for label, values in POSES.items():
                pose = poser.pose(np.array([values.get(channel, 0.0) for channel in ALL]))
                pictures, spent = [], []
                for renderer in renderers:
                    renderer.render(pose)
                    begin = time.perf_counter()
                    pictures.append(renderer.render(pose).astype(int))
                    spent.append(1000 * (time.perf_counter() - begin))
                apart = np.abs(pictures[0] - pictures[1]) / 2.55
                found.append(
                    f"| {name} ({hair}) | {camera} | {label} | {apart.mean():.2f} | {np.percentile(apart, 99):.1f} "
                    f"| {100 * (apart > 2).any(axis=2).mean():.1f} | {spent[0]:.0f} | {spent[1]:.0f} |"
                )
                print(found[-1], flush=True)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--size", default="640x480", help="of the pictures (default 640x480)")
    size = parse_size(parser.parse_args().size)
    load, card = os.getloadavg()[0], graphics_card().name
    software = ", which is software: the processor again" if "llvmpipe" in card or "softpipe" in card else ""
    lines = [
        "# The processor's pictures and a graphics card's",
        "",
        f"Written by `python benchmarks/painters.py`; {size[0]} x {size[1]} pixels; drawn by {card}{software}. "
        f"Other work on the machine: {load:.1f} processes before, of {os.cpu_count()} cores.",
        "",
        f"| {' | '.join(HEAD)} |",
        "|" + " --- |" * len(HEAD),
        *rows(size),
        "",
    ]
    with replace_when_complete(TABLE) as unfinished:
        unfinished.write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
