"""Which takes are learned from and which are scored.

Two protocols. ``random``: takes are dealt into parts at random, and each part is tested in turn with the others
learned from. ``leave-words-out``: words are dealt into parts; every take that holds a word of the part is left out of
the learning, and scored inside those words only. Either way the test may be named instead: a list of takes, or of
words.

The same functions serve ``mien learn --exclude-words --exclude-names``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from mien.core.errors import InputError
from mien.core.plain_text import read_plain_text
from mien.corpus.take import Take

__all__ = [
    "PARTS",
    "Fold",
    "check_names",
    "check_words",
    "hardest_words",
    "named_fold",
    "random_folds",
    "read_list",
    "words_fold",
    "words_folds",
    "words_of",
]

PARTS = 8
"""Parts into which takes or words are dealt when no list is given."""


HARDEST = 12
"""Words that `hardest_words` takes, at most."""


@dataclass(frozen=True)
class Fold:
    """One training and its test.

    Attributes
    ----------
    train, test : tuple of str
        Names of takes; none is in both.
    words : frozenset of str
        If not empty, only frames inside these words are scored.
    """

    train: tuple[str, ...]
    test: tuple[str, ...]
    words: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        if not self.test:
            raise InputError("the test set is empty: no take is left to score; give other names or words")
        if not self.train:
            raise InputError(f"the {len(self.test)} takes of the test are the whole corpus: none is left to learn from")


def read_list(path: str | Path, what: str) -> tuple[str, ...]:
    """Read names or words from a text file: one or more a line, separated by white space; ``#`` begins a comment.

    Raises
    ------
    InputError
        If the file is missing, no UTF-8 text, or holds nothing.
    """
    path = Path(path)
    text, _ = read_plain_text(path, f"a list of {what}")
    found = tuple(dict.fromkeys(item for line in text.splitlines() for item in line.split("#")[0].split()))
    if not found:
        raise InputError(f"{path}: expected a list of {what}, one a line; found none")
    return found


def words_of(take: Take) -> frozenset[str]:
    """The words said in a take, lower case."""
    return frozenset(word.label.lower() for word in take.words)


def check_names(names: Iterable[str], known: Collection[str]) -> tuple[str, ...]:
    """The names as given, once each, or an error that tells the first that are not in the corpus."""
    wanted = tuple(dict.fromkeys(names))
    _refuse_unknown("takes", wanted, known)
    return wanted


def check_words(words: Iterable[str], spoken: Collection[str]) -> frozenset[str]:
    """The words in lower case, or an error that tells the first that are never said in the corpus."""
    wanted = dict.fromkeys(word.lower() for word in words)
    _refuse_unknown("words", wanted, spoken)
    return frozenset(wanted)


def _refuse_unknown(what: str, wanted: Iterable[str], known: Collection[str]) -> None:
    missing = [item for item in wanted if item not in known]
    if missing:
        more = f" and {len(missing) - 5} more" if len(missing) > 5 else ""
        raise InputError(f"{what} in the list that are not in the corpus: {', '.join(missing[:5])}{more}")


def named_fold(takes: Sequence[Take], test_names: Iterable[str]) -> Fold:
    """Test on the named takes, learn from all others."""
    names = [take.name for take in takes]
    test = set(check_names(test_names, names))
    return Fold(tuple(n for n in names if n not in test), tuple(n for n in names if n in test))


def random_folds(takes: Sequence[Take], folds: int, random: np.random.Generator) -> list[Fold]:
    """Deal the takes into `PARTS` at random; the first ``folds`` parts are tested in turn.

    Raises
    ------
    InputError
        If ``folds`` is not 1 to `PARTS`, or there are too few takes.
    """
    _check_folds(folds)
    if len(takes) < PARTS:
        raise InputError(
            f"a random split needs at least {PARTS} takes, the corpus has {len(takes)}; list those to test in a file, "
            "one a line: --test-names FILE"
        )
    order = random.permutation(len(takes))
    return [named_fold(takes, [takes[i].name for i in order[part::PARTS]]) for part in range(folds)]


def words_fold(takes: Sequence[Take], words: Iterable[str]) -> Fold:
    """Test inside the given words, learn from the takes that hold none of them.

    Raises
    ------
    InputError
        If a word is never said, or every take holds one of the words.
    """
    spoken = {take.name: words_of(take) for take in takes}
    wanted = check_words(words, frozenset().union(*spoken.values()))
    return Fold(
        train=tuple(name for name, said in spoken.items() if not said & wanted),
        test=tuple(name for name, said in spoken.items() if said & wanted),
        words=wanted,
    )


def words_folds(takes: Sequence[Take], folds: int, random: np.random.Generator) -> list[Fold]:
    """Deal the words into `PARTS`, common and rare ones evenly; the first ``folds`` parts are tested in turn.

    Raises
    ------
    InputError
        If ``folds`` is not 1 to `PARTS`, there are too few words, or a part touches every take.
    """
    _check_folds(folds)
    counts = Counter(word for take in takes for word in words_of(take))
    ranked = sorted(counts, key=lambda word: (-counts[word], word))
    if len(ranked) < PARTS:
        raise InputError(f"leaving words out needs at least {PARTS} words, the corpus has {len(ranked)}; name them")
    parts: list[list[str]] = [[] for _ in range(PARTS)]
    for first in range(0, len(ranked), PARTS):
        group = ranked[first : first + PARTS]
        for word, part in zip(group, random.permutation(PARTS), strict=False):
            parts[part].append(word)
    return [words_fold(takes, part) for part in parts[:folds]]


def hardest_words(takes: Sequence[Take], most: int = HARDEST) -> tuple[str, ...]:
    """The words that are hardest to guess from all others, hardest first.

    A word is the harder the larger the share of its phone pairs (with their order, inside the word) that is said in no
    take without the word; among equals, the more seldom its rarest phone is said there. Words are taken in this order
    as long as half of the takes remain to learn from.

    Parameters
    ----------
    takes : sequence of Take
    most : int
        Words that are taken, at most.

    Raises
    ------
    InputError
        If no word can be left out.
    """
    pairs = {take.name: Counter(pairwise(p.label for p in take.phones)) for take in takes}
    phones = {take.name: Counter(p.label for p in take.phones) for take in takes}
    all_pairs, all_phones = sum(pairs.values(), Counter()), sum(phones.values(), Counter())
    ranked = []
    for word, (inside, where) in _said_as(takes).items():
        held_pairs = sum((pairs[name] for name in where), Counter())
        held_phones = sum((phones[name] for name in where), Counter())
        inner = list(pairwise(inside))
        unheard = sum(all_pairs[pair] == held_pairs[pair] for pair in inner) / max(len(inner), 1)
        rarest = min(all_phones[phone] - held_phones[phone] for phone in inside)
        ranked.append((-unheard, rarest, word, where))
    chosen: list[str] = []
    used: frozenset[str] = frozenset()
    for *_, word, where in sorted(ranked, key=lambda row: row[:3]):
        if len(used | where) <= len(takes) / 2 and len(chosen) < most:
            chosen.append(word)
            used |= where
    if not chosen:
        raise InputError("every word is said in more than half of the takes: none can be left out")
    return tuple(chosen)


def _said_as(takes: Sequence[Take]) -> dict[str, tuple[tuple[str, ...], frozenset[str]]]:
    """For each word how it is said most often, and the takes that hold it."""
    ways: dict[str, Counter[tuple[str, ...]]] = {}
    where: dict[str, set[str]] = {}
    for take in takes:
        for word in take.words:
            inside = tuple(p.label for p in take.phones if word.start <= p.middle < word.end)
            if inside:
                ways.setdefault(word.label.lower(), Counter())[inside] += 1
                where.setdefault(word.label.lower(), set()).add(take.name)
    return {word: (max(sorted(said), key=said.__getitem__), frozenset(where[word])) for word, said in ways.items()}


def _check_folds(folds: int) -> None:
    if not 1 <= folds <= PARTS:
        raise InputError(f"--folds is a whole number from 1 to {PARTS}, not {folds}")
