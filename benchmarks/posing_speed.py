"""How long posing with normals takes, beside a dense matrix product and the bound that memory sets, in one run.

    python benchmarks/posing_speed.py [--frames 60]

writes ``docs/tables/posing.md``. The *dense product* is what posing without sparse targets costs: weights times a
matrix of all offsets (channels x 3 vertices, float32, BLAS), and then our normals of all vertices. The *bound* is the
least that memory lets any method do: every offset of an active target read once, rest and triangles read, vertices and
normals written, at the bandwidth that copying a large array reaches here. One thread each; what is compared takes
turns, some frames each, and of all its frames the 20th percentile counts, since other work on the machine only adds.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from render_speed import finer, motion, vertices
from threadpoolctl import threadpool_limits

from mien.core.channels import ALL, HEAD
from mien.core.files import replace_when_complete
from mien.face.deformers import deformed_by
from mien.face.library import load_face
from mien.face.model import Face
from mien.face.normals import ring_normals, rings_of
from mien.face.posing import Poser
from mien.face.tree_posing import TreePoser

TABLE = Path(__file__).parent.parent / "docs" / "tables" / "posing.md"
WARM, TURN = 2, 12  # frames
HIDDEN = ("hair", "hair_clumps", "shirt", "brows", "caruncles")


def typical_ms(frames: int, *works: Callable[[int], object]) -> list[float]:
    """Of each work the processor milliseconds for a frame; by turns, so that what else happens meets all alike."""
    spent: list[list[float]] = [[] for _ in works]
    for first in range(0, frames, TURN):
        for work, times in zip(works, spent, strict=True):
            for frame in [first] * WARM + list(range(first, min(first + TURN, frames))):
                begin = time.thread_time()
                work(frame)
                times.append(time.thread_time() - begin)
    return [float(1000 * np.percentile(times, 20)) for times in spent]


def bandwidth() -> float:
    """Bytes per millisecond that copying moves (read and written), best of many."""
    source, goal = np.ones(1 << 25, np.float32), np.empty(1 << 25, np.float32)
    best = min(typical_ms(5, lambda _: np.copyto(goal, source))[0] for _ in range(3))
    return 2 * source.nbytes / best


def dense_matrix(face: Face, names: tuple[str, ...]) -> np.ndarray:
    """All offsets, (channels, 3 vertices), float32."""
    starts = np.cumsum([0, *(len(part.vertices) for part in face.parts)])
    matrix = np.zeros((len(names), starts[-1], 3), np.float32)
    for part, start in zip(face.parts, starts, strict=False):
        for row, name in enumerate(names):
            if name in part.targets:
                matrix[row, start + part.targets[name].vertices] += part.targets[name].offsets
    return matrix.reshape(len(names), -1)


def bytes_touched(face: Face, active: set[str]) -> int:
    offsets = sum(len(t.vertices) for part in face.parts for name, t in part.targets.items() if name in active)
    points, triangles = vertices(face), sum(len(part.triangles) for part in face.parts)
    return 12 * offsets + 3 * 12 * points + 12 * triangles


def rows_of(active: int, frames: int) -> np.ndarray:
    """Lively rows in which so many channels are at work, the first ones of a fixed draw."""
    rows = motion(frames)
    kept = np.random.default_rng(3).permutation(len(ALL) - len(HEAD))[:active]
    rows[:, np.setdiff1d(np.arange(len(ALL) - len(HEAD)), kept)] = 0.0
    rows[:, kept] = np.maximum(rows[:, kept], 0.05)
    return rows


def measured(face: Face, active: int, frames: int, speed: float) -> tuple[float, float, float, float]:
    """Milliseconds of posing with normals, of all normals, of the dense product, and the bound."""
    rows, names = rows_of(active, frames), tuple(name for name in ALL if name not in HEAD)
    poser, matrix = Poser(face, ALL), dense_matrix(face, names)
    weights = rows[:, [ALL.index(name) for name in names]].astype(np.float32)
    posed, surface = np.concatenate([part.vertices for part in poser.pose(rows[0]).parts]), poser._surface
    rings, made = rings_of(surface.triangles, surface.welded), np.empty_like(posed)
    ours, dense, normals = typical_ms(
        frames,
        lambda frame: poser.pose(rows[frame]),
        lambda frame: weights[frame] @ matrix,
        lambda _: ring_normals(posed, rings.vertex, rings.start, rings.points, rings.twins, made),
    )
    at_work = {name for name, weight in zip(names, weights[0], strict=True) if weight}
    return ours, normals, dense, bytes_touched(face, at_work) / speed


def report(frames: int) -> list[str]:
    default, speed = load_face(), bandwidth()
    bare = replace(default, parts=tuple(part for part in default.parts if part.name not in HIDDEN))
    count = len(ALL) - len(HEAD)
    head = [
        "vertices",
        "shapes at work",
        "posing + normals, ms",
        "dense product, ms",
        "normals of all, ms",
        "times faster",
    ]
    head += ["times faster with normals", "bound, ms"]
    lines = [
        "# Posing",
        "",
        "Written by `python benchmarks/posing_speed.py`; processor milliseconds per frame, one thread; memory copies "
        f"at {speed / 1e6:.1f} GB/s;",
        f"other work on the machine: {os.getloadavg()[0]:.1f} processes, of {os.cpu_count()} cores.",
        "The dense product makes no normals; *with normals* adds ours, of all vertices. The bound moves every byte",
        "once at that speed; what fits a large cache can be faster.",
        "",
        f"| {' | '.join(head)} |",
        "|" + " ---: |" * len(head),
    ]
    cases = [(bare, count), (default, count), (finer(bare), count), (finer(default), count)]
    cases += [(bare, active) for active in (5, 20, 40)]
    for face, active in cases:
        ours, normals, dense, bound = measured(face, active, frames, speed)
        cells = [f"{vertices(face):,}", f"{active}", f"{ours:.2f}", f"{dense:.2f}", f"{normals:.2f}"]
        cells += [f"{dense / ours:.1f}", f"{(dense + normals) / ours:.1f}", f"{bound:.2f}"]
        lines.append(f"| {' | '.join(cells)} |")
    rows, by_tree = rows_of(count, frames), deformed_by(bare, "tree")
    tree = TreePoser(by_tree, ALL)
    [spent] = typical_ms(frames, lambda frame: tree.pose(rows[frame]))
    lines += ["", f"By the parameter tree ({vertices(bare):,} vertices, all shapes at work): {spent:.2f} ms."]
    begin = time.perf_counter()
    deformed_by(default, "regions")
    lines += [f"Making the face by regions: {time.perf_counter() - begin:.1f} s, once."]
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--frames", type=int, default=60, help="frames to measure over (default 60)")
    frames = parser.parse_args().frames
    with threadpool_limits(1):
        lines = report(frames)
    with replace_when_complete(TABLE) as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
