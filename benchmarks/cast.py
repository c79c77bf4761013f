"""Whether every face of the cast does what the default face does: lips that meet, shapes, markers, deformers, size.

::

    python benchmarks/cast.py [--face NAME ...] [--out docs/tables/cast.md]

One sentence full of /p b m/ is performed once and shown on each face. *Lips* is the largest distance in 3D, over all
/p b m/ of the sentence, between the inner edges of upper and lower lip where they come nearest in the sound (mm);
*blink* what is left between the lids at a full blink (mm); *least emotion* the weakest of six expressions, as the share
of the default face's mean movement of the skin; *unlike* the RMS distance of its skin to the nearest other face (mm).
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import mien
from mien.capture.layouts import known_layouts
from mien.core.facs import basic_expressions, expression_channels
from mien.core.files import replace_when_complete
from mien.face.deformers import deformed_by, poser_for
from mien.face.library import known_faces, load_face
from mien.face.marker_sites import load_marker_places, place_markers
from mien.face.model import Face
from mien.face.posing import Poser

SENTENCE = "Bob and my papa map a big pump, maybe Pam will probably buy the blue one."
SHUT = ("P", "B", "M")
DEFORMERS = ("blendshapes", "tree", "regions")


def _part(face: Face, name: str) -> int:
    return [part.name for part in face.parts].index(name)


def lips(face: Face, animation: mien.Animation) -> float:
    """Largest of the least lip distances in /p b m/, mm."""
    poser, skin = Poser(face, animation.channels.names), _part(face, "skin")
    upper, lower = ([face.sites[f"lip_{s}_inner{k}"][1] for k in ("", "_l1", "_r1")] for s in ("upper", "lower"))
    fps, rows, worst = animation.channels.rate.fps, animation.channels.values, 0.0
    for phone in animation.utterance.phones.intervals:
        if phone.label in SHUT:
            frames = rows[round(phone.start * fps) : round(phone.end * fps) + 1]
            points = [poser.pose(row).parts[skin].vertices for row in frames]
            worst = max(worst, min(float(np.linalg.norm(p[upper] - p[lower], axis=1).mean()) for p in points))
    return worst


def blink(face: Face) -> float:
    """What a full blink leaves between the lids, mm."""
    posed = Poser(face, ("eyeBlinkLeft", "eyeBlinkRight")).pose([1, 1]).parts[_part(face, "skin")].vertices
    pairs = [[face.sites[f"lid_{lid}_{side}"][1] for lid in ("upper", "lower")] for side in ("left", "right")]
    return max(float(np.linalg.norm(posed[one] - posed[other])) for one, other in pairs)


def movement(face: Face) -> dict[str, float]:
    """Mean movement of the face's skin at full, mm, by expression."""
    found = {}
    for name in basic_expressions():
        channels = {c: w for c, w in expression_channels(name).items() if w}
        poser, skin = Poser(face, tuple(channels)), _part(face, "skin")
        moved = poser.pose(list(channels.values())).parts[skin].vertices - face.parts[skin].vertices
        found[name] = float(np.linalg.norm(moved, axis=1)[face.parts[skin].vertices[:, 2] > -20].mean())
    return found


HEAD = (
    "face", "lips mm", "blink mm", "least emotion", "shapes missing", "markers placed", "deformers", "1000 triangles",
    "unlike mm",
)  # fmt: skip


def row_of(face: Face, animation: mien.Animation, own: dict[str, float]) -> list[str]:
    """The figures of one face, without how unlike it is."""
    missing = set(load_face("default").part("skin").targets) - set(face.part("skin").targets)
    placed = sum(len(place_markers(face, load_marker_places(layout)).names) for layout in known_layouts())
    for deformer in DEFORMERS:
        poser_for(deformed_by(face, deformer), ("jawOpen",)).pose([0.5])
    moved = movement(face)
    least = min((moved[name] / own[name], name) for name in own)
    numbers = f"{lips(face, animation):.2f}", f"{blink(face):.2f}", f"{least[0]:.2f} ({least[1]})"
    triangles = sum(len(part.triangles) for part in face.parts) / 1000
    return [face.name, *numbers, f"{len(missing)}", f"{placed}", f"{len(DEFORMERS)}", f"{triangles:.0f}"]


def main() -> None:
    """Measure and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--face", nargs="+", default=list(known_faces()))
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    animation, own = mien.say(SENTENCE), movement(load_face("default"))
    rows, heads = [], {}
    for name in given.face:
        face = load_face(name)
        skin = face.part("skin").vertices.astype(float)
        heads[name] = skin - skin[skin[:, 2] > -20].mean(axis=0)
        rows.append(row_of(face, animation, own))
        print(*rows[-1], flush=True)
    for row, name in zip(rows, given.face, strict=True):
        away = [np.sqrt(((heads[name] - head) ** 2).sum(1).mean()) for other, head in heads.items() if other != name]
        row.append(f"{min(away, default=float('nan')):.1f}")
    table = "\n".join("| " + " | ".join(row) + " |" for row in [HEAD, ["---"] * len(HEAD), *rows])
    if given.out:
        with replace_when_complete(given.out) as unfinished:
            unfinished.write_text(f"# The cast\n\n{__doc__.replace('::' + chr(10) * 2, '', 1)}\n{table}\n")


if __name__ == "__main__":
    main()
