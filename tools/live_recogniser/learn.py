"""Learns the recogniser: from data to src/mien/assets/live/recogniser.npz in one command.

    npm pack kokoro-js@1.2.1
    pip install jax==0.6.2
    python tools/live_recogniser/learn.py kokoro-js-1.2.1.tgz DATA WORK          about half an hour on one core

It goes on from the acoustic model of the recogniser hama (Apache-2.0, a dependency of mien): a conformer of 1.2 million
weights that knows many real voices and says which phones there are, but hardly when. Here its blocks get a head that
judges every 10 ms, and all of it learns on, slowly, what phone is being said at each moment, with the sound cut off at
any time, in noise and other voices.

DATA holds grid-s1 and emodb (two of its ten speakers are held out to watch the learning by). Speech of synthetic voices
is made first (`speak.py`) and a third of GRID is aligned; both are kept in WORK, so that the work can be stopped and
taken up again. timit-sample is never read here: it is what the result is measured on (``benchmarks/live.py``,
``noise.py``). Every recording comes in a new variation (`variations.py`) in each round, so that the network hears more
voices, microphones, rooms and noises than there are.
"""

from __future__ import annotations

import os

os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import acoustic_model
import jax
import jax.numpy as jnp
import numpy as np
import speak
from numpy.typing import NDArray
from variations import RATE, Line, varied

from mien.core.utterance import PAUSE
from mien.formats.sound_files import read_audio
from mien.speech.align import align
from mien.speech.frame_classifier import FrameClassifier
from mien.speech.streaming_features import BANDS, HOP, WINDOW, StreamingFeatures
from mien.text.phones import phone_table

ROOT = Path(__file__).parents[2]
LABELS = (PAUSE, *sorted(phone_table()))
HELD_OUT = ("08", "15")  # speakers of EmoDB: a woman, a man
LINES = 285
SEGMENT, BATCH = 200, 8  # rows; segments
HEAD_RATE, BLOCKS_RATE, WARM = 1.2e-3, 2.4e-4, 60
SMOOTHING, STEEPEST = 0.05, 2.0
CLOSURES, EARLY, LATE = 1.5, 0.3, 2.0
"""What a row of /p b m/ counts; the first 20 rows of a segment, whose past is missing; the last 30, whose future is."""

Single = NDArray[np.float32]
Weights = dict[str, Any]


