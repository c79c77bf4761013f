"""How long a frame takes: posing, rendering, encoding; and how that grows with vertices and with pixels.

    python benchmarks/render_speed.py [--frames 90]

writes ``docs/tables/rendering.md``. "Wall" is the time that passes, "processor" what all cores together spend on it: on
a machine that others use too, the latter tells more. The median over the frames is given; the first frames, in which
kernels are compiled or loaded, are left out. *To MP4* poses, draws and encodes as ``mien say -o line.mp4`` does, the
encoder in a thread of its own.
"""

from __future__ import annotations

import argparse
import os
import platform
import tempfile
import time
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import numpy as np

from mien.core.audio import Audio
from mien.core.channels import ALL
from mien.core.files import replace_when_complete
from mien.face.library import load_face
from mien.face.model import Face, Part, Target
from mien.face.posing import Poser
from mien.face.render.renderer import Renderer
from mien.formats.drawn_frames import drawn_rows
from mien.formats.video import write_frames

TABLE = Path(__file__).parent.parent / "docs" / "tables" / "rendering.md"
WARM = 3
FPS = Fraction(30)


def motion(frames: int) -> np.ndarray:
    """Smooth, lively channel values, shape (frames, channels): every channel at work, the head turning a little."""
    rng = np.random.default_rng(1)
    t = np.arange(frames)[:, None] / float(FPS)
    waves = np.sin(2 * np.pi * (rng.uniform(0.3, 3, len(ALL)) * t + rng.uniform(size=len(ALL))))
    values = np.clip(0.15 + 0.25 * waves, 0, 1)
    values[:, [ALL.index(name) for name in ("headYaw", "headPitch", "headRoll")]] = 8 * waves[:, -3:]
    return values


def timed(work: Callable[[int], object], frames: int) -> tuple[float, float]:
    """Median milliseconds of ``work(frame)``: wall, processor."""
    spent = []
    for frame in range(frames):
        wall, processor = time.perf_counter(), time.process_time()
        work(frame)
        spent.append((time.perf_counter() - wall, time.process_time() - processor))
    wall, processor = 1000 * np.median(spent[WARM:], axis=0)
    return float(wall), float(processor)


def split_finer(part: Part) -> Part:
    """Every triangle in four, at the middles of its edges; targets go along."""
    pairs = np.sort(part.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, which = np.unique(pairs, axis=0, return_inverse=True)
    count = len(part.vertices)
    a, b, c = part.triangles.T
    ab, bc, ca = which.reshape(-1, 3).T + count
    triangles = np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])

    def with_middles(values: np.ndarray) -> np.ndarray:
        return np.concatenate([values, values[edges].mean(axis=1)]).astype(np.float32)

    def target(old: Target) -> Target:
        moved = np.zeros((count, 3), np.float32)
        moved[old.vertices] = old.offsets
        moved = with_middles(moved)
        kept = np.flatnonzero(moved.any(axis=1))
        return Target(kept.astype(np.int32), moved[kept])

    return Part(
        part.name,
        with_middles(part.vertices),
        triangles.astype(np.int32),
        with_middles(part.uv),
        with_middles(part.colours),
        part.material,
        with_middles(part.head_weight),
        {name: target(old) for name, old in part.targets.items()},
    )


def finer(face: Face) -> Face:
    return Face(
        face.name, tuple(map(split_finer, face.parts)), face.eyes, face.head_pivot, dict(face.sites), face.licence
    )


def measure(face: Face, width: int, height: int, rows: np.ndarray) -> dict[str, tuple[float, float]]:
    poser, renderer = Poser(face, ALL), Renderer(face, width, height)
    poses = [poser.pose(row) for row in rows]
    return {
        "pose": timed(lambda frame: poser.pose(rows[frame]), len(rows)),
        "render": timed(lambda frame: renderer.render(poses[frame]), len(rows)),
    }


