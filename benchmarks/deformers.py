"""The three deformers on the default face, side by side: a picture, and how far they lie apart.

::

    python benchmarks/deformers.py [--articulation X.tree]

writes ``docs/pictures/deformers.jpg`` and ``docs/tables/deformers.md``. With a tree made by
``mien face articulation CORPUS -o X.tree`` that one stands beside the others.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from mien.channels import ALL
from mien.face.deformers import deformed_by, poser_for
from mien.face.face import Face
from mien.face.facs import channels_of_units, expression_channels
from mien.face.library import load_face
from mien.files import replace_when_complete
from mien.render.camera import Camera
from mien.render.renderer import Renderer

DOCS = Path(__file__).parent.parent / "docs"
WIDTH, HEIGHT = 230, 260
POSES: dict[str, dict[str, float]] = {
    "rest": {},
    "jaw half open": {"jawOpen": 0.5},
    "AU6 12 25": channels_of_units({"AU6": 1.0, "AU12": 1.0, "AU25": 1.0}),
    "/uw/": {"mouthPucker": 0.95, "mouthFunnel": 0.22, "jawOpen": 0.06},
    "AU43L, half R": {"eyeBlinkLeft": 1.0, "eyeBlinkRight": 0.5},
    "anger": expression_channels("anger"),
    "fear": expression_channels("fear"),
    "surprise, turned": {**expression_channels("surprise"), "headYaw": 25.0, "headPitch": -8.0},
}


def row_of(pose: dict[str, float]) -> np.ndarray:
    return np.array([pose.get(name, 0.0) for name in ALL])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--articulation", metavar="X.tree", help="a tree of articulatory parameters")
    given = parser.parse_args()
    face = load_face()
    faces = {name: deformed_by(face, name) for name in ("blendshapes", "tree", "regions")}
    if given.articulation:
        faces["articulatory tree"] = deformed_by(face, given.articulation)
    draw(faces)
    tell(faces, learned_facts(given.articulation))


def learned_facts(path: str | None) -> list[str]:
    """What 'mien face articulation' wrote at the head of its file."""
    if path is None:
        return []
    lines = Path(path).read_text(encoding="utf-8").splitlines()
    facts = [line[2:] for line in lines if line.startswith("# ")]
    return ["", "## The articulatory tree", "", "```", *facts, "```"]


def draw(faces: dict[str, Face]) -> None:
    sheet = Image.new("RGB", (len(POSES) * WIDTH, len(faces) * HEIGHT))
    camera = Camera((0.0, -22.0, 10.0), distance=1100.0, field_mm=190.0)
    for row, (name, face) in enumerate(faces.items()):
        poser, renderer = poser_for(face, ALL), Renderer(face, WIDTH, HEIGHT, camera)
        for column, (label, pose) in enumerate(POSES.items()):
            picture = Image.fromarray(renderer.render(poser.pose(row_of(pose))))
            ImageDraw.Draw(picture).text((6, 4), f"{name}: {label}", fill=(245, 245, 245))
            sheet.paste(picture, (column * WIDTH, row * HEIGHT))
    with replace_when_complete(DOCS / "pictures" / "deformers.jpg") as unfinished:
        sheet.save(unfinished, format="JPEG", quality=86, optimize=True)


def tell(faces: dict[str, Face], facts: list[str]) -> None:
    """Distance from the blendshapes on the front of the skin, mm: RMS and greatest."""
    plain = faces["blendshapes"]
    skin = [part.name for part in plain.parts].index("skin")
    points = plain.parts[skin].vertices
    front = (points[:, 2] > 0) & (points[:, 1] > -105)
    others = [name for name in faces if name != "blendshapes"]
    lines = [
        "# Deformers",
        "",
        "Distance from the morph targets on the front of the default face's skin, mm: RMS over vertices / greatest.",
        "Written by `python benchmarks/deformers.py`. The targets are no truth: half way they run straight.",
        "",
        f"| pose | {' | '.join(others)} |",
        f"| --- |{' --- |' * len(others)}",
    ]
    for label, pose in POSES.items():
        rest = poser_for(plain, ALL).pose(row_of(pose)).parts[skin].vertices[front]
        cells = []
        for name in others:
            moved = poser_for(faces[name], ALL).pose(row_of(pose)).parts[skin].vertices[front]
            away = np.linalg.norm(moved - rest, axis=1)
            cells.append(f"{np.sqrt((away**2).mean()):.2f} / {away.max():.2f}")
        lines.append(f"| {label} | {' | '.join(cells)} |")
    lines += facts
    with replace_when_complete(DOCS / "tables" / "deformers.md") as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
