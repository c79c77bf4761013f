"""Draws every command of the library at its fullest moment: docs/pictures/commands.jpg, and writes docs/commands.md.

usage: python tools/render_commands.py
       python tools/render_commands.py FOLDER    only sheets of all commands in motion, front and side
"""

from __future__ import annotations

import io
import sys
from pathlib import Path

import numpy as np
from PIL import Image

from mien.core import channels
from mien.face.library import load_face
from mien.face.posing import Poser
from mien.face.render.camera import Camera
from mien.face.render.renderer import Renderer
from mien.formats.contact_sheet import contact_sheet
from mien.text.commands import Command, shipped_library
from mien.text.library_file import CommandDefinition
from mien.text.parameter_curves import lay_over
from mien.text.procedures import PROCEDURES

DOCS = Path(__file__).parents[1] / "docs"
LOOK_AT = {"yaw": "15", "pitch": "10"}


def motion(name: str, fps: float = 30.0) -> np.ndarray:
    """Channels of a command over its whole length, shape (frames, channels)."""
    given = (("at", "300"), *(LOOK_AT.items() if name == "LookAt" else ()))
    curves = shipped_library().translate(Command(name, given)).curves
    end = max(curve.keys[-1][0] + curve.fade for curve in curves) / 1000 + 0.1
    times = np.arange(0, end, 1 / fps)
    values = lay_over(np.zeros((len(times), len(channels.ALL))), channels.ALL, curves, times)
    weights = slice(0, len(channels.ARKIT) + len(channels.TONGUE))
    values[:, weights] = np.clip(values[:, weights], 0, 1)
    return values


def scaled(values: np.ndarray) -> np.ndarray:
    """How much moves in each frame: weights, and head angles in parts of 60 degrees."""
    heads = [channels.ALL.index(name) for name in channels.HEAD]
    size = np.abs(values)
    size[:, heads] /= 60
    return size.sum(axis=1)


def sheet() -> None:
    """All commands at their fullest moment."""
    face = load_face("default")
    poser, width, height = Poser(face, channels.ALL), 240, 270
    renderer = Renderer(face, width, height, Camera.head_shot(face, width / height))
    names = shipped_library().names
    fullest = [(values := motion(name))[np.argmax(scaled(values))] for name in names]
    images = [renderer.render(poser.pose(pose)) for pose in fullest]
    buffer = io.BytesIO()
    Image.fromarray(contact_sheet(images, names, 7)).save(buffer, format="JPEG", quality=88)
    (DOCS / "pictures" / "commands.jpg").write_bytes(buffer.getvalue())


def strips(folder: Path, frames: int = 8, rows: int = 5) -> None:
    """All commands in motion, from the front and from the side, in sheets of a few each: for looking at."""
    face = load_face("default")
    poser, width, height = Poser(face, channels.ALL), 150, 170
    camera = Camera.head_shot(face, width / height)
    views = [Renderer(face, width, height, view) for view in (camera, camera.turned(75))]
    names = shipped_library().names
    folder.mkdir(parents=True, exist_ok=True)
    for first in range(0, len(names), rows):
        images, labels = [], []
        for name in names[first : first + rows]:
            values = motion(name)
            shown = np.linspace(8, len(values) - 1, frames).round().astype(int)
            for view in views:
                images += [view.render(poser.pose(values[frame])) for frame in shown]
                labels += [f"{name[:12]} {frame / 30:.2f}" for frame in shown]
        Image.fromarray(contact_sheet(images, labels, frames)).save(folder / f"commands-{first:02d}.png")


def _described(definition: CommandDefinition) -> str:
    optional = ", ".join(f"{name}={value:g}" for name, value in definition.optional.items())
    moves = ", ".join(definition.lists)
    return f"| `{definition.name}` | {definition.about} | {optional} | {definition.procedure} | {moves} |"


def page() -> None:
    """The generated half of docs/commands.md."""
    library = shipped_library()
    rows = [_described(library[name]) for name in library.names]
    procedures = [
        f"| `{name}` | {procedure.about} | {', '.join(procedure.uses)} |" for name, procedure in PROCEDURES.items()
    ]
    text = (DOCS / "commands.md").read_text(encoding="utf-8").partition("<!-- generated -->")[0]
    text += "<!-- generated -->\n\n## Procedures\n\n| name | what it does | parameters |\n| --- | --- | --- |\n"
    text += "\n".join(procedures)
    text += f"\n\n## The shipped commands ({len(rows)})\n\n![Every command at its fullest](pictures/commands.jpg)\n\n"
    text += (
        "| command | what it does | parameters and defaults | procedure | moves |\n| --- | --- | --- | --- | --- |\n"
    )
    (DOCS / "commands.md").write_text(text + "\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        strips(Path(sys.argv[1]))
    else:
        sheet()
        page()
