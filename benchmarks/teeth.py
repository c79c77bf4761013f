"""How far the front teeth of the default face stand apart while a performer speaks, by phone.

    python benchmarks/teeth.py [PERFORMER]      # default, a name or a .mien; printed

Lips can be right over a jaw that is not: recordings of one camera leave the jaw to be guessed.
"""

from __future__ import annotations

import argparse
from collections import defaultdict

import numpy as np
from numpy.typing import NDArray

import mien
from mien.face.library import load_face

SENTENCES = (
    "She sells sea shells by the sea shore.",
    "Pam moved five big vans by the blue mill.",
    "He said the cat sat on the ten black mats.",
)
CLASSES = {
    "silence": ("SIL",),
    "p b m": ("P", "B", "M"),
    "f v": ("F", "V"),
    "s z": ("S", "Z"),
    "t d n": ("T", "D", "N"),
    "iy": ("IY",),
    "aa ae ay": ("AA", "AE", "AY"),
}


def incisors(name: str, side: float) -> int:
    """The vertex of a row of teeth that reaches the other one at the middle of the front."""
    vertices = load_face("default").part(name).vertices
    front = np.flatnonzero((np.abs(vertices[:, 0]) < 4) & (vertices[:, 2] > vertices[:, 2].max() - 4))
    return int(front[np.argmax(side * vertices[front, 1])])


def heights(name: str, vertex: int, animation: mien.Animation) -> NDArray[np.float64]:
    """Height of a vertex of the teeth in every frame, mm."""
    part, track = load_face("default").part(name), animation.channels
    out = np.full(len(track.values), float(part.vertices[vertex, 1]))
    for number, channel in enumerate(track.names):
        target = part.targets.get(channel)
        if target is not None:
            moved = target.offsets[target.vertices == vertex]
            out += track.values[:, number] * float(moved.sum(axis=0)[1])
    return out


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("performer", nargs="?", default="default", help="a name or a .mien (default: default)")
    performer = parser.parse_args().performer
    upper, lower = incisors("teeth_upper", -1.0), incisors("teeth_lower", 1.0)
    found: dict[str, list[float]] = defaultdict(list)
    for sentence in SENTENCES:
        line = mien.say(sentence, performer=performer, seed=1)
        gap = heights("teeth_upper", upper, line) - heights("teeth_lower", lower, line)
        for phone in line.utterance.phones:
            frame = int((phone.start + phone.end) / 2 * float(line.channels.rate.fraction))
            if frame < len(gap):
                found[phone.label].append(float(gap[frame]))
    print(f"{performer}: mm between the front teeth, mean (at rest they overlap by 1.2)")
    for name, phones in CLASSES.items():
        values = [value for phone in phones for value in found[phone]]
        print(f"{name:10s} {np.mean(values):5.1f}  ({len(values)} phones)")


if __name__ == "__main__":
    main()
