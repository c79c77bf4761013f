"""The three deformers side by side, on the default face and on another one: pictures, and how far they lie apart.

::

    python benchmarks/deformers.py [--corpus grid-corpus]

writes ``docs/pictures/deformers.jpg``, ``deformers-another.jpg`` and ``docs/tables/deformers.md``. With a corpus, trees
of articulatory parameters learned from it stand beside the others: with leaves for what they cannot say of a channel,
and with the parameters alone.

The other face has other proportions, another mesh and no named sites (`tests/another_face.py`): markers find their
places on it as on any face.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from mien.core.channels import ALL
from mien.core.facs import channels_of_units, expression_channels
from mien.core.files import replace_when_complete
from mien.face.deformers import deformed_by, poser_for
from mien.face.library import load_face
from mien.face.marker_sites import load_marker_places, place_markers
from mien.face.model import Face
from mien.face.render.camera import Camera
from mien.face.render.renderer import Renderer

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
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
    parser.add_argument("--corpus", metavar="CORPUS", help="learn articulatory parameters from this corpus")
    given = parser.parse_args()
    sys.path.insert(0, str(ROOT))
    from tests.another_face import another_face, bend

    default = load_face()
    another, numbers = another_face(default)
    model, facts = learned(given.corpus, default) if given.corpus else (None, [])
    lines = [
        "# Deformers",
        "",
        "Distance from the morph targets on the front of the skin, mm: RMS over vertices / greatest.",
        "Written by `python benchmarks/deformers.py --corpus CORPUS`. The targets are no truth: half way they run",
        "straight. *Articulatory* has leaves for what its parameters cannot say of a channel; *parameters alone* has",
        "none: they were learned from neutral speech, and no smile is in them.",
    ]
    for face, picture in ((default, "deformers.jpg"), (another, "deformers-another.jpg")):
        faces = moved_faces(face, model)
        draw(faces, DOCS / "pictures" / picture)
        lines += ["", f"## The {'default' if face is default else 'other'} face", "", *compared(faces)]
    lines += ["", "## Markers on the other face", "", *sites_found(default, another, numbers, bend), *facts]
    with replace_when_complete(DOCS / "tables" / "deformers.md") as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


def moved_faces(face: Face, model: Any) -> dict[str, Face]:
    from mien.face.deformers import with_tree
    from mien.motion.mouth.articulatory import articulatory_tree

    faces = {name: deformed_by(face, name) for name in ("blendshapes", "tree", "regions")}
    if model is not None:
        for name, remainders in (("articulatory", True), ("parameters alone", False)):
            faces[name] = with_tree(face, articulatory_tree(model, face, remainders=remainders))
    return faces


def learned(path: str, face: Face) -> tuple[object, list[str]]:
    """The articulatory model of a corpus, and what is known of it, in lines."""
    from mien.corpus.recordings import Corpus
    from mien.motion.mouth.articulatory import ArticulatoryModel, held_out_errors, speaking_frames, takes_apart

    kept, held = takes_apart(list(Corpus(path)))
    positions, markers, layout = speaking_frames(kept)
    model = ArticulatoryModel().fit(positions, markers, layout)
    apart = speaking_frames(held)[0]
    facts = [f"{len(kept)} takes, {len(positions)} frames of speech, {len(markers)} mouth markers ({layout})"]
    facts += [*model.summary().splitlines(), f"RMS distance on {len(held)} takes held out ({len(apart)} frames):"]
    facts += [f"  {name}: {e:.2f} mm" for name, e in held_out_errors(model, apart, positions, face).items()]
    return model, ["", "## The articulatory parameters", "", "```", *facts, "```"]


def sites_found(default: Face, another: Face, numbers: np.ndarray, bend: object) -> list[str]:
    """How far the markers lie from where they truly are on the other face."""
    layout = load_marker_places("mediapipe-218")
    here, there = place_markers(default, layout), place_markers(another, layout)
    truth = bend(np.array([default.part(part).vertices[vertex] for part, vertex in here.sites]))  # type: ignore[operator]
    found = np.array([another.part(part).vertices[vertex] for part, vertex in there.sites])
    away = np.linalg.norm(found - truth, axis=1)
    plain = np.linalg.norm(layout.places - truth, axis=1)
    return [
        f"{len(away)} markers, found through what channels move and the eyes ({there.how}): mean {away.mean():.1f} mm, "
        f"nine in ten within {np.percentile(away, 90):.1f} mm, farthest {away.max():.1f} mm",
        f"(the default face's own places would be {plain.mean():.1f} mm off, {plain.max():.1f} mm at most).",
    ]


def draw(faces: dict[str, Face], path: Path) -> None:
    sheet = Image.new("RGB", (len(POSES) * WIDTH, len(faces) * HEIGHT))
    camera = Camera((0.0, -22.0, 10.0), distance=1100.0, field_mm=200.0)
    for row, (name, face) in enumerate(faces.items()):
        poser, renderer = poser_for(face, ALL), Renderer(face, WIDTH, HEIGHT, camera)
        for column, (label, pose) in enumerate(POSES.items()):
            picture = Image.fromarray(renderer.render(poser.pose(row_of(pose))))
            ImageDraw.Draw(picture).text((6, 4), f"{name}: {label}", fill=(245, 245, 245))
            sheet.paste(picture, (column * WIDTH, row * HEIGHT))
    with replace_when_complete(path) as unfinished:
        sheet.save(unfinished, format="JPEG", quality=82, optimize=True)


def compared(faces: dict[str, Face]) -> list[str]:
    """Distance from the blendshapes on the front of the skin, mm: RMS and greatest."""
    plain = faces["blendshapes"]
    skin = [part.name for part in plain.parts].index("skin")
    points = plain.parts[skin].vertices
    front = (points[:, 2] > 0) & (points[:, 1] > -105)
    others = [name for name in faces if name != "blendshapes"]
    lines = [f"| pose | {' | '.join(others)} |", f"| --- |{' --- |' * len(others)}"]
    for label, pose in POSES.items():
        rest = poser_for(plain, ALL).pose(row_of(pose)).parts[skin].vertices[front]
        cells = []
        for name in others:
            moved = poser_for(faces[name], ALL).pose(row_of(pose)).parts[skin].vertices[front]
            away = np.linalg.norm(moved - rest, axis=1)
            cells.append(f"{np.sqrt((away**2).mean()):.2f} / {away.max():.2f}")
        lines.append(f"| {label} | {' | '.join(cells)} |")
    return lines


if __name__ == "__main__":
    main()
