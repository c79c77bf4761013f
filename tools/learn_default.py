"""Learn the default performer from GRID speaker 1 and put it where it ships.

    mien corpus import DATA/grid-s1 -o grid-corpus
    python tools/learn_default.py grid-corpus

Writes src/mien/assets/performers/default.mien, the same bytes each time. The recordings are CC BY 4.0 (NOTICE):
the learned model may ship, the recordings may not.
"""

from __future__ import annotations

import sys
from pathlib import Path

from tqdm import tqdm

from mien.corpus.recordings import Corpus
from mien.motion.learning import learn_corpus
from mien.motion.performer_file import save_learned

TARGET = Path(__file__).parent.parent / "src" / "mien" / "assets" / "performers" / "default.mien"


def main() -> None:
    """Learn and save."""
    with tqdm(desc="learning") as bar:

        def progress(done: int, total: int, what: str) -> None:
            bar.total = total
            bar.set_postfix_str(what)
            bar.update(done - bar.n)

        learned = learn_corpus(Corpus(sys.argv[1]), progress=progress, name="default")
    TARGET.parent.mkdir(exist_ok=True)
    save_learned(learned, TARGET)
    print(f"{TARGET.name}: {len(learned.trained_on)} takes, {TARGET.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
