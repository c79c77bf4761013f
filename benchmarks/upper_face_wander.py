"""How much of a tracked upper face's wander is the tracker's noise, on neutral speech of grid-s1.

    python benchmarks/upper_face_wander.py GRID_CORPUS

Prints, over the markers of the group `upper` that do not sit on the skull: the standard deviation of a marker about its
mean over a take (root mean square over markers, three coordinates), its part that is white noise of the tracker (from
second differences: they hold six times the variance of white noise, and hardly any of motion slower than 0.2 s), its
part that follows the pose of the head (least squares on the head's turns and shifts within the take: what the taking
out of the head's motion left behind), and what remains.
"""

from __future__ import annotations

import argparse

import numpy as np

from mien.capture.layouts import load_layout
from mien.corpus.recordings import Corpus

TAKES = 60


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("corpus", help="made by 'mien corpus import' of grid-s1")
    corpus = Corpus(parser.parse_args().corpus)
    parts = []
    for name in list(corpus.names)[:: max(1, len(corpus) // TAKES)]:
        take = corpus.take(name)
        layout = load_layout(take.layout)
        kept = [m for m in layout.groups["upper"] if m not in layout.rigid]
        rows = take.markers.positions[:, [take.markers.names.index(m) for m in kept]]
        if take.head is None or not np.isfinite(rows).all() or not np.isfinite(take.head).all():
            continue
        flat = (rows - rows.mean(axis=0)).reshape(len(rows), -1)
        noise = (np.diff(flat, 2, axis=0) ** 2).mean() / 6
        pose = take.head[:, :3].reshape(len(flat), -1)
        pose = pose - pose.mean(axis=0)
        axes, size, _ = np.linalg.svd(pose, full_matrices=False)
        axes = axes[:, size > 1e-3 * size[0]][:, :6]
        left = flat - axes @ (axes.T @ flat)
        parts.append([(flat**2).mean(), noise, (flat**2).mean() - (left**2).mean(), axes.shape[1] / len(flat)])
    whole, noise, pose, chance = np.mean(parts, axis=0)
    by_chance = chance * whole
    rest = whole - noise - max(pose - by_chance, 0)
    told = {
        "all": whole,
        "white noise": noise,
        "follows the head": max(pose - by_chance, 0.0),
        "remains": max(rest, 0.0),
    }
    print(f"{len(parts)} takes: " + ", ".join(f"{what} {np.sqrt(3 * value):.2f} mm" for what, value in told.items()))
    print(f"share of the variance that remains: {rest / whole:.2f}")


if __name__ == "__main__":
    main()
