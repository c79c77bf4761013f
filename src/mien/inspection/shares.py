"""How much of ordinary English a performer has heard: what each pair of neighbouring phones of a text rests on."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from mien.core.assets import asset
from mien.core.errors import InputError
from mien.core.utterance import PAUSE
from mien.motion.mouth.coarticulation import plan
from mien.motion.performer_file import LearnedSpeech
from mien.text.normalisation import spoken_words
from mien.text.pronunciation import pronounce

__all__ = ["EVIDENCE", "PairShares", "ordinary_english", "phones_of_text", "read_sentences", "share_of_pairs"]

EVIDENCE = ("triphone", "diphone", "class", "cosine")
"""What a pair of phones can rest on, best first; for the performing mouth the last means: never heard, nor its like."""
_SAMPLE_NUMBERS = re.compile(r"^\d+ \d+ +")
"""TIMIT writes the first and the last sample before the sentence."""

Labels = tuple[str, ...]


@dataclass(frozen=True)
class PairShares:
    """What the phone pairs of some sentences rest on.

    Attributes
    ----------
    sentences, pairs, kinds : int
        Sentences, pairs of neighbours in them, and different ones among these.
    paper : dict of str to float
        Share of the pairs by `EVIDENCE` that Algorithm 1 would make so with the performer's curves.
    mouth : dict of str to float
        The same of what the performing mouth has heard in learning.
    unheard : tuple of (pair, count)
        Pairs whose like was never heard, the most frequent first.
    """

    sentences: int
    pairs: int
    kinds: int
    paper: dict[str, float]
    mouth: dict[str, float]
    unheard: tuple[tuple[Labels, int], ...]


def ordinary_english() -> tuple[str, ...]:
    """The sentences that come with mien, natural and rich in pairs of phones.

    Examples
    --------
    >>> len(ordinary_english()) > 20
    True
    """
    script = asset("scripts/english.txt")
    return _sentences(script.read_text(encoding="utf-8"))


def read_sentences(path: str | Path) -> tuple[str, ...]:
    """Sentences of a text file, one on each line, or of all ``.txt`` files in and below a folder.

    Lines that start with ``#`` are left out, and so are the numbers of samples that TIMIT writes before a sentence.

    Raises
    ------
    InputError
        If there is no such file, or no sentence in it.
    """
    path = Path(path)
    if not path.exists():
        raise InputError(f"{path}: no such text file or folder")
    sources = sorted(path.rglob("*.txt")) if path.is_dir() else [path]
    found: list[str] = []
    for source in sources:
        try:
            content = source.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError) as problem:
            raise InputError(f"{source}: cannot be read as UTF-8 text ({problem})") from problem
        found += _sentences(content)
    if not found:
        raise InputError(f"{path}: no sentence found; expected text, or .txt files with one sentence on each line")
    return tuple(found)


def _sentences(content: str) -> tuple[str, ...]:
    lines = (_SAMPLE_NUMBERS.sub("", line.strip()) for line in content.splitlines())
    return tuple(line for line in lines if line and not line.startswith("#"))


def phones_of_text(sentence: str) -> Labels:
    """Phones of a sentence, with a pause at each end and where its punctuation asks for one.

    Examples
    --------
    >>> phones_of_text("Yes, we do.")
    ('SIL', 'Y', 'EH', 'S', 'SIL', 'W', 'IY', 'D', 'UW', 'SIL')
    """
    labels = [PAUSE]
    for word in spoken_words(sentence).words:
        labels += pronounce(word.text)
        if word.pause:
            labels.append(PAUSE)
    if labels[-1] != PAUSE:
        labels.append(PAUSE)
    return tuple(labels)


def share_of_pairs(learned: LearnedSpeech, sentences: Sequence[str]) -> PairShares:
    """What the phone pairs of sentences rest on.

    Raises
    ------
    InputError
        If there is no sentence, or one cannot be spoken.
    """
    if not sentences:
        raise InputError("no sentence to look at")
    paper, coverage = learned.coarticulation, learned.motion.coverage_
    by_paper: Counter[str] = Counter()
    by_mouth: Counter[str] = Counter()
    met: Counter[Labels] = Counter()
    unheard: Counter[Labels] = Counter()
    for sentence in sentences:
        labels = phones_of_text(sentence)
        pairs = list(pairwise(labels))
        met.update(pairs)
        by_paper.update(step.source for step in plan(labels, paper.curves_, paper.class_curves_))
        evidence = ["cosine" if kind == "none" else kind for kind in coverage.of_pairs(labels)]
        by_mouth.update(evidence)
        unheard.update(pair for pair, kind in zip(pairs, evidence, strict=True) if kind == "cosine")
    total = sum(met.values())
    ranked = tuple(sorted(unheard.items(), key=lambda item: (-item[1], item[0])))
    return PairShares(len(sentences), total, len(met), _shares(by_paper, total), _shares(by_mouth, total), ranked)


def _shares(counts: Counter[str], total: int) -> dict[str, float]:
    return {kind: counts[kind] / total for kind in EVIDENCE}
