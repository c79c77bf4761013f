from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.metrics.splits import (
    PARTS,
    Fold,
    check_words,
    hardest_words,
    named_fold,
    random_folds,
    read_list,
    words_fold,
    words_folds,
    words_of,
)
from tests.metrics.synthetic import spoken, takes


def test_random_folds_test_every_take_once_and_never_learn_from_it() -> None:
    every = takes(19)
    folds = random_folds(every, PARTS, np.random.default_rng(0))
    assert sorted(name for fold in folds for name in fold.test) == [take.name for take in every]
    for fold in folds:
        assert not set(fold.train) & set(fold.test)
        assert len(fold.train) + len(fold.test) == 19
    assert folds[:2] == random_folds(every, 2, np.random.default_rng(0))
    assert folds[0] != random_folds(every, 1, np.random.default_rng(1))[0]


def test_no_take_with_a_left_out_word_is_learned_from() -> None:
    every = takes(16)
    fold = words_fold(every, ["MA", "tea"])
    said = {take.name: words_of(take) for take in every}
    assert fold.words == {"ma", "tea"}
    assert all(not said[name] & {"ma", "tea"} for name in fold.train)
    assert all(said[name] & {"ma", "tea"} for name in fold.test)
    assert len(fold.train) + len(fold.test) == 16


def test_word_folds_leave_every_word_out_once() -> None:
    from mien.core.timeline import Interval, Tier

    every = []
    for i in range(20):
        take = spoken(f"t{i}", ("ma",))
        object.__setattr__(take, "words", Tier("words", (Interval(0.4, 0.7, f"word{i % 10}"),)))
        every.append(take)
    folds = words_folds(every, PARTS, np.random.default_rng(0))
    assert sorted(word for fold in folds for word in fold.words) == sorted(f"word{i}" for i in range(10))


def test_a_named_test() -> None:
    fold = named_fold(takes(4), ["take02", "take00", "take02"])
    assert fold == Fold(train=("take01", "take03"), test=("take00", "take02"))


def test_lists_are_words_parted_by_white_space_with_comments(tmp_path: Path) -> None:
    path = tmp_path / "list.txt"
    path.write_text("# left out\nbin  blue\n\nat # twice\nbin\n", encoding="utf-8")
    assert read_list(path, "words") == ("bin", "blue", "at")


def test_lists_that_cannot_be_used_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "list.txt"
    with pytest.raises(InputError, match=r"list\.txt: no such file"):
        read_list(path, "words")
    path.write_text("# nothing\n")
    with pytest.raises(InputError, match="found none"):
        read_list(path, "words")
    path.write_bytes(b"a\x00\x01b\x00\x02\xff")
    with pytest.raises(InputError, match=r"list\.txt: expected"):
        read_list(path, "words")


def test_unknown_names_and_words_are_told() -> None:
    with pytest.raises(InputError, match="takes in the list that are not in the corpus: nobody"):
        named_fold(takes(4), ["take01", "nobody"])
    with pytest.raises(InputError, match="words in the list that are not in the corpus: w0, w1, w2, w3, w4 and 2 more"):
        check_words([f"w{i}" for i in range(7)], {"ma"})


def test_splits_that_leave_nothing_are_refused() -> None:
    with pytest.raises(InputError, match="none is left to learn from"):
        named_fold(takes(2), ["take00", "take01"])
    with pytest.raises(InputError, match="none is left to learn from"):
        words_fold([spoken("a", ("ma",)), spoken("b", ("ma", "tea"))], ["ma"])
    with pytest.raises(InputError, match="test set is empty"):
        named_fold(takes(2), [])
    with pytest.raises(InputError, match="at least 8 takes"):
        random_folds(takes(4), 1, np.random.default_rng(0))
    with pytest.raises(InputError, match="at least 8 words, the corpus has 4"):
        words_folds(takes(16), 1, np.random.default_rng(0))
    for folds in (0, PARTS + 1):
        with pytest.raises(InputError, match="from 1 to 8"):
            random_folds(takes(16), folds, np.random.default_rng(0))


def test_the_hardest_words_are_those_of_which_nothing_is_said_elsewhere() -> None:
    vocabulary = [("tea", "ma"), ("me", "ma"), ("me", "tea"), ("tea", "me"), ("ta", "me"), ("me", "tea")]
    said = [spoken(f"take{i}", words) for i, words in enumerate(vocabulary)]
    assert hardest_words(said, 1) == ("ma",)  # AA is said only once without it, and M AA never
    assert hardest_words(said)[:2] == ("ma", "ta")
    fold = words_fold(said, hardest_words(said))
    assert len(fold.train) >= len(said) / 2


def test_words_that_are_in_every_take_cannot_be_left_out() -> None:
    with pytest.raises(InputError, match="none can be left out"):
        hardest_words([spoken("one", ("ma", "me")), spoken("two", ("me", "ma"))])
