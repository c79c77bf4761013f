"""Learn to hear how hard a voice works (NOTICE): acted anger and joy against ordinary speech of several microphones.

    python tools/learn_vocal_effort.py DATA

DATA holds emodb, grid-s1 and facegood-mandarin. Writes src/mien/assets/effort/voice.toml, the same bytes each time.

A logistic regression on three features (`mien.speech.vocal_effort`). How strained an acted emotion is follows from how
far its pitch lies above neutral speech of the same speaker, at .4 semitones for a decibel (Andersson, Eriksson,
Traunmüller 1996), angry speech being 1. Every recording is learned from as it is and with the colours of other
microphones. The answer counts from where strained is likelier than not.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from mien.core.audio import Audio
from mien.formats.sound_files import read_audio
from mien.speech.vocal_effort import FEATURES, FEWEST, effort_features
from mien.speech.voice_features import analyse

TARGET = Path(__file__).parent.parent / "src" / "mien" / "assets" / "effort" / "voice.toml"
ORDINARY = "NLT"  # neutral, bored, sad
SEMITONES = 0.4  # for a decibel
COLOUR, COLOURS = 4.0, 8  # spread of microphones' tilt in dB; copies of each recording
RIDGE, ROUNDS = 1e-2, 60
THRESHOLD = 0.5
GRID_TAKES, SECONDS = 60, 4.0
Floats = NDArray[np.float64]


def main() -> None:
    """Learn and save."""
    rows = list(recordings(Path(sys.argv[1])))
    target = targets(rows)
    features = np.array([[row[2][name] for name in FEATURES] for row in rows])
    goal = np.array([target[kind] for _, kind, _ in rows])
    counts = defaultdict[tuple[str, str], int](int)
    for speaker, kind, _ in rows:
        counts[speaker[:1], kind] += 1
    weight = np.array([1 / counts[speaker[:1], kind] for speaker, kind, _ in rows])
    mean, scale, weights = regression(features, goal, weight)
    strained = 1 / (1 + np.exp(-((features - mean) / scale @ weights[:-1] + weights[-1])))
    over = np.maximum(0, (strained - THRESHOLD) / (1 - THRESHOLD))
    anger = np.array([kind == "W" for _, kind, _ in rows])
    most = pitch_rise(rows, "W") / SEMITONES
    told = {
        name: over[[s[:1] == letter and k in ORDINARY for s, k, _ in rows]] * most / over[anger].mean()
        for name, letter in (("emodb", "e"), ("grid", "g"), ("facegood", "f"))
    }
    ordinary = "; ".join(f"{name} {found.mean():.1f}" for name, found in told.items())
    TARGET.write_text(
        "# How hard a voice works, from its spectrum and pitch. Learned by tools/learn_vocal_effort.py from emodb,\n"
        "# grid-s1 and facegood-mandarin (NOTICE); not made by hand.\n"
        f"# Angry speech lies {most:.1f} dB above ordinary, by its pitch; ordinary speech is heard at (mean, dB):\n"
        f"# {ordinary}.\n"
        f"features = {list(FEATURES)!r}\n".replace("'", '"')
        + f"mean = {mean.round(4).tolist()}\nscale = {scale.round(4).tolist()}\n"
        f"weights = {weights[:-1].round(4).tolist()}\nbias = {weights[-1]:.4f}\n"
        f"ordinary = {THRESHOLD}  # below it nothing is heard\n"
        f"decibels = {most / over[anger].mean():.2f}  # where it is certain\n"
        f"most = {most:.2f}\n",
        encoding="utf-8",
    )
    print(TARGET.read_text(encoding="utf-8"))


def recordings(data: Path):
    """Speaker, kind (letters of emodb; N: ordinary) and features of each recording."""
    found = [(f"e{p.name[:2]}", p.name[5], p) for p in sorted((data / "emodb" / "audio").iterdir())]
    grid = sorted((data / "grid-s1" / "audio").glob("*.flac"))
    found += [("g", "N", p) for p in grid[:: len(grid) // GRID_TAKES]]
    found += [("f", "N", p) for p in sorted((data / "facegood-mandarin" / "audio").glob("*.flac"))]
    for speaker, kind, path in tqdm(found, desc="recordings"):
        sound = read_audio(path)[0]
        length = round(SECONDS * sound.rate)
        starts = range(0, len(sound) - length, 2 * length) if speaker == "f" else [0]
        for start in starts:
            part = Audio(sound.samples[start : start + length], sound.rate) if speaker == "f" else sound
            frames = analyse(part)
            if (frames.active & np.isfinite(frames.semitones)).sum() >= FEWEST:
                yield speaker, kind, effort_features(frames)


def pitch_rise(rows: list, kind: str) -> float:  # type: ignore[type-arg]
    """Semitones by which emodb's speakers speak higher with an emotion than without, their mean."""
    rises = []
    for speaker in sorted({s for s, _, _ in rows if s[0] == "e"}):
        own = [r[2]["pitch"] for r in rows if r[0] == speaker and r[1] == kind]
        plain = [r[2]["pitch"] for r in rows if r[0] == speaker and r[1] == "N"]
        if own and plain:
            rises.append(np.mean(own) - np.mean(plain))
    return float(np.mean(rises))


def targets(rows: list) -> dict[str, float]:  # type: ignore[type-arg]
    """How strained each kind is: 0 to 1."""
    most = pitch_rise(rows, "W")
    kinds = sorted({kind for _, kind, _ in rows})
    return {k: 0.0 if k in ORDINARY else min(1.0, pitch_rise(rows, k) / most) for k in kinds}


def regression(features: Floats, goal: Floats, weight: Floats) -> tuple[Floats, Floats, Floats]:
    """Mean, scale and weights (the last one the bias) of a logistic regression with the colours of microphones."""
    random = np.random.default_rng(0)
    copies = [features]
    for _ in range(COLOURS):
        coloured = features.copy()
        coloured[:, 0] += COLOUR * random.normal(size=len(features))
        copies.append(coloured)
    x, y, w = np.concatenate(copies), np.tile(goal, len(copies)), np.tile(weight, len(copies))
    w = w / w.sum()
    mean, scale = np.average(x, axis=0, weights=w), x.std(axis=0)
    rows = np.concatenate([(x - mean) / scale, np.ones((len(x), 1))], axis=1)
    ridge = np.diag([RIDGE] * features.shape[1] + [1e-6])
    weights = np.zeros(rows.shape[1])
    for _ in range(ROUNDS):
        p = 1 / (1 + np.exp(-rows @ weights))
        slope = (rows * (w * p * (1 - p))[:, None]).T @ rows + ridge
        weights = weights - np.linalg.solve(slope, rows.T @ (w * (p - y)) + ridge @ weights)
    return mean, scale, weights


if __name__ == "__main__":
    main()
