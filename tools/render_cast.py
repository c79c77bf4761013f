"""Draw the cast: portraits that ship with mien, and the sheets of docs/faces.md.

::

    python tools/render_cast.py [NAME ...]     # all, or the portraits of some
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from PIL import Image

from mien.core.channels import ALL
from mien.core.facs import expression_channels
from mien.face.library import known_faces, load_face
from mien.face.posing import Poser
from mien.face.render.camera import Camera
from mien.face.render.renderer import Renderer
from mien.formats.contact_sheet import contact_sheet

ROOT = Path(__file__).resolve().parents[1]
PORTRAITS = ROOT / "src/mien/assets/faces/portraits"
CLOSE = ("walter", "amara", "mei", "yusuf")
VIEWS = {"front": (0, 0), "three-quarter": (38, 0), "side": (85, 0), "below": (15, -28)}
EMOTIONS = ("happiness", "sadness", "anger", "surprise", "disgust")


def draw(face: object, camera: Camera, size: tuple[int, int], pose: dict[str, float] | None = None) -> np.ndarray:
    """One picture."""
    poser = Poser(face, ALL)
    row = np.array([(pose or {}).get(name, 0.0) for name in ALL])
    return Renderer(face, *size, camera).render(poser.pose(row))


def main() -> None:
    """Draw."""
    chosen = sys.argv[1:] or known_faces()
    PORTRAITS.mkdir(exist_ok=True)
    pictures: dict[str, np.ndarray] = {}
    for name in chosen:
        face = load_face(name)
        pictures[name] = draw(face, Camera.head_shot(face, 0.8).turned(14), (400, 500))
        small = Image.fromarray(pictures[name]).resize((160, 200), Image.Resampling.LANCZOS)
        small.save(PORTRAITS / f"{name}.jpg", quality=84)
        print(name, flush=True)
    if sys.argv[1:]:
        return
    names = list(known_faces())
    sheet = contact_sheet([np.asarray(Image.fromarray(pictures[n]).resize((200, 250))) for n in names], names, 7)
    Image.fromarray(sheet).save(ROOT / "docs/pictures/cast.jpg", quality=84)
    rows, labels = [], []
    for name in CLOSE:
        face = load_face(name)
        camera = Camera.head_shot(face, 0.9)
        for view, (yaw, pitch) in VIEWS.items():
            rows.append(draw(face, camera.turned(yaw, pitch), (225, 250)))
            labels.append(f"{name}, {view}")
        for emotion in EMOTIONS:
            rows.append(draw(face, camera, (225, 250), expression_channels(emotion)))
            labels.append(f"{name}, {emotion}")
    Image.fromarray(contact_sheet(rows, labels, 9)).save(ROOT / "docs/pictures/cast-close.jpg", quality=82)


if __name__ == "__main__":
    main()
