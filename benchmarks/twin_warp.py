"""How well takes are warped onto their twins without phone times, on re-timed takes of grid-s1.

    python benchmarks/twin_warp.py GRID_CORPUS      # writes docs/tables/twin_warp.md

A take is its own twin: each phone is made longer or shorter (factors of log-normal spread 0.25), then a known
expression is added: an offset of 2 mm a coordinate, a wander of 0.5 mm along it (1/e after 0.2 s), and 0.3 mm of
noise. The error is that of the time found by the motion of the mouth alone against the true one, inside the speech.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from mien.capture.layouts import load_layout
from mien.core.files import replace_when_complete
from mien.corpus.recordings import Corpus
from mien.corpus.take import Take
from mien.motion.drift import smooth_drift
from mien.motion.expression.expression_motion import warped_by_motion

TABLE = Path(__file__).parent.parent / "docs" / "tables" / "twin_warp.md"
TAKES, GRID, SECONDS = 30, 60, 3.0


def error(take: Take, random: np.random.Generator) -> np.ndarray:
    """Seconds between the time found and the true one, inside the speech."""
    mouth = load_layout(take.layout).groups["mouth"]
    positions = take.markers.positions[:, [take.markers.names.index(name) for name in mouth]]
    rows, frames = positions.reshape(len(positions), -1), take.markers.rate.times(len(positions))
    times = np.arange(round(SECONDS * GRID)) / GRID
    lengths = np.array([phone.end - phone.start for phone in take.phones])
    old = np.concatenate([[0.0], [phone.end for phone in take.phones]])
    new = np.concatenate([[0.0], np.cumsum(lengths * np.exp(0.25 * random.standard_normal(len(lengths))))])
    new *= (SECONDS - 0.02) / new[-1]
    plain = np.stack([np.interp(times, frames, column) for column in rows.T], axis=1)
    felt = np.stack([np.interp(np.interp(times, new, old), frames, column) for column in rows.T], axis=1)
    direction = random.standard_normal(felt.shape[1])
    felt += 2.0 * direction + 0.5 * smooth_drift(times, 0.2, random)[:, None] * direction
    felt += random.normal(0, 0.3, felt.shape)
    missed = np.abs(warped_by_motion(times, plain, felt) - np.interp(times, old, new))
    return np.asarray(missed[(times > take.phones.intervals[1].start) & (times < take.phones.intervals[-2].end)])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("corpus", help="made by 'mien corpus import' of grid-s1")
    corpus, random = Corpus(parser.parse_args().corpus), np.random.default_rng(0)
    takes = [corpus.take(name) for name in list(corpus.names)[:: max(1, len(corpus) // TAKES)]]
    missed = [
        error(take, random) for take in takes if np.isfinite(take.markers.positions).all() and len(take.phones) > 3
    ]
    every = 1000 * np.concatenate(missed)
    told = " ".join((__doc__ or "").split("\n\n")[2].split())
    lines = [
        "# Warping without phone times",
        "",
        told,
        "",
        "| takes | mean error, ms | median | 90 % below |",
        "| ---: | ---: | ---: | ---: |",
        f"| {len(missed)} | {every.mean():.1f} | {np.median(every):.1f} | {np.quantile(every, 0.9):.1f} |",
    ]
    with replace_when_complete(TABLE) as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
