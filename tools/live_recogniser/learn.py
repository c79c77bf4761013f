"""Learns the live recogniser: from data to src/mien/assets/live/recogniser.npz in one command.

    npm pack kokoro-js@1.2.1
    python tools/live_recogniser/learn.py kokoro-js-1.2.1.tgz DATA WORK          about two hours on one core

DATA holds grid-s1 and emodb (two of its ten speakers are held out to watch the learning by). Speech of synthetic voices
is made first (`speak.py`) and a third of GRID is aligned; both are kept in WORK, so that the work can be stopped and
taken up again. timit-sample is never read here: it is what the result is measured on (``benchmarks/live.py``,
``noise.py``). Every recording comes in several variations (`variations.py`), new ones in each round, so that the
network hears more voices, microphones, rooms and noises than there are. The same bits for the same input and seed.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import speak
from numpy.typing import NDArray
from variations import RATE, Line, varied

from mien.core.utterance import PAUSE
from mien.formats.sound_files import read_audio
from mien.motion.mouth.descent import Adam
from mien.speech.align import align
from mien.speech.frame_classifier import FrameClassifier
from mien.speech.streaming_features import BANDS, CENTRE, COLUMNS, HOP, StreamingFeatures
from mien.text.phones import phone_table

ROOT = Path(__file__).parents[2]
LABELS = (PAUSE, *sorted(phone_table()))
OFFSETS = np.array([-24, -19, -15, -12, -10, -8, -6, -5, -4, -3, -2, -1, 0, 1, 2, 3, 4, 5, 6, 8, 10, 12, 15])
HELD_OUT = ("08", "15")  # speakers of EmoDB: a woman, a man
BATCH, DROPOUT, SMOOTHING = 512, 0.15, 0.05
LINES = 600
WHOLE_FUTURE = 0.4  # share of rows that are learned with all of their future

Single = NDArray[np.float32]


def main() -> None:
    """Learn, and write the network after each pass."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("package", help="kokoro-js-1.2.1.tgz, which carries the voices' style vectors")
    parser.add_argument("data", type=Path, help="folder of grid-s1 and emodb")
    parser.add_argument("work", type=Path, help="folder for what is made on the way")
    parser.add_argument("--lines", type=int, default=LINES, help=f"of synthetic speech (default {LINES})")
    parser.add_argument("--hidden", type=int, nargs="+", default=[512, 256, 256])
    parser.add_argument("--rounds", type=int, default=8, help="variations of everything (default 8)")
    parser.add_argument("--passes", type=int, default=2, help="through each of them (default 2)")
    parser.add_argument("--rate", type=float, default=1.5e-3, help="size of the first steps (default 1.5e-3)")
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
    test = heard([plain(line) for line in held])
    learner: Learner | None = None
    began = time.monotonic()
    for number in range(options.rounds):
        everything = [*made, *some(emodb, 2, random), *some(grid, 3, random)]
        wide = {id(line): 2.5 if line.speaker != "grid" and not line.speaker.isdigit() else 1.5 for line in everything}
        rows, labels, starts = heard([varied(line, everything, random, wide[id(line)]) for line in everything])
        if learner is None:
            learner = Learner(rows, labels, options, random)
            learner.log_follow = following(made)
        for _ in range(options.passes):
            learner.learn(rows, labels, starts)
            network = learner.network()
            print(number, round(time.monotonic() - began), *judged(network, *test), flush=True)
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
        yield _line(item.audio, item.phones, item.name[:2])


def british(corpus: Path, folder: Path) -> list[Line]:
    """A third of GRID's speaker 1, aligned with what is said."""
    folder.mkdir(parents=True, exist_ok=True)
    for path in sorted((corpus / "audio").glob("*.flac"))[::3]:
        if not (folder / f"{path.stem}.npz").exists():
            words = [line.split()[2] for line in (corpus / "words" / f"{path.stem}.align").read_text().splitlines()]
            text = " ".join(word for word in words if word not in ("sil", "sp"))
            speak.keep(folder / f"{path.stem}.npz", align(read_audio(path)[0], text), "grid")
    return list(kept_lines(folder))


def _line(audio: object, phones: Sequence[object], speaker: str) -> Line:
    labels = tuple(phone.label for phone in phones)
    starts, ends = (np.array([getattr(phone, side) for phone in phones]) for side in ("start", "end"))
    return Line(audio.resampled(RATE).samples.astype(np.float64), labels, starts, ends, speaker)


def plain(line: Line) -> tuple[Line, float]:
    """A line as it is."""
    return line, 1.0


def heard(lines: Sequence[tuple[Line, float]]) -> tuple[Single, NDArray[np.int64], NDArray[np.int64]]:
    """Rows and labels of all lines, and where each line begins and ends."""
    rows: list[Single] = []
    labels: list[NDArray[np.int64]] = []
    starts = [0]
    index = {label: number for number, label in enumerate(LABELS)}
    for line, warp in lines:
        found = StreamingFeatures(warp).push(line.samples)
        times = CENTRE + np.arange(len(found)) * HOP / RATE
        place = np.searchsorted(line.starts, times, side="right") - 1
        inside = (place >= 0) & (times < line.ends[place])
        codes = np.array([index[label] for label in line.labels])
        labels.append(np.where(inside, codes[place], 0))
        rows.append(found.astype(np.float32))
        starts.append(starts[-1] + len(found))
    return np.concatenate(rows), np.concatenate(labels), np.array(starts)


