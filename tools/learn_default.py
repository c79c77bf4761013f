"""Learn the default performer from GRID speaker 1 and put it where it ships.

    mien corpus import DATA/grid-s1 -o grid-corpus
    python tools/learn_default.py grid-corpus

Writes src/mien/assets/performers/default.mien, the same bytes each time. The recordings are CC BY 4.0 (NOTICE):
the learned model may ship, the recordings may not.

One camera sees a mouth grow narrow and hardly sees it protrude, and this speaker rounds his lips little. Round phones
are therefore taken some of the way (`mien.motion.mouth.rounding`) to those of the performer `mandarin`, whose lips a
studio recorded, where those are rounder.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from tqdm import tqdm

from mien.corpus.recordings import Corpus
from mien.motion.learning import learn_corpus
from mien.motion.mouth.rounding import rounded
from mien.motion.performer_file import save_learned
from mien.motion.performers import load_learned_performer

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
    like = load_learned_performer("mandarin").motion
    save_learned(replace(learned, motion=rounded(learned.motion, like)), TARGET)
    print(f"{TARGET.name}: {len(learned.trained_on)} takes, {TARGET.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
