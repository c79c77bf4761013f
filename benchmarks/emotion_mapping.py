"""Measure maps between emotions on made-up emotional motion and write docs/tables/emotion_mapping.md.

    python benchmarks/emotion_mapping.py GRID_CORPUS      # a corpus made by `mien corpus import` of grid-s1

No recorded emotional motion with the same sentences ships or is at hand. So that the true change is known, sentences
of grid-s1 are made emotional in several ways (`KINDS`), fixed before any map was tried on them. Both sides are the
same recording, its tracker's noise smoothed away (Gaussian, one frame), said at another pace, each with fresh noise
of 0.3 mm a coordinate. *Another take*: nobody says a sentence twice alike. The emotional side then has 0.8 of the
same motion and 0.6 of another sentence's: that keeps spread and speed, and differs as repetitions of words do in
grid-s1 (1.7 mm, docs/results.md). *Wander*: a random curve of deviation 0.55 mm along the direction of the offset, by
which emotional faces wander more than neutral ones (0.96 and 0.79 mm on the upper face; 1/e after 0.2 s); and, as a
case that real faces are not, one of 2.8 mm.

Sentence by sentence each map is learned from the others; see `mien.motion.maps.emotion_mapping.MappingScore` for the
columns. `best possible` knows the truth: the very change without noise, wander and what another take does by chance.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from mien.core.files import replace_when_complete
from mien.corpus.recordings import Corpus
from mien.corpus.take import Take
from mien.motion.drift import smooth_drift
from mien.motion.maps.emotion_component_maps import SameMap
from mien.motion.maps.emotion_mapping import (
    EmotionMapping,
    MappingScore,
    leave_one_sentence_out,
    score_mapping,
    scores_table,
)

TABLE = Path(__file__).parent.parent / "docs" / "tables" / "emotion_mapping.md"
SENTENCES = 8
FPS = 25
NOISE = 0.3
SIZE = 6.0
DECAY = 0.2
SAME, OTHER = 0.8, 0.6
GAINS = (1.4, 0.8, 1.2)
"""How many times as far the three strongest components of speech move: opened further, rounded and spread less."""
BY_PHONE = {0.4: "P B M F V", 1.4: "AA AE AH AO AW AY EH EY OW", 1.2: "IY IH UW UH ER"}
"""Size of the offset where a phone is said; 1 for all others: lips that must close give way, vowels show it most."""
TEMPO = 0.8

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Kind:
    """One way of making speech emotional."""

    title: str
    truth: str
    gains: tuple[float, ...] = ()
    by_phone: bool = False
    tempo: float = 1.0
    another_take: bool = False
    wander: float = 0.0


OFFSET = "An offset is the whole truth: equalling it is all that can be done."
KINDS = (
    Kind("offset", OFFSET),
    Kind("offset; another take", OFFSET + " But a mean offset knows nothing of chance.", another_take=True),
    Kind("offset, and gains on the components of speech", "The mouth moves 1.4, 0.8 and 1.2 times as far.", GAINS),
    Kind("offset and gains; another take", "As before.", GAINS, another_take=True),
    Kind("offset that differs between phones", "0.4 of it on bilabials to 1.4 on open vowels.", by_phone=True),
    Kind("offset that differs between phones; another take", "As before.", by_phone=True, another_take=True),
    Kind(
        "offset, said in 0.8 of the time with less articulation",
        "Faster, so the mouth undershoots: low-passed (deviation 40 ms) before the time is cut. A map keeps the time "
        "of the source, so it cannot make faster what was said slowly.",
        tempo=TEMPO,
    ),
    Kind("all of it, wandering as real faces do; another take", "", GAINS, True, TEMPO, True, 0.55),
    Kind("offset, wandering far more than real faces do", "2.8 mm that nothing of the source tells.", wander=2.8),
)


def resampled(motion: Floats, places: Floats) -> Floats:
    return np.stack([np.interp(places, np.arange(len(motion)), column) for column in motion.T], axis=1)


def phone_sizes(take: Take, frames: int) -> Floats:
    """Size of the offset at each frame, smoothed over 60 ms, mean 1."""
    by_label = {label: size for size, labels in BY_PHONE.items() for label in labels.split()}
    times = np.arange(frames) / FPS
    sizes = np.ones(frames)
    for phone in take.phones:
        sizes[(times >= phone.start) & (times < phone.end)] = by_label.get(phone.label, 1.0)
    smooth = gaussian_filter1d(sizes, 0.06 * FPS, mode="nearest")
    return np.asarray(smooth / smooth.mean())


class MadeUp:
    """Speech of grid-s1 without its noise, and what is strongest in it."""

    def __init__(self, takes: list[Take], step: int, seed: int) -> None:
        self.takes, self.random = takes, np.random.default_rng(seed)
        rough = [take.markers.positions[:, ::step].reshape(len(take.markers), -1) for take in takes]
        self.plain = [gaussian_filter1d(rows, 1.0, axis=0) for rows in rough]
        rows = np.concatenate([motion - motion.mean(axis=0) for motion in self.plain])
        self.speech = np.linalg.svd(rows, full_matrices=False)[2][: len(GAINS)]
        smooth = np.cumsum(self.random.normal(size=(rows.shape[1] // 3, 3)), axis=0)
        self.direction = ((smooth - smooth.mean(axis=0)) / (smooth - smooth.mean(axis=0)).std()).ravel() / np.sqrt(3)

    def changed(self, number: int, kind: Kind) -> Floats:
        """The same frames with the true change, nothing by chance."""
        motion = self.plain[number]
        middle, centred = motion.mean(axis=0), motion - motion.mean(axis=0)
        if kind.tempo != 1:
            centred = gaussian_filter1d(centred, 0.04 * FPS, axis=0)
        for gain, axis in zip(kind.gains, self.speech, strict=False):
            centred = centred + (gain - 1) * np.outer(centred @ axis, axis)
        sizes = phone_sizes(self.takes[number], len(motion)) if kind.by_phone else np.ones(len(motion))
        return np.asarray(middle + centred + SIZE * sizes[:, None] * self.direction)

    def pair(self, number: int, kind: Kind) -> tuple[Floats, Floats]:
        """Neutral and emotional, positions of shape (frames, markers, 3)."""
        changed = self.changed(number, kind)
        if kind.another_take:
            other = self.changed((number + 1) % len(self.takes), kind)
            other = resampled(other, np.linspace(0, len(other) - 1, len(changed)))
            middle = changed.mean(axis=0)
            changed = middle + SAME * (changed - middle) + OTHER * (other - other.mean(axis=0))
        frames = round(len(changed) * kind.tempo)
        pace = np.linspace(0, len(changed) - 1, frames) + 3 * np.sin(np.linspace(0, np.pi, frames))
        felt = resampled(changed, np.clip(pace, 0, len(changed) - 1))
        if kind.wander:
            drift = smooth_drift(np.arange(frames) / FPS, DECAY, self.random)
            felt = felt + kind.wander * drift[:, None] * self.direction
        return self._noisy(self.plain[number]), self._noisy(felt)

    def _noisy(self, rows: Floats) -> Floats:
        return (rows + self.random.normal(0, NOISE, rows.shape)).reshape(len(rows), -1, 3)


class _Truth(EmotionMapping):
    """Makes the true change of one sentence."""

    change: Floats

    def apply(self, motion: Floats, random: np.random.Generator | None = None) -> Floats:
        return motion + self.change.reshape(motion.shape)


def table(takes: list[Take], kind: Kind) -> str:
    made = MadeUp(takes, 4, seed=0)
    pairs = [made.pair(number, kind) for number in range(len(takes))]
    scores = leave_one_sentence_out(pairs)
    truth = _Truth(SameMap()).fit(pairs)
    best = []
    for number, pair in enumerate(pairs):
        truth.change = made.changed(number, kind) - made.plain[number]
        best.append(score_mapping(truth, pair))
    means = [float(np.mean([getattr(one, field) for one in best])) for field in ("rms", "share", "liveliness")]
    return scores_table(scores | {"best possible": MappingScore(*means)})


def cost(takes: list[Take]) -> str:
    """What learning costs with all markers."""
    pairs = [MadeUp(takes, 1, seed=0).pair(number, KINDS[3]) for number in range(len(takes))]
    began = time.perf_counter()
    learned = EmotionMapping().fit(pairs)
    learning = time.perf_counter() - began
    began = time.perf_counter()
    learned.apply(pairs[0][0])
    applying = time.perf_counter() - began
    seconds = sum(len(a) for a, _ in pairs) / FPS
    components = len(learned.split_.shift)
    return (
        f"All {pairs[0][0].shape[1]} markers, {len(pairs)} sentences of {seconds:.0f} s in all, {components} "
        f"components: learning {learning:.1f} s, "
        f"mapping {applying / (len(pairs[0][0]) / FPS):.4f} s per second of motion."
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("corpus", help="made by 'mien corpus import' of grid-s1")
    parser.add_argument("kind", nargs="?", help="part of the title of one kind: only this is measured, and printed")
    options = parser.parse_args()
    corpus = Corpus(options.corpus)
    step = len(corpus) // (4 * SENTENCES)
    takes = [corpus.take(name) for name in list(corpus.names)[::step]]
    takes = [take for take in takes if np.isfinite(take.markers.positions).all()][:SENTENCES]
    kinds = [kind for kind in KINDS if options.kind is None or options.kind in kind.title]
    told = [" ".join(part.split()) for part in (__doc__ or "").split("\n\n")[2:]]
    parts = ["# Maps between emotions, on made-up emotional motion", "", "\n\n".join(told), ""]
    parts += ["Every fourth marker of 218, 8 sentences. " + cost(takes)]
    for kind in kinds:
        parts += ["", f"## {kind.title}", "", *([kind.truth, ""] if kind.truth else []), table(takes, kind)]
        print("\n".join(parts[-4:]), flush=True)
    if options.kind is None:
        with replace_when_complete(TABLE) as unfinished:
            unfinished.write_text("\n".join(parts) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
