"""Learn letters-to-sounds from pocketsphinx's dictionary; writes src/mien/assets/phones/letter_to_sound.npz.

    python tools/train_letter_to_sound.py            all words, for shipping
    python tools/train_letter_to_sound.py --held-out 1000

A joint-sequence model (Bisani and Ney 2008, "Joint-sequence models for grapheme-to-phoneme conversion") with one
letter a unit: each letter is paired with none, one or two phones by expectation maximisation, and an n-gram model
over the pairs, with absolute discounting and continuation counts (Kneser and Ney 1995), scores a whole word.
"""

from __future__ import annotations

import argparse
import re
import zlib
from collections import Counter, defaultdict
from pathlib import Path

import numpy as np

from mien.text.letter_to_sound import BITS, Model
from mien.text.pronunciation import dictionary_entries

ORDER = 7
THRESHOLDS = (0, 0, 1, 1, 2, 2, 3, 3)
"""Smallest count of an n-gram that is kept, by order. With 1 to order 5 and 2 above: 1.7 MB, 1.2 % more words right."""
MOST_PAIRS = (1 << BITS) - 3
Word = tuple[str, tuple[str, ...]]
Pair = tuple[str, tuple[str, ...]]
OUT = Path(__file__).parent.parent / "src" / "mien" / "assets" / "phones" / "letter_to_sound.npz"


def words_of_dictionary() -> list[Word]:
    """Plain words with their first pronunciation."""
    return [(word, phones) for word, phones in dictionary_entries() if re.fullmatch("[a-z]{2,}", word)]


def split_held_out(words: list[Word], number: int) -> tuple[list[Word], list[Word]]:
    """The ``number`` words whose checksum is lowest are held out, the same ones everywhere."""
    held = set(sorted((w for w, _ in words), key=lambda w: zlib.crc32(w.encode()))[:number])
    return [w for w in words if w[0] not in held], [w for w in words if w[0] in held]


def pair_up(word: Word, cost: dict[Pair, float]) -> list[Pair] | None:
    """The cheapest way to give each letter its phones; None if there is none."""
    letters, phones = word
    best: list[dict[int, tuple[float, int]]] = [{0: (0.0, 0)}]
    for letter in letters:
        row: dict[int, tuple[float, int]] = {}
        for used, (so_far, _) in best[-1].items():
            for take in range(min(2, len(phones) - used) + 1):
                total = so_far + cost.get((letter, phones[used : used + take]), 25.0)
                if used + take not in row or total < row[used + take][0]:
                    row[used + take] = (total, used)
        best.append(row)
    place, pairs = len(phones), []
    if place not in best[-1]:
        return None
    for i in range(len(letters), 0, -1):
        before = best[i][place][1]
        pairs.append((letters[i - 1], phones[before:place]))
        place = before
    return pairs[::-1]


def first_costs(words: list[Word]) -> dict[Pair, float]:
    """Costs from how often letter and phones occur at about the same place."""
    counts: Counter[Pair] = Counter()
    for letters, phones in words:
        for i, letter in enumerate(letters):
            middle = i * len(phones) // len(letters)
            for used in range(max(0, middle - 1), min(len(phones), middle + 2)):
                counts[letter, phones[used : used + 1]] += 1
            counts[letter, ()] += 1
            counts[letter, phones[middle : middle + 2]] += 0.05  # type: ignore[assignment]
    return costs_of(counts)


def costs_of(counts: Counter[Pair]) -> dict[Pair, float]:
    """Minus log of each pair's share of its letter."""
    totals: Counter[str] = Counter()
    for (letter, _), count in counts.items():
        totals[letter] += count
    return {pair: -float(np.log(count / totals[pair[0]])) for pair, count in counts.items() if count > 0}


def paired_words(words: list[Word], rounds: int = 5) -> list[list[Pair]]:
    """All words paired up; words that need rare pairs are left out."""
    cost = first_costs(words)
    for _ in range(rounds):
        paired = [pairs for word in words if (pairs := pair_up(word, cost))]
        counts = Counter(pair for pairs in paired for pair in pairs)
        cost = costs_of(counts)
    common = {pair for pair, count in counts.most_common(MOST_PAIRS) if count >= 10}
    return [pairs for pairs in paired if all(pair in common for pair in pairs)]


