"""What capture finds again of channels that are known, and what the default face shows of recordings.

::

    python benchmarks/capture.py CORPUS [--takes 60] [--tracked 2] [-o docs/tables/capture.md]

CORPUS is grid-s1, imported (``mien corpus import``). ``--tracked N`` also draws N recorded takes and
performances of another head and sends the pictures through the real tracker (``mien tracker install``); 0: not.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mien import say
from mien.capture.capture import capture_take
from mien.capture.knowledge import knowledge
from mien.capture.layouts import Layout, load_layout
from mien.capture.person import fit_person
from mien.capture.tracker import shared_tracker
from mien.core.channels import WEIGHTS
from mien.core.files import replace_when_complete
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from mien.corpus.capturing import people_of
from mien.corpus.readers.raw_recordings import Raw
from mien.corpus.recipes import load_recipe
from mien.corpus.recordings import Corpus
from mien.corpus.reference_frame import reference_of, settled
from mien.face.head_reshaping import reshaped_face
from mien.face.head_space import head_space
from mien.face.library import load_face
from mien.face.marker_sites import place_markers
from mien.face.model import Face
from mien.face.posing import Poser
from mien.face.render.camera import Camera
from mien.face.render.renderer import Renderer
from mien.face.retargeting import basis_at

DOCS = Path(__file__).parent.parent / "docs"
RATE = FrameRate.of(25)
HEADS, REST, DRAWN = 6, 25, 1
MOVING = 0.05  # standard deviation of a channel that counts
SPOKEN = (
    ("We will be there at seven.", None),
    ("Please move four blue boxes by the window.", "happy"),
    ("She showed us how to bake the cheese.", "sad"),
    ("Who took my fresh orange juice?", "angry"),
    ("Every thought was wrong about the weather.", "surprised"),
    ("Pop up and wave, you fool!", "disgusted"),
)
EYES_MM = 90.0
MEASURES = ("lip opening", "mouth width", "inner brow", "lid gap")


@dataclass(frozen=True)
class Seen:
    """A head and where markers go on it."""

    face: Face
    places: np.ndarray
    basis: np.ndarray

    @classmethod
    def of(cls, face: Face, layout: Layout) -> Seen:
        placed = place_markers(face, layout)
        return cls(face, placed.places, basis_at(face, placed.sites, WEIGHTS))


def made_head(seed: int) -> Face:
    """A head of the space, drawn by its own probabilities."""
    space = head_space()
    return reshaped_face(space, space.shape(np.random.default_rng(seed).normal(size=20)), f"head {seed}").face


def performances() -> list[np.ndarray]:
    """Weights of six sentences in six emotions, with rest before each: ARKit alone, no two antagonists at once."""
    sought, found = knowledge().channels["tracker"], []
    for text, emotion in SPOKEN:
        animation = say(text, emotion=emotion, performer="hand-made", fps=RATE.fps, seed=1, prosody=0)
        weights = np.clip(animation.channels.select(WEIGHTS).values, 0, 1)
        weights[:, [i for i, name in enumerate(WEIGHTS) if name not in sought]] = 0
        for one, other in knowledge().antagonists:
            pair = [WEIGHTS.index(one), WEIGHTS.index(other)]
            weights[:, pair] -= weights[:, pair].min(axis=1, keepdims=True)
        found.append(np.concatenate([np.zeros((REST, len(WEIGHTS))), weights]))
    return found


def as_seen(head: Seen, weights: np.ndarray, depth: float, noise: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Markers of a performance as a source reports them: depth flattened, noise on top."""
    moved = np.einsum("tk,kmc->tmc", weights, head.basis) * [1.0, 1.0, depth]
    return head.places + moved + rng.normal(size=moved.shape) * noise


def known(layout: Layout, source: str, depth: float, noise: np.ndarray, plays: Sequence[np.ndarray]) -> list[str]:
    """Rows: what was found again on heads that are not the default."""
    rng, truths, founds = np.random.default_rng(0), [], []
    for seed in range(HEADS):
        head = Seen.of(made_head(seed), layout)
        tracks = [MarkerTrack(layout.markers, as_seen(head, play, depth, noise, rng), RATE) for play in plays]
        person = fit_person(tracks[:1], layout, source)
        values = [capture_take(track, layout, head=person).channels.values for track in tracks]
        truths.append(np.concatenate([play[REST:] for play in plays]))
        founds.append(np.concatenate([value[REST:] for value in values]))
    return compared(np.array(truths), np.array(founds))


