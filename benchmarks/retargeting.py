"""Markers to weights: round trip on two rigs, and real motion on both.

::

    python benchmarks/retargeting.py CORPUS [--takes 12]

writes ``docs/tables/retargeting.md``. CORPUS is grid-s1, imported (``mien corpus import``). The second rig is the
default face in other proportions, with 26 of its shapes, under other part names: what a foreign face is to mien.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from mien.capture.layouts import load_layout
from mien.core.channels import ARKIT
from mien.core.files import replace_when_complete
from mien.corpus.recordings import Corpus
from mien.face.library import load_face
from mien.face.model import Face, Target
from mien.face.rbf_retargeting import RbfRetargeter, sampled_pairs
from mien.face.retargeting import Retargeter, basis_at
from mien.face.retargeting_report import ambiguous_channels, residual_by_region
from mien.motion.marker_motion import RIDGE, STEADINESS, neutral_of, skin_markers, to_face
from mien.motion.mouth.learned_mouth import NOT_BY_MARKERS

DOCS = Path(__file__).parent.parent / "docs"
LAYOUT = "mediapipe-218"
_PAIRED = (
    "eyeBlink", "eyeWide", "browDown", "browOuterUp", "mouthSmile", "mouthFrown", "mouthUpperUp", "mouthLowerDown",
    "mouthStretch", "noseSneer",
)  # fmt: skip
FEW = (
    *(f"{name}{side}" for name in _PAIRED for side in ("Left", "Right")),
    *("browInnerUp", "jawOpen", "mouthFunnel", "mouthPucker", "mouthRollLower", "mouthClose"),
)
Solve = Callable[[np.ndarray], np.ndarray]


def second_rig(face: Face) -> Face:
    """Broader and shorter, a longer chin, shapes a quarter stronger; parts under other names."""

    def bent(points: np.ndarray) -> np.ndarray:
        result = points.astype(np.float64) * [1.15, 0.92, 1.05]
        result[:, 1] -= 0.12 * np.clip(-60 - points[:, 1], 0, 50)
        return result.astype(np.float32)

    parts = []
    for part in face.parts:
        targets = {
            n: Target(t.vertices, t.offsets * np.float32([1.4, 1.15, 1.3])) for n, t in part.targets.items() if n in FEW
        }
        parts.append(replace(part, name=f"rig {part.name}", vertices=bent(part.vertices), targets=targets))
    eyes = tuple(replace(eye, part=f"rig {eye.part}") for eye in face.eyes)
    return replace(face, name="second", parts=tuple(parts), eyes=eyes, sites={})


def solvers(face: Face, sites: tuple, used: tuple[str, ...], basis: np.ndarray, steady: bool) -> dict[str, Solve]:
    """Every method as a function of displacements (frames, markers, 3)."""
    shown, wanted = sampled_pairs(basis, 600, np.random.default_rng(0))
    steadiness = {} if steady else {"steadiness": 0.0}
    found: dict[str, Solve] = {}
    for ridge, change, told in (
        (2e-3, 2e-3, "least squares, ridge 2e-3"),
        (RIDGE, 2e-3, "least squares, hardly steadied"),
        (RIDGE, STEADINESS, "least squares (default)"),
    ):
        solver = Retargeter(face, sites, used, ridge=ridge, steadiness=change if steady else 0.0)
        found[told] = lambda asked, solver=solver: solver.solve(asked, 25).weights
    for told, kernel, variance, ridge in (
        ("RBF with a plane (default)", "linear", 0.99999, 1e-6),
        ("RBF with a plane, 99.9 %", "linear", 0.999, 1e-6),
        ("Gaussian RBF, 97.5 % (paper)", "gaussian", 0.975, 1e-3),
    ):
        learned = RbfRetargeter(kernel, variance, ridge, **steadiness).fit(shown, wanted)
        found[told] = lambda asked, learned=learned: learned.solve(asked, 25)
    return found


def round_trip(face: Face, channels: tuple[str, ...]) -> list[str]:
    layout = load_layout(LAYOUT)
    places = skin_markers(face, layout, layout.markers)
    basis = basis_at(face, places.sites, channels)
    used = tuple(n for n, rows in zip(channels, basis, strict=True) if np.abs(rows).max() > 0.05)
    basis = basis_at(face, places.sites, used)
    single = np.concatenate([weight * np.eye(len(used)) for weight in (0.3, 0.6, 0.9)])
    mixed = sampled_pairs(basis, 300, np.random.default_rng(99))[1][-300:]
    rows = []
    for name, solve in solvers(face, places.sites, used, basis, steady=False).items():
        cells = []
        for asked in (single, mixed):
            error = np.abs(solve(np.einsum("pc,cmk->pmk", asked, basis)) - asked)
            cells.append(f"{error.mean():.4f} / {np.percentile(error, 99):.4f} / {error.max():.3f}")
        rows.append(f"| {face.name} ({len(used)} shapes) | {name} | {' | '.join(cells)} |")
    return rows


def real_motion(face: Face, corpus: Corpus, names: list[str]) -> list[str]:
    layout = load_layout(LAYOUT)
    places = skin_markers(face, layout, corpus.take(names[0]).markers.names)
    wanted = [n for n in ARKIT if n not in NOT_BY_MARKERS and not n.startswith("eyeLook")]
    basis = basis_at(face, places.sites, wanted)
    used = tuple(n for n, rows in zip(wanted, basis, strict=True) if np.abs(rows).max() > 0.05)
    basis = basis_at(face, places.sites, used)
    asked = []
    for name in names:
        motion = corpus.take(name).markers
        columns = [motion.names.index(marker) for marker in places.markers]
        positions, still = motion.positions[:, columns], neutral_of(motion, layout)
        asked.append((positions - positions[still]) @ to_face(positions[still], face, layout, places).T)
    rows = []
    for name, solve in solvers(face, places.sites, used, basis, steady=True).items():
        solve(asked[0])
        start = time.perf_counter()
        weights = [solve(motion) for motion in asked]
        spent = (time.perf_counter() - start) / sum(map(len, asked)) * 1e3
        jitter = np.sqrt(np.mean(np.concatenate([np.diff(w, 2, axis=0).ravel() for w in weights]) ** 2))
        every, reached = np.concatenate(asked), np.einsum("tc,cmk->tmk", np.concatenate(weights), basis)
        regions = residual_by_region(every, reached, places.markers, layout.groups)
        cells = [f"{region.missed:.2f} of {region.asked:.2f}" for region in regions]
        rows.append(f"| {face.name} | {name} | {' | '.join(cells)} | {jitter:.4f} | {spent:.2f} |")
    return rows


def ambiguities(face: Face) -> list[str]:
    layout = load_layout(LAYOUT)
    places = skin_markers(face, layout, layout.markers)
    there = [
        n
        for n in ARKIT
        if any(n in part.targets for part in face.parts) and not n.startswith("eyeLook") and n != "tongueOut"
    ]
    basis = basis_at(face, places.sites, there)
    return [
        f"| {face.name} | {found.channel} | {found.own:.0%} | {', '.join(found.stand_ins)} |"
        for found in sorted(ambiguous_channels(basis, there, 0.2), key=lambda one: one.own)
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("corpus")
    parser.add_argument("--takes", type=int, default=12)
    given = parser.parse_args()
    corpus = Corpus(given.corpus)
    chosen = [corpus.names[n] for n in np.linspace(0, len(corpus) - 1, given.takes).round().astype(int)]
    default = load_face("default")
    faces = (default, second_rig(default))
    channels = tuple(name for name in ARKIT if not name.startswith("eyeLook"))
    lines = [
        "# Retargeting",
        "",
        f"Markers of the layout {LAYOUT} to weights of morph targets. Written by `python benchmarks/retargeting.py`.",
        "RBFs are learned from 600 mixtures and four steps of every shape, drawn from the rig itself.",
        "",
        "## Round trip: markers made from known weights, and back",
        "",
        "Error of a weight (0..1): mean / 99 % below / greatest; frames by themselves. Single shapes at 0.3, 0.6, 0.9;",
        "300 mixtures of one to five shapes that no method has seen.",
        "",
        "| rig | method | single shapes | mixtures |",
        "| --- | --- | --- | --- |",
        *(row for face in faces for row in round_trip(face, channels)),
        "",
        "## Real motion: what the rigs cannot do",
        "",
        f"{len(chosen)} takes of {corpus.folder.name}. Missed of asked motion by region, mm RMS; jitter: RMS of a",
        "weight's second difference from frame to frame; ms a frame, whole takes at once.",
        "",
        "| rig | method | mouth | upper face | lower face | jitter | ms |",
        "| --- | --- | --- | --- | --- | --- | --- |",
        *(row for face in faces for row in real_motion(face, corpus, chosen)),
        "",
        "## Shapes that the markers hardly tell apart",
        "",
        "Share of a shape's motion at the markers that no mixture of the others makes; below 20 %.",
        "",
        "| rig | shape | its own | others that do most of it |",
        "| --- | --- | --- | --- |",
        *(row for face in faces for row in ambiguities(face)),
    ]
    with replace_when_complete(DOCS / "tables" / "retargeting.md") as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
