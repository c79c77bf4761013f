"""Measure maps between emotions on made-up emotional motion and write docs/tables/emotion_mapping.md.

    python benchmarks/emotion_mapping.py GRID_CORPUS      # a corpus made by `mien corpus import` of grid-s1

No recorded emotional motion with the same sentences ships or is at hand. So that the true change is known, takes of
grid-s1 (every fourth marker) are made emotional: their motion is scaled (gain) and moved (offset) in a known direction,
wanders with the spread and the decay that real faces have within an emotion (2.8 mm, 0.17 s), is said at another pace,
and gets 0.3 mm of noise. Sentence by sentence each map is learned from the others; see
`mien.models.emotion_mapping.MappingScore` for the columns.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.corpus.corpus import Corpus
from mien.models.emotion_mapping import Pair, leave_one_sentence_out, scores_table

TABLE = Path(__file__).parent.parent / "docs" / "tables" / "emotion_mapping.md"
SENTENCES = 4
FPS = 25
NOISE, WANDER, DECAY = 0.3, 2.8, 0.17
CASES = {
    "offset alone": (6.0, 1.0, 0.0),
    "offset, and a mouth that moves 1.15 times as far": (6.0, 1.15, 0.0),
    "the same, wandering as real expressions do": (6.0, 1.15, WANDER),
}


def emotional(
    motion: NDArray[np.float64],
    direction: NDArray[np.float64],
    case: tuple[float, float, float],
    random: np.random.Generator,
) -> NDArray[np.float64]:
    """The same sentence with a known change; positions of shape (frames, markers, 3)."""
    size, gain, wander = case
    frames = len(motion)
    pace = np.clip(np.arange(frames) + 3 * np.sin(np.linspace(0, np.pi, frames)), 0, frames - 1)
    flat = motion.reshape(frames, -1)
    moved = np.stack([np.interp(pace, np.arange(frames), column) for column in flat.T], axis=1)
    along = np.empty(frames)
    step = np.exp(-1 / (FPS * DECAY))
    along[0] = random.normal()
    for i in range(1, frames):
        along[i] = step * along[i - 1] + np.sqrt(1 - step**2) * random.normal()
    middle = flat.mean(axis=0)
    changed = middle + gain * (moved - middle) + (size + wander * along)[:, None] * direction
    return (changed + random.normal(0, NOISE, changed.shape)).reshape(motion.shape)


def main() -> None:
    corpus = Corpus(sys.argv[1])
    takes = [corpus.take(name) for name in list(corpus.names)[:: len(corpus) // (4 * SENTENCES)]]
    whole = [take.markers.positions[:, ::4] for take in takes if np.isfinite(take.markers.positions).all()][:SENTENCES]
    random = np.random.default_rng(0)
    markers = whole[0].shape[1]
    smooth = np.cumsum(random.normal(size=(markers, 3)), axis=0)
    direction = ((smooth - smooth.mean(axis=0)) / (smooth - smooth.mean(axis=0)).std()).ravel() / np.sqrt(3)
    parts = [
        "# Maps between emotions, on made-up emotional motion",
        "",
        " ".join((__doc__ or "").split("\n\n")[2].split()),
    ]
    for name, case in CASES.items():
        pairs: list[Pair] = [(m, emotional(m, direction, case, random)) for m in whole]
        parts += ["", f"## {name}", "", scores_table(leave_one_sentence_out(pairs))]
    TABLE.write_text("\n".join(parts) + "\n", encoding="utf-8")
    print("\n".join(parts))


if __name__ == "__main__":
    main()