def compared(truths: np.ndarray, founds: np.ndarray) -> list[str]:
    """Rows of channels by how far they move: correlation and gain (slope of found on true), over all and by head."""
    rows, good = [], []
    spread = truths.std(axis=(0, 1))
    for number in np.argsort(-spread):
        if spread[number] < MOVING:
            break
        true, got = truths[:, :, number], founds[:, :, number]
        r, gain = np.corrcoef(true.ravel(), got.ravel())[0, 1], slope(true, got)
        worst = min(np.corrcoef(t, g)[0, 1] for t, g in zip(true, got, strict=True))
        gains = [slope(t, g) for t, g in zip(true, got, strict=True)]
        good.append((r >= 0.9, 0.9 <= gain <= 1.1))
        rows.append(
            f"| {WEIGHTS[number]} | {spread[number]:.2f} | {r:.3f} | {worst:.3f} | {gain:.2f} | "
            f"{min(gains):.2f}-{max(gains):.2f} |"
        )
    both = 0.0
    for one, other in knowledge().antagonists:
        pair = founds[:, :, [WEIGHTS.index(one), WEIGHTS.index(other)]]
        both = max(both, float(pair.min(axis=2).max()))
    idle = [n for n in range(len(WEIGHTS)) if spread[n] == 0]
    top = good[:24]
    return [
        f"Of the 24 channels that move most, {sum(r for r, _ in top)} have r of .90 or more and "
        f"{sum(g for _, g in top)} a gain of .9 to 1.1; of all {len(good)} that move, {sum(r for r, _ in good)} and "
        f"{sum(g for _, g in good)}. Of two antagonists the weaker one is {both:.3f} at most. Channels that never "
        f"moved are found at {founds[:, :, idle].mean():.4f} in the mean.",
        "",
        "| channel | spread | r | r, worst head | gain | gain, head by head |",
        "| --- | --- | --- | --- | --- | --- |",
        *rows,
    ]


def slope(true: np.ndarray, got: np.ndarray) -> float:
    """Of found on true."""
    return float(np.cov(true.ravel(), got.ravel())[0, 1] / true.var(ddof=1))


# ------------------------------------------------------------------ what is shown of recordings


def measures(positions: np.ndarray, layout: Layout) -> dict[str, np.ndarray]:
    """Distances over time, mm of a face with 90 mm between the outer corners of the eyes; depth left out."""
    at = {number: layout.markers.index(name) for number, name in layout.landmarks.items()}

    def across(one: int, other: int) -> np.ndarray:
        return np.linalg.norm((positions[:, at[one]] - positions[:, at[other]])[:, :2], axis=1)

    size = EYES_MM / np.median(across(33, 263))
    brow = np.mean([positions[:, at[n], 1] for n in (55, 285)], axis=0)
    values = (across(13, 14), across(61, 291), brow, (across(159, 145) + across(386, 374)) / 2)
    return {name: size * value for name, value in zip(MEASURES, values, strict=True)}


def shown(weights: np.ndarray, head: Seen) -> np.ndarray:
    """Markers on a face that performs, (frames, markers, 3)."""
    return np.asarray(head.places + np.einsum("tk,kmc->tmc", weights, head.basis))


