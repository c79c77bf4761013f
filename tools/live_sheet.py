"""Draws what ``mien live`` shows of a sound under what ``mien animate`` makes of it with its text, frame by frame.

    python tools/live_sheet.py SOUND "ITS TEXT" OUT.jpg --look-ahead 150

Over each pair of pictures stand the phones that were shown (offline, live), bilabials in red; in them the lip opening.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
from hand_labels import Labelled
from live_accuracy import OFFLINE, Mouth, live, offline

from mien.core import channels
from mien.face.library import load_face
from mien.face.posing import Poser
from mien.face.render.camera import Camera
from mien.face.render.renderer import Renderer
from mien.formats.sound_files import read_audio
from mien.speech.align import align

SIDE, LINE, COLUMNS = 150, 16, 12


def main() -> None:
    """Perform the sound both ways and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sound")
    parser.add_argument("text")
    parser.add_argument("out", type=Path)
    parser.add_argument("--look-ahead", type=float, default=150.0, help="milliseconds (default 150)")
    parser.add_argument("--first", type=int, default=4, help="first frame that is drawn (default 4)")
    parser.add_argument("--step", type=int, default=2, help="draw one frame in so many (default 2)")
    parser.add_argument("--rows", type=int, default=3)
    options = parser.parse_args()
    audio, _ = read_audio(options.sound)
    item = Labelled(options.sound, audio, tuple(align(audio, options.text).words))
    above = offline(item, OFFLINE["offline, its true text, aligned"])
    below = live(item, options.look_ahead / 1000)
    frames = range(options.first, len(above.values), options.step)[: COLUMNS * options.rows]
    face, mouth = load_face("default"), Mouth()
    renderer = Renderer(face, 2 * SIDE, 2 * SIDE, Camera.head_shot(face, 1.0))
    poser = Poser(face, channels.ALL)
    height = 2 * SIDE + LINE
    sheet = Image.new("RGB", (COLUMNS * SIDE, -(-len(frames) // COLUMNS) * height), "white")
    draw = ImageDraw.Draw(sheet)
    for place, frame in enumerate(frames):
        left, top = place % COLUMNS * SIDE, place // COLUMNS * height
        shut = above.labels[frame] in ("P", "B", "M")
        told = f"{frame}: {above.labels[frame]}, live {below.labels[frame]}"
        draw.text((left + 4, top + 2), told, fill="red" if shut else "black")
        for row, shown in enumerate((above, below)):
            picture = Image.fromarray(renderer.render(poser.pose(shown.values[frame])))
            lower = picture.crop((SIDE // 2, 2 * SIDE - SIDE - SIDE // 8, SIDE // 2 + SIDE, 2 * SIDE - SIDE // 8))
            sheet.paste(lower, (left, top + LINE + row * SIDE))
            opening = float(mouth.opening(shown.values[frame : frame + 1])[0])
            draw.text((left + 4, top + LINE + row * SIDE + 4), f"{np.round(opening, 1):g} mm", fill="white")
    sheet.save(options.out, quality=85)


if __name__ == "__main__":
    main()