def encoding(pictures: list[np.ndarray]) -> tuple[float, float]:
    height, width = pictures[0].shape[:2]
    sound = Audio(np.random.default_rng(0).normal(0, 0.05, round(len(pictures) / FPS * 16000)), 16000)
    with tempfile.TemporaryDirectory() as folder:
        wall, processor = time.perf_counter(), time.process_time()
        write_frames(iter(pictures), FPS, sound, Path(folder) / "a.mp4", (width, height))
        spent = time.perf_counter() - wall, time.process_time() - processor
    return tuple(1000 * each / len(pictures) for each in spent)  # type: ignore[return-value]


def whole(face: Face, rows: np.ndarray, width: int, height: int) -> tuple[float, float]:
    """Pose, render and encode as `mien.formats.video.write_video` does: a picture on each core, the encoder beside."""
    poser, renderer = Poser(face, ALL), Renderer(face, width, height)
    sound = Audio(np.random.default_rng(0).normal(0, 0.05, round(len(rows) / FPS * 16000)), 16000)
    renderer.render(poser.pose(rows[0]))
    with tempfile.TemporaryDirectory() as folder:
        wall, processor = time.perf_counter(), time.process_time()
        pictures = drawn_rows(rows, poser, renderer)
        write_frames(pictures, FPS, sound, Path(folder) / "a.mp4", (width, height))
        spent = time.perf_counter() - wall, time.process_time() - processor
    return tuple(1000 * each / len(rows) for each in spent)  # type: ignore[return-value]


def vertices(face: Face) -> int:
    return sum(len(part.vertices) for part in face.parts)


def table(title: str, head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = [f"### {title}", "", "| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows), ""])


def cells(*pairs: tuple[float, float]) -> tuple[str, ...]:
    return tuple(f"{each:.1f}" for pair in pairs for each in pair)


def report(frames: int) -> str:
    before = os.getloadavg()[0]
    face, rows = load_face("default"), motion(frames)
    parts = measure(face, 1280, 720, rows)
    poser, renderer = Poser(face, ALL), Renderer(face)
    parts["encode"] = encoding([renderer.render(poser.pose(row)) for row in rows])
    parts["to MP4"] = whole(face, rows, 1280, 720)
    steps = [(name, *cells(pair), f"{1000 / pair[0]:.0f}") for name, pair in parts.items()]
    sizes = []
    for width, height in ((640, 360), (1280, 720), (1920, 1080)):
        drawn, filmed = measure(face, width, height, rows)["render"], whole(face, rows, width, height)
        sizes.append((f"{width} x {height}", *cells(drawn, filmed), f"{1000 / filmed[0]:.0f}"))
    growth = []
    for each in (face, finer(face)):
        result = measure(each, 1280, 720, rows)
        growth.append((f"{vertices(each):,}", *cells(result["pose"], result["render"])))
    title = f"Default face, {vertices(face):,} vertices, 1280 x 720, {os.cpu_count()} cores, {platform.machine()}"
    both = ("wall ms", "processor ms")
    return "\n".join(
        [
            "# Drawing",
            "",
            f"Written by `python benchmarks/render_speed.py`; {frames} frames; other work on the machine: "
            f"{before:.1f} processes before, of {os.cpu_count()} cores.",
            "",
            table(title, ("step, per frame", *both, "frames/s"), steps),
            table(
                "By size", ("pixels", "wall ms", "processor ms", "to MP4: wall ms", "processor ms", "frames/s"), sizes
            ),
            table("By vertices", ("vertices", *(f"{s} {b}" for s in ("pose", "render") for b in both)), growth),
        ]
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--frames", type=int, default=90, help="frames to measure over (default 90)")
    options = parser.parse_args()
    if options.frames <= WARM:
        parser.error(f"--frames is more than {WARM}, the frames that are left out")
    text = report(options.frames)
    print(text)
    with replace_when_complete(TABLE) as unfinished:
        unfinished.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