def agreement(pairs: Sequence[tuple[dict[str, np.ndarray], dict[str, np.ndarray]]]) -> list[str]:
    """Rows: how far one motion follows another, means over takes."""
    rows = [
        "| | r | r of the velocity | spread | error, mm | recorded spread, mm |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for name in MEASURES:
        found = []
        for recorded, face in pairs:
            x, y = recorded[name], face[name]
            good = np.isfinite(x) & np.isfinite(y)
            x, y = x[good], y[good]
            apart = (y - y.mean()) - (x - x.mean())
            found.append(
                (
                    np.corrcoef(x, y)[0, 1],
                    np.corrcoef(np.diff(x), np.diff(y))[0, 1],
                    y.std() / x.std(),
                    apart.std(),
                    x.std(),
                )
            )
        r, speed, spread, error, size = np.mean(found, axis=0)
        rows.append(f"| {name} | {r:.3f} | {speed:.3f} | {spread:.2f} | {error:.2f} | {size:.2f} |")
    return rows


def captured(corpus: Corpus, name: str) -> tuple[MarkerTrack, np.ndarray]:
    """Markers of a take, and its weights by the solver as it is now."""
    person = people_of(corpus)[corpus.entries[name]["speaker"]]
    markers = corpus.motion(name)[0]
    return markers, capture_take(markers, person.layout, head=person, spoken=True).channels.values


def recordings(corpus: Corpus, count: int) -> list[str]:
    """Rows for real takes on the default face, and how far lips stand apart where they were shut."""
    layout = load_layout(str(corpus.about["layout"]))
    head = Seen.of(load_face("default"), layout)
    pairs, apart = [], []
    for name in corpus.names[:: max(1, len(corpus) // count)][:count]:
        markers, weights = captured(corpus, name)
        recorded = measures(markers.positions, layout)
        face = measures(shown(weights, head), layout)
        pairs.append((recorded, face))
        shut = recorded["lip opening"] < 0.75
        rest = measures(head.places[None], layout)["lip opening"]
        apart.append(face["lip opening"][shut] - rest)
    open_lips = np.concatenate(apart)
    told = (
        f"Where the recording is shut (below .75 mm), the face's lips stand {np.median(open_lips):+.2f} mm apart "
        f"against its rest in the median, {np.quantile(open_lips, 0.99):+.2f} at the 99th percentile "
        f"({len(open_lips)} frames)."
    )
    return [f"{len(pairs)} takes.", "", *agreement(pairs), "", told]


# ------------------------------------------------------------------ through the real tracker


def tracked(face: Face, weights: np.ndarray, side: int = 512) -> MarkerTrack:
    """A face that performs, drawn and tracked, cleaned as an import does."""
    poser, renderer = Poser(face, WEIGHTS), Renderer(face, side, side, Camera.head_shot(face, 1.0))
    points = shared_tracker().landmarks(renderer.render(poser.pose(row)) for row in weights)
    recipe, layout = load_recipe("grid"), load_layout("mediapipe-218")
    numbers = {name: number for number, name in layout.landmarks.items()}
    track = MarkerTrack(layout.markers, points[:, [numbers[marker] for marker in layout.markers]], RATE)
    raw = Raw(track, "pixels")
    return settled(raw, recipe, layout, reference_of(raw, recipe, layout, "drawn"), "drawn").track


def through_tracker(corpus: Corpus, count: int, plays: Sequence[np.ndarray]) -> list[str]:
    """Rows: performances drawn and tracked; recorded takes performed, drawn, tracked, compared with the recording."""
    layout = load_layout("mediapipe-218")
    truths, founds = [], []
    for face in (made_head(DRAWN),):
        tracks = [tracked(face, play) for play in plays]
        person = fit_person(tracks[:1], layout)
        values = [capture_take(track, layout, head=person).channels.values[REST:] for track in tracks]
        truths.append(np.concatenate([play[REST:] for play in plays]))
        founds.append(np.concatenate(values))
    pairs = []
    for name in corpus.names[:: max(1, len(corpus) // count)][:count]:
        markers, weights = captured(corpus, name)
        again = tracked(load_face("default"), weights)
        pairs.append((measures(markers.positions, layout), measures(again.positions, layout)))
    return [
        f"{len(plays)} of the performances on head {DRAWN}, drawn (512 x 512) and tracked:", "",
        *compared(np.array(truths), np.array(founds)), "",
        f"{len(pairs)} recorded takes, performed by the default face, drawn, tracked and compared with the recording's "
        "own track:", "", *agreement(pairs),
    ]  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("corpus", type=Path)
    parser.add_argument("--takes", type=int, default=60)
    parser.add_argument("--tracked", type=int, default=2)
    parser.add_argument("-o", "--output", type=Path, default=DOCS / "tables" / "capture.md")
    options = parser.parse_args()
    corpus = Corpus(options.corpus)
    plays = performances()
    noise = np.median(next(iter(people_of(corpus).values())).noise, axis=0)
    lines = [
        "# Capture: channels found again, and recordings shown", "",
        "Written by `python benchmarks/capture.py CORPUS`. Gain is the slope of found on true; spread is shown over "
        "recorded.", "",
        "## Known channels, as a tracker sees them", "",
        f"{len(plays)} sentences in six emotions, performed by {HEADS} heads of the space of heads, seen as "
        f"mediapipe-218 with a tenth of the motion in depth and noise of {noise[0]:.2f}, {noise[1]:.2f}, "
        f"{noise[2]:.2f} mm along x, y, z (measured on the corpus). The head, its neutral face and its "
        "shapes are not known to the solver.", "",
        *known(load_layout("mediapipe-218"), "tracker", 0.1, noise, plays), "",
        "## The same as optical markers (face-102, full depth, noise .1 mm)", "",
        *known(load_layout("face-102"), "optical", 1.0, np.full(3, 0.1), plays), "",
        "## Recordings on the default face", "",
        "Landmarks on the posed default face against the recorded ones, both with 90 mm between the eyes' outer "
        "corners.", "",
        *recordings(corpus, options.takes),
    ]  # fmt: skip
    if options.tracked:
        lines += ["", "## Through the real tracker", "", *through_tracker(corpus, options.tracked, plays[:2])]
    with replace_when_complete(options.output) as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