def main() -> None:
    """Learn, and write the network after each round."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("package", help="kokoro-js-1.2.1.tgz, which carries the voices' style vectors")
    parser.add_argument("data", type=Path, help="folder of grid-s1 and emodb")
    parser.add_argument("work", type=Path, help="folder for what is made on the way")
    parser.add_argument("--lines", type=int, default=LINES, help=f"of synthetic speech (default {LINES})")
    parser.add_argument("--rounds", type=int, default=8, help="variations of everything (default 8)")
    parser.add_argument("--from", dest="start", help="a network that was learned before, to go on from")
    parser.add_argument("--out", default=str(ROOT / "src/mien/assets/live/recogniser.npz"))
    options = parser.parse_args()
    speak.make(options.package, options.work / "speech", options.lines)
    made = list(kept_lines(options.work / "speech"))[: options.lines]
    emodb, grid = list(german(options.data)), british(options.data / "grid-s1", options.work / "grid")
    held = [line for line in emodb if line.speaker in HELD_OUT]
    emodb = [line for line in emodb if line.speaker not in HELD_OUT]
    print(f"{len(made)} synthetic, {len(emodb)} German, {len(grid)} GRID lines; {len(held)} held out", flush=True)
    random = np.random.default_rng([5, bool(options.start)])
    weights = FrameClassifier.load(options.start).weights if options.start else acoustic_model.with_head(random)
    bank = weights["mel"]
    test = [heard(line, bank) for line in held[::4]]
    learner = Learner({name: values for name, values in weights.items() if name != "mel"}, options.rounds, random)
    counts, began = np.ones(len(LABELS)), time.monotonic()
    for number in range(options.rounds):
        everything = [*made, *some(emodb, 2, random), *some(grid, 3, random)]
        pairs = []
        for place in random.permutation(len(everything)):
            line = everything[place]
            semitones = 1.5 if line.speaker == "grid" or line.speaker.isdigit() else 2.5
            pairs.append(heard(varied(line, [*made, *emodb], random, semitones), bank))
        rows, labels = np.concatenate([one for one, _ in pairs]), np.concatenate([one for _, one in pairs])
        counts += np.bincount(labels, minlength=len(LABELS))
        loss = learner.learn(rows, labels)
        share = np.log(counts / counts.sum()).astype(np.float32)
        learned = {name: np.asarray(values) for name, values in learner.weights.items()}
        network = FrameClassifier(LABELS, learned | {"mel": bank}, share, following(made))
        right = np.concatenate([network.log_posteriors(rows).argmax(axis=1) == labels for rows, labels in test])
        print(number, round(time.monotonic() - began), f"{loss:.3f} {right.mean():.3f}", flush=True)
        network.save(options.out)


def some(lines: Sequence[Line], share: int, random: np.random.Generator) -> list[Line]:
    """One in ``share`` of the lines: there are few texts among them, which would be learned by heart."""
    return [lines[place] for place in random.permutation(len(lines))[: len(lines) // share]]


def kept_lines(folder: Path) -> Iterator[Line]:
    """What `speak.keep` wrote."""
    for path in sorted(folder.glob("*.npz")):
        with np.load(path) as kept:
            yield Line(
                kept["samples"] / 32767.0,
                tuple(str(label) for label in kept["labels"]),
                kept["starts"],
                kept["ends"],
                str(kept["speaker"]),
            )


def german(data: Path) -> Iterator[Line]:
    """EmoDB, its phones as the nearest English ones."""
    sys.path.append(str(ROOT / "benchmarks"))
    from hand_labels import emodb

    for item in emodb(data / "emodb"):
        labels = tuple(phone.label for phone in item.phones)
        starts, ends = (np.array([getattr(phone, side) for phone in item.phones]) for side in ("start", "end"))
        yield Line(item.audio.resampled(RATE).samples.astype(np.float64), labels, starts, ends, item.name[:2])


def british(corpus: Path, folder: Path) -> list[Line]:
    """A third of GRID's speaker 1, aligned with what is said."""
    folder.mkdir(parents=True, exist_ok=True)
    for path in sorted((corpus / "audio").glob("*.flac"))[::3]:
        if not (folder / f"{path.stem}.npz").exists():
            words = [line.split()[2] for line in (corpus / "words" / f"{path.stem}.align").read_text().splitlines()]
            text = " ".join(word for word in words if word not in ("sil", "sp"))
            speak.keep(folder / f"{path.stem}.npz", align(read_audio(path)[0], text), "grid")
    return list(kept_lines(folder))


