"""Letters to sounds for words that no dictionary knows: a joint-sequence model in plain numpy.

Learned from the dictionary inside pocketsphinx by ``tools/train_letter_to_sound.py``, which explains the model.
A word is read from left to right; every letter is paired with none, one or two phones, and the row of pairs with the
highest probability wins (beam search).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset
from mien.core.errors import InputError

__all__ = ["BITS", "Model", "phones_of_letters"]

BITS = 9
"""Bits of one pair's number in a packed n-gram; seven of them fit one 64-bit integer."""
_BEAM = 12
_STEP = 0.06  # log probabilities are kept in 8 bits in steps of this, below zero
_UNSEEN = -16.0
_END = 1

Gram = tuple[int, ...]


@dataclass(frozen=True)
class Model:
    """An n-gram model over pairs of a letter and its phones.

    Attributes
    ----------
    pairs : tuple of (str, tuple of str)
        Pair ``i`` has the number ``i + 2``; 0 stands before a word and 1 after it.
    keys : array of uint64, shape (n,)
        Packed n-grams in order, the last pair in the lowest bits; see `_pack`.
    logp, backoff : array of float32, shape (n,)
        Natural log probability of the last pair after the others; weight for what follows the whole n-gram.
    """

    pairs: tuple[tuple[str, tuple[str, ...]], ...]
    keys: NDArray[np.uint64]
    logp: NDArray[np.float32]
    backoff: NDArray[np.float32]

    @classmethod
    def of_ngrams(
        cls, pairs: list[tuple[str, tuple[str, ...]]], logp: dict[Gram, float], backoff: dict[Gram, float]
    ) -> Model:
        """Pack tables of n-grams."""
        packed = {_pack(gram): gram for gram in logp.keys() | backoff.keys()}
        keys = np.array(sorted(packed), dtype=np.uint64)
        grams = [packed[int(key)] for key in keys]
        return cls(
            tuple(pairs),
            keys,
            np.array([logp.get(gram, _UNSEEN) for gram in grams], dtype=np.float32),
            np.array([backoff.get(gram, 0.0) for gram in grams], dtype=np.float32),
        )

    def save(self, path: Path) -> None:
        """Write the model, numbers rounded to 8 bits."""
        steps = np.diff(self.keys, prepend=np.uint64(0))
        planes = steps.view(np.uint8).reshape(-1, 8).T
        np.savez_compressed(
            path,
            pairs=np.array([f"{letter} {' '.join(phones)}" for letter, phones in self.pairs]),
            key_steps=np.ascontiguousarray(planes),
            logp=np.clip(np.round(-self.logp / _STEP), 0, 255).astype(np.uint8),
            backoff=np.clip(np.round(-self.backoff / _STEP) + 64, 0, 255).astype(np.uint8),
        )

    @classmethod
    def load(cls, path: Path) -> Model:
        """Read what `save` wrote."""
        with np.load(path) as data:
            names = [str(name).split() for name in data["pairs"]]
            steps = np.ascontiguousarray(data["key_steps"].T).view(np.uint64).ravel()
            return cls(
                tuple((name[0], tuple(name[1:])) for name in names),
                np.cumsum(steps, dtype=np.uint64),
                data["logp"].astype(np.float32) * -_STEP,
                (data["backoff"].astype(np.float32) - 64) * -_STEP,
            )

    def phones(self, letters: str) -> tuple[str, ...]:
        """Phones of a word in letters a-z.

        Raises
        ------
        InputError
            If a letter has no pair, which only happens outside a-z.
        """
        beam: list[tuple[float, Gram, tuple[str, ...]]] = [(0.0, (0,) * self._order, ())]
        for letter in letters:
            choices = self._choices.get(letter)
            if choices is None:
                raise InputError(f"expected letters a to z, got {letter!r} in {letters!r}")
            grown = [
                (score + self._score(history, pair), (*history[1:], pair), said + self.pairs[pair - 2][1])
                for score, history, said in beam
                for pair in choices
            ]
            beam = sorted(grown, key=lambda item: -item[0])[:_BEAM]
        finished = [(score + self._score(history, _END), said) for score, history, said in beam if said]
        return max(finished, key=lambda item: item[0])[1] if finished else ("AH",)

    @property
    def _order(self) -> int:
        return 64 // BITS - 1

    @property
    def _choices(self) -> dict[str, list[int]]:
        return _choices(self.pairs)

    def _score(self, history: Gram, pair: int) -> float:
        """Log probability of a pair after its history, backing off to shorter histories."""
        total = 0.0
        for skip in range(len(history) + 1):
            place = self._find(_pack((*history[skip:], pair)))
            if place is not None and self.logp[place] > _UNSEEN + 1:
                return total + float(self.logp[place])
            context = self._find(_pack(history[skip:])) if skip < len(history) else None
            total += float(self.backoff[context]) if context is not None else 0.0
        return total + _UNSEEN

    def _find(self, key: int) -> int | None:
        place = int(np.searchsorted(self.keys, np.uint64(key)))
        return place if place < len(self.keys) and int(self.keys[place]) == key else None


@cache
def _choices(pairs: tuple[tuple[str, tuple[str, ...]], ...]) -> dict[str, list[int]]:
    found: dict[str, list[int]] = {}
    for number, (letter, _) in enumerate(pairs, start=2):
        found.setdefault(letter, []).append(number)
    return found


def _pack(gram: Gram) -> int:
    """One integer for an n-gram: one is added to each number so that the length shows."""
    key = 0
    for number in gram:
        key = (key << BITS) | (number + 1)
    return key


@cache
def _shipped() -> Model:
    return Model.load(asset("phones/letter_to_sound.npz"))


def phones_of_letters(letters: str) -> tuple[str, ...]:
    """Phones of a word that the dictionary does not hold.

    Examples
    --------
    >>> phones_of_letters("blork")
    ('B', 'L', 'AO', 'R', 'K')
    """
    return _shipped().phones(letters)
