"""``mien emotion-map``: what changes in the motion from one emotion to another, and how well that can be learned."""

from __future__ import annotations

import argparse
import sys
from typing import Any

__all__ = ["add_command"]


def add_command(commands: Any) -> None:
    """Add ``mien emotion-map`` to the commands."""
    told = commands.add_parser("emotion-map", help="analyse how motion changes between two emotions of a corpus")
    told.add_argument("corpus", metavar="CORPUS", help="a corpus with the same sentences in both emotions")
    told.add_argument("--from", dest="source", default="neutral", metavar="EMOTION", help="default: neutral")
    told.add_argument("--to", required=True, metavar="EMOTION")
    told.add_argument("--seed", type=int, default=0)
    told.set_defaults(run=_tell)


def _tell(options: argparse.Namespace) -> int:
    from mien.corpus.recordings import Corpus
    from mien.motion.maps.emotion_mapping import EmotionMapping, corpus_pairs, leave_one_sentence_out, scores_table

    pairs, notes = corpus_pairs(Corpus(options.corpus), options.source, options.to)
    for note in notes:
        print(f"mien: {note.kind}: {note.message}", file=sys.stderr)
    learned = EmotionMapping(seed=options.seed).fit(pairs)
    print(f"{len(pairs)} sentences in {options.source} and {options.to}; independent components:\n")
    print(learned.split_)
    if len(pairs) > 1:
        print("\nEach sentence mapped by what the others taught:\n")
        print(scores_table(leave_one_sentence_out(pairs, options.seed)))
    return 0
