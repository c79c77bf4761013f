"""Learn how the level of a voice goes with the opening of a mouth, from facegood-mandarin (NOTICE).

    python tools/learn_effort.py DATA/facegood-mandarin

Writes src/mien/assets/effort/jaw.toml, the same bytes each time. Every frame of speech (at most 30 dB below the loudest
of its recording) gives the level of the voice, the opening of the jaw, and how far the lips are from their mean shape;
all are taken about their mean in the recording. The slope on the level says by which share of its mean each grows for a
decibel.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.formats.sound_files import read_audio
from mien.motion.effort import DECIBELS
from mien.speech.pitch import level_contour

TARGET = Path(__file__).parent.parent / "src" / "mien" / "assets" / "effort" / "jaw.toml"
JAW, TEETH, FPS, RANGE, WINDOW = "mouth_stretch_c", "tooth_d_d", 30, 30.0, 0.064
STEP = 0.25
Floats = NDArray[np.float64]


def main() -> None:
    """Learn and save."""
    folder = Path(sys.argv[1])
    curves = np.load(folder / "curves.npz")
    names = [str(name) for name in curves["names"]]
    lips = [number for number, name in enumerate(names) if name not in (JAW, TEETH)]
    levels, moved, means = [], [], []
    everywhere = []
    for path in sorted((folder / "audio").glob("*.flac")):
        sound, motion = read_audio(path)[0], curves[path.stem].astype(np.float64)
        level = level_contour(sound, window=WINDOW).decibels_at(np.arange(len(motion)) / FPS)
        spoken = level > np.percentile(level, 95) - RANGE
        jaw, away = motion[:, names.index(JAW)], motion[:, lips] - motion[spoken][:, lips].mean(axis=0)
        both = np.stack([jaw, np.linalg.norm(away, axis=1)], axis=1)
        everywhere.append(np.corrcoef(level, jaw)[0, 1])
        levels.append(level[spoken] - level[spoken].mean())
        moved.append(both[spoken] - both[spoken].mean(axis=0))
        means.append(both[spoken])
    level, motion, mean = np.concatenate(levels), np.concatenate(moved), np.concatenate(means).mean(axis=0)
    growth = level @ motion / (level @ level) / mean
    correlation = [np.corrcoef(level, column)[0, 1] for column in motion.T]
    write(level, growth, correlation, float(np.mean(everywhere)))


def write(level: Floats, growth: Floats, correlation: list[float], everywhere: float) -> None:
    """The table: linear in decibels."""
    efforts = np.arange(0, 2 + STEP / 2, STEP)
    low, high = np.percentile(level, [2, 98])
    lines = [
        "# How much further a mouth moves with effort. Learned from FACEGOOD-Audio2Face by",
        "# tools/learn_effort.py (NOTICE); not made by hand.",
        f"# {len(level)} frames of speech, {low:+.1f} to {high:+.1f} dB about their recording's mean (2 to 98 %);",
        f"# beyond that the line is drawn on. A step of 1 in effort is {DECIBELS:g} dB. Level and jaw with pauses:",
        f"# r {everywhere:.2f}, the mean of the recordings.",
    ]
    tables = [f"effort = [{', '.join(f'{effort:g}' for effort in efforts)}]"]
    for name, grown, r in zip(("jaw", "lips"), growth, correlation, strict=True):
        lines.append(f"#   {name}: {100 * grown:+.2f} % of the mean for a decibel, r {r:.2f}")
        gains = np.maximum(1 + grown * DECIBELS * (efforts - 1), 0)
        tables.append(f"{name} = [{', '.join(f'{gain:.3f}' for gain in gains)}]")
    TARGET.parent.mkdir(exist_ok=True)
    TARGET.write_text("\n".join([*lines, *tables, ""]), encoding="utf-8")
    print(TARGET.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