def following(lines: Sequence[Line]) -> Single:
    """Logarithm of how often each label follows each, every pair counted half a time more than it was heard."""
    index = {label: number for number, label in enumerate(LABELS)}
    counts = np.full((len(LABELS), len(LABELS)), 0.5)
    for line in lines:
        for one, other in pairwise(line.labels):
            counts[index[one], index[other]] += 1
    return np.log(counts / counts.sum(axis=1, keepdims=True)).astype(np.float32)


class Learner:
    """Gradient descent on the cross entropy, with the future of most rows cut off at random."""

    def __init__(
        self, rows: Single, labels: NDArray[np.int64], options: argparse.Namespace, random: np.random.Generator
    ) -> None:
        self.random = random
        self.mean, self.spread = rows.mean(axis=0), rows.std(axis=0) + np.float32(1e-3)
        share = np.bincount(labels, minlength=len(LABELS)) / len(labels)
        self.log_follow = np.zeros((len(LABELS), len(LABELS)), np.float32)
        self.log_share = np.log(np.maximum(share, 1e-5)).astype(np.float32)
        sizes = [len(OFFSETS) * (COLUMNS + 1), *options.hidden, len(LABELS)]
        self.layers = [
            (random.normal(0, np.sqrt(2 / a), (a, b)).astype(np.float32), np.zeros(b, np.float32))
            for a, b in pairwise(sizes)
        ]
        if options.start:
            before = FrameClassifier.load(options.start)
            self.layers = [(weights.copy(), bias.copy()) for weights, bias in before.layers]
            known = len(before.mean)
            self.mean[:known], self.spread[:known], self.log_share = before.mean, before.spread, before.log_share
            if known < COLUMNS:  # it saw less of each row: what is new counts for nothing yet
                seen = self.layers[0][0][: -len(OFFSETS)].reshape(len(OFFSETS), known, -1)
                seen = np.pad(seen, ((0, 0), (0, COLUMNS - known), (0, 0))).reshape(len(OFFSETS) * COLUMNS, -1)
                self.layers[0] = (np.concatenate([seen, self.layers[0][0][-len(OFFSETS) :]]), self.layers[0][1])
        steps = options.rounds * options.passes * (len(rows) // BATCH)
        self.adam = Adam([array for layer in self.layers for array in layer], options.rate, steps)

    def network(self) -> FrameClassifier:
        """What was learned until now."""
        layers = tuple((weights.copy(), bias.copy()) for weights, bias in self.layers)
        return FrameClassifier(LABELS, OFFSETS, self.mean, self.spread, layers, self.log_share, self.log_follow)

    def learn(self, rows: Single, labels: NDArray[np.int64], starts: NDArray[np.int64]) -> None:
        """One pass."""
        rows = (rows - self.mean) / self.spread
        lengths = np.diff(starts)
        first, last = np.repeat(starts[:-1], lengths), np.repeat(starts[1:], lengths)
        order = self.random.permutation(len(rows))
        for batch in np.split(order[: len(order) // BATCH * BATCH], len(order) // BATCH):
            self.adam.step(self.slopes(self.inputs(rows, batch, first[batch], last[batch]), labels[batch]))

    def inputs(
        self, rows: Single, places: NDArray[np.int64], first: NDArray[np.int64], last: NDArray[np.int64]
    ) -> Single:
        """What the network sees of some rows, with the future cut off at random and now and then a band left out."""
        cut = self.random.integers(0, OFFSETS.max() + 1, len(places))
        cut[self.random.random(len(places)) < WHOLE_FUTURE] = OFFSETS.max()
        at = places[:, None] + OFFSETS
        missing = (cut[:, None] < OFFSETS) | (at >= last[:, None])
        seen = rows[np.clip(at, first[:, None], last[:, None] - 1)]
        seen[missing] = 0
        chance = self.random.random()
        if chance < 0.1:  # one of the two ways of hearing is missing
            seen[:, :, BANDS + 2 :] = 0
        elif chance < 0.2:
            seen[:, :, :BANDS] = 0
        elif chance < 0.5:  # a band that is not heard
            band = self.random.integers(0, 36)
            seen[:, :, band : band + self.random.integers(1, 7)] = 0
        return np.concatenate([seen.reshape(len(places), -1), missing.astype(np.float32)], axis=1)

    def slopes(self, inputs: Single, labels: NDArray[np.int64]) -> list[Single]:
        """Slopes of the mean cross entropy on weights and biases, in order."""
        passed, kept, value = [inputs], [], inputs
        for weights, bias in self.layers[:-1]:
            mask = (self.random.random((len(value), len(bias)), dtype=np.float32) > DROPOUT) / np.float32(1 - DROPOUT)
            value = np.maximum(value @ weights + bias, 0) * mask
            kept.append(mask)
            passed.append(value)
        value = value @ self.layers[-1][0] + self.layers[-1][1]
        value = np.exp(value - value.max(axis=1, keepdims=True))
        back = value / value.sum(axis=1, keepdims=True)
        back -= SMOOTHING / len(LABELS)
        back[np.arange(len(back)), labels] -= 1 - SMOOTHING
        back /= len(back)
        slopes: list[Single] = []
        for number in range(len(self.layers) - 1, -1, -1):
            slopes[:0] = [passed[number].T @ back, back.sum(axis=0)]
            if number:
                back = (back @ self.layers[number][0].T) * kept[number - 1] * (passed[number] > 0)
        return slopes


def judged(network: FrameClassifier, rows: Single, labels: NDArray[np.int64], starts: NDArray[np.int64]) -> list[str]:
    """Share of rows with the right phone, as words to print."""
    right = []
    for first, last in pairwise(starts):
        line = rows[first:last]
        right.append(network.log_posteriors(line).argmax(axis=1) == labels[first:last])
    return [f"{np.concatenate(right).mean():.3f}"]


if __name__ == "__main__":
    main()
