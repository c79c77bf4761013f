"""What heads of very many vertices cost: processor seconds and memory of the commands that read and write them.

::

    python benchmarks/large_heads.py [--rounds 2 3]

writes ``docs/tables/large_heads.md``. The heads are one of the space of heads whose triangles are cut into four two or
three times (245 thousand and a million vertices).
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from mien.core.files import replace_when_complete
from mien.face.head_space import head_space
from mien.face.surface import edges_of

TABLE = Path(__file__).parent.parent / "docs" / "tables" / "large_heads.md"
ABOUT = """# Heads of very many vertices

Written by `python benchmarks/large_heads.py`. Each command is a process of its own: clock and processor
seconds, and the most memory it held (MB). The line spoken is "I never said that." (about one second); the film
is 640x360.

| vertices | command | clock s | processor s | memory MB |
| --- | --- | --- | --- | --- |
"""


def head(rounds: int) -> tuple[np.ndarray, np.ndarray]:
    """A head of the space, mm, its triangles cut into four so many times."""
    space = head_space()
    points, triangles = space.shape(np.random.default_rng(3).normal(0, 1, 30)), space.triangles.astype(np.int64)
    for _ in range(rounds):
        edges = edges_of(triangles)
        code, count = edges[:, 0].astype(np.int64) * len(points) + edges[:, 1], len(points)
        sides = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2)
        a, b, c = triangles.T
        ab, bc, ca = (count + np.searchsorted(code, sides[:, k, 0] * count + sides[:, k, 1]) for k in range(3))
        points = np.vstack([points, points[edges].mean(axis=1)])
        parts = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
        triangles = np.concatenate([np.stack(part, axis=1) for part in parts])
    return points, triangles


def write_ply(path: Path, points: np.ndarray, triangles: np.ndarray) -> None:
    """A binary PLY."""
    rows = np.zeros(len(triangles), dtype=[("n", "u1"), ("v", "<i4", 3)])
    rows["n"], rows["v"] = 3, triangles
    counts = f"element vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
    lists = f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    text = f"ply\nformat binary_little_endian 1.0\n{counts}{lists}"
    path.write_bytes(text.encode() + points.astype("<f4").tobytes() + rows.tobytes())


def measured(arguments: list[str]) -> tuple[float, float, float, int]:
    """Clock and processor seconds, MB, and exit status of a mien command."""
    start = time.perf_counter()
    process = os.posix_spawn(sys.executable, [sys.executable, "-m", "mien", *arguments], os.environ)
    _, status, usage = os.wait4(process, 0)
    megabytes = usage.ru_maxrss / 1024
    return time.perf_counter() - start, usage.ru_utime + usage.ru_stime, megabytes, os.waitstatus_to_exitcode(status)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, nargs="+", default=[2, 3])
    rows = []
    for rounds in parser.parse_args().rounds:
        with tempfile.TemporaryDirectory() as there:
            folder = Path(there)
            points, triangles = head(rounds)
            write_ply(folder / "head.ply", points, triangles)
            line = ["say", "I never said that.", "--face"]
            film = ["--size", "640x360"]
            for told, command in {
                "face fit HEAD.ply -o FACE.npz": ["face", "fit", "head.ply", "-o", "face.npz", "--also", "face.glb"],
                "face inspect FACE.glb": ["face", "inspect", "face.glb"],
                "say … --face FACE.npz -o LINE.glb": [*line, "face.npz", "-o", "line.glb"],
                "say … --face FACE.glb -o LINE.glb": [*line, "face.glb", "-o", "driven.glb"],
                "say … --face FACE.npz -o LINE.mp4": [*line, "face.npz", "-o", "line.mp4", *film],
                "say … --face FACE.glb -o LINE.mp4": [*line, "face.glb", "-o", "driven.mp4", *film],
            }.items():
                full = [
                    str(folder / word) if word.endswith((".npz", ".glb", ".ply", ".mp4")) else word for word in command
                ]
                clock, processor, megabytes, code = measured(full)
                if code:
                    told += f" (ended with {code})"
                rows.append(f"| {len(points)} | `{told}` | {clock:.0f} | {processor:.0f} | {megabytes:.0f} |")
                print(rows[-1], flush=True)
                with replace_when_complete(TABLE) as unfinished:  # after each, for these are long runs
                    unfinished.write_text(ABOUT + "\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