def learn(paired: list[list[Pair]], thresholds: tuple[int, ...]) -> Model:
    """The n-gram model over pairs; n-grams seen less often than their order's threshold are dropped."""
    names = sorted({pair for pairs in paired for pair in pairs})
    number = {pair: i + 2 for i, pair in enumerate(names)}  # 0 before a word, 1 after it
    counts: list[Counter[tuple[int, ...]]] = [Counter() for _ in range(ORDER + 1)]
    for pairs in paired:
        row = (0,) * (ORDER - 1) + tuple(number[pair] for pair in pairs) + (1,)
        for end in range(ORDER, len(row) + 1):
            counts[ORDER][row[end - ORDER : end]] += 1
    for n in range(ORDER - 1, 0, -1):  # continuation counts: how many different pairs stand before
        for gram in counts[n + 1]:
            counts[n][gram[1:]] += 1
        for gram, count in counts[n + 1].items():  # nothing stands before the start of a word: plain counts there
            if gram[0] == 0 and gram[1] == 0 and n > 1:
                counts[n][gram[1:]] += count - 1
    return Model.of_ngrams(names, *_discounted(counts, thresholds))


def _discounted(
    counts: list[Counter[tuple[int, ...]]], thresholds: tuple[int, ...]
) -> tuple[dict[tuple[int, ...], float], dict[tuple[int, ...], float]]:
    """Log probability of each n-gram kept, and log back-off weight of each context."""
    total = sum(counts[1].values())
    logp = {gram: float(np.log(count / total)) for gram, count in counts[1].items()}
    backoff: dict[tuple[int, ...], float] = {}
    probability = {gram: count / total for gram, count in counts[1].items()}
    for n in range(2, ORDER + 1):
        once, twice = (sum(count == k for count in counts[n].values()) for k in (1, 2))
        discount = once / (once + 2 * twice)
        contexts: defaultdict[tuple[int, ...], list[tuple[tuple[int, ...], int]]] = defaultdict(list)
        for gram, count in counts[n].items():
            contexts[gram[:-1]].append((gram, count))
        fresh: dict[tuple[int, ...], float] = {}
        for context, entries in contexts.items():
            everything = sum(count for _, count in entries)
            kept = [(gram, count) for gram, count in entries if count >= thresholds[n]]
            if not kept or (n > 2 and context[1:] and context not in probability and context[0] != 0):
                continue
            mass = 1.0 - sum(count - discount for _, count in kept) / everything
            for gram, count in kept:
                fresh[gram] = (count - discount) / everything + mass * _lower(gram[1:], probability, backoff)
            seen = sum(fresh[gram] for gram, _ in kept)
            rest = 1.0 - sum(_lower(gram[1:], probability, backoff) for gram, _ in kept)
            backoff[context] = float(np.log(max(1.0 - seen, 1e-6) / max(rest, 1e-6)))
        probability |= fresh
        logp |= {gram: float(np.log(value)) for gram, value in fresh.items()}
    return logp, backoff


def _lower(
    gram: tuple[int, ...], probability: dict[tuple[int, ...], float], backoff: dict[tuple[int, ...], float]
) -> float:
    weight = 0.0
    while gram not in probability:
        if len(gram) == 1:
            return 1e-7
        weight += backoff.get(gram[:-1], 0.0)
        gram = gram[1:]
    return probability[gram] * float(np.exp(weight))


def main() -> None:
    """Train, write, and score if words are held out."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--held-out", type=int, default=0, help="leave this many words out and score them")
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    train, test = split_held_out(words_of_dictionary(), options.held_out)
    model = learn(paired_words(train), THRESHOLDS)
    model.save(options.out)
    model = Model.load(options.out)
    print(f"{len(train)} words, {len(model.keys)} n-grams, {options.out.stat().st_size / 1e6:.2f} MB in {options.out}")
    if test:
        right = sum(model.phones(word) == phones for word, phones in test)
        print(f"{right / len(test):.1%} of {len(test)} words held out are right")


if __name__ == "__main__":
    main()
