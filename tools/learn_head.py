"""Learn the head motion that goes with a voice from GRID speaker 1 and put it where it ships.

    mien corpus import DATA/grid-s1 -o grid-corpus
    python tools/learn_head.py grid-corpus

Writes src/mien/assets/performance/head.npz, the same bytes each time (NOTICE: the recordings are CC BY 4.0).
"""

from __future__ import annotations

import sys
from pathlib import Path

from tqdm import tqdm

from mien.corpus.recordings import Corpus
from mien.motion.alive.head_motion import LearnedHead

TARGET = Path(__file__).parent.parent / "src" / "mien" / "assets" / "performance" / "head.npz"


def main() -> None:
    """Learn and save."""
    takes = list(tqdm(Corpus(sys.argv[1]), desc="reading"))
    LearnedHead().fit(takes).write(TARGET)
    print(f"{TARGET.name}: {len(takes)} takes, {TARGET.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