def heard(line: Line, bank: Single) -> tuple[Single, NDArray[np.int64]]:
    """Rows of a line and the label of each."""
    rows = StreamingFeatures(bank).push(np.concatenate([line.samples, np.zeros(WINDOW // 2)]))
    times = np.arange(len(rows)) * HOP / RATE
    place = np.searchsorted(line.starts, times, side="right") - 1
    index = np.array([LABELS.index(label) for label in line.labels])
    inside = (place >= 0) & (times < line.ends[np.maximum(place, 0)])
    return rows, np.where(inside, index[np.maximum(place, 0)], 0)


def following(lines: Sequence[Line]) -> Single:
    """Logarithm of how often one label follows another, shape (labels, labels)."""
    index = {label: place for place, label in enumerate(LABELS)}
    counts = np.full((len(LABELS), len(LABELS)), 0.5)
    for line in lines:
        for one, other in pairwise(line.labels):
            counts[index[one], index[other]] += 1
    return np.log(counts / counts.sum(axis=1, keepdims=True)).astype(np.float32)


class Learner:
    """Gradient descent (Adam) on the cross entropy of segments of two seconds that begin and end anywhere."""

    def __init__(self, weights: Weights, rounds: int, random: np.random.Generator) -> None:
        self.weights, self.rounds, self.random = weights, rounds, random
        self.means, self.powers = ({name: np.zeros_like(v) for name, v in weights.items()} for _ in range(2))
        self.key, self.done, self.steps = jax.random.PRNGKey(0), 0, 0

    def learn(self, rows: Single, labels: NDArray[np.int64]) -> float:
        """One pass; the mean loss."""
        offset = int(self.random.integers(SEGMENT))
        count = (len(rows) - offset) // SEGMENT
        rows = rows[offset : offset + count * SEGMENT].reshape(count, SEGMENT, BANDS)
        labels = labels[offset : offset + count * SEGMENT].reshape(count, SEGMENT)
        self.steps = self.steps or self.rounds * (count // BATCH)
        order, losses = self.random.permutation(count), []
        for first in range(0, count - BATCH + 1, BATCH):
            batch = order[first : first + BATCH]
            losses.append(self._step(np.stack([self._spoilt(rows[place]) for place in batch]), labels[batch]))
        return float(np.mean(losses))

    def _spoilt(self, rows: Single) -> Single:
        """Now and then some bands or some rows are not heard."""
        rows = rows.copy()
        if self.random.random() < 0.4:
            first = self.random.integers(BANDS - 12)
            rows[:, first : first + self.random.integers(2, 13)] = rows.mean()
        if self.random.random() < 0.3:
            first = self.random.integers(SEGMENT - 10)
            rows[first : first + self.random.integers(2, 10)] = rows.mean()
        return rows

    def _step(self, rows: Single, labels: NDArray[np.int64]) -> float:
        self.done += 1
        self.key, key = jax.random.split(self.key)
        loss, slopes = _loss_and_slopes(self.weights, rows, labels, key)
        if not np.isfinite(loss):
            raise SystemExit("the loss is not finite")
        size = min(1.0, self.done / WARM) * 0.5 * (1 + np.cos(np.pi * min(1.0, self.done / self.steps)))
        self.weights, self.means, self.powers = _adam(
            self.weights, slopes, self.means, self.powers, float(self.done), float(size)
        )
        return float(loss)


@jax.jit
def _adam(
    weights: Weights, slopes: Weights, means: Weights, powers: Weights, done: float, size: float
) -> tuple[Weights, Weights, Weights]:
    steep = jnp.sqrt(sum((slope**2).sum() for slope in slopes.values()))
    slopes = {name: slope * jnp.minimum(1.0, STEEPEST / steep) for name, slope in slopes.items()}
    means = {name: 0.9 * means[name] + 0.1 * slopes[name] for name in weights}
    powers = {name: 0.98 * powers[name] + 0.02 * slopes[name] ** 2 for name in weights}
    moved = {}
    for name, value in weights.items():
        rate = size * (HEAD_RATE if name.startswith("head") else BLOCKS_RATE)
        step = means[name] / (1 - 0.9**done) / (jnp.sqrt(powers[name] / (1 - 0.98**done)) + 1e-8)
        moved[name] = value - rate * step
    return moved, means, powers


def _loss(weights: Weights, rows: Any, labels: Any, key: Any) -> Any:
    answers = acoustic_model.log_posteriors(weights, rows, key)
    wanted = jax.nn.one_hot(labels, len(LABELS)) * (1 - SMOOTHING) + SMOOTHING / len(LABELS)
    closed = np.array([CLOSURES if label in ("P", "B", "M") else 1.0 for label in LABELS])
    counts = np.concatenate([np.full(20, EARLY), np.ones(SEGMENT - 50), np.full(30, LATE)])
    share = jnp.asarray(closed)[labels] * counts
    return -((answers * wanted).sum(axis=-1) * share).sum() / share.sum()


_loss_and_slopes = jax.jit(jax.value_and_grad(_loss))


if __name__ == "__main__":
    main()
