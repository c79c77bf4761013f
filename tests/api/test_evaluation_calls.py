"""`mien.evaluate` is what the command line calls."""

from __future__ import annotations

from pathlib import Path

import pytest

import mien
from mien.corpus.recordings import Corpus
from tests.metrics.synthetic import corpus


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Corpus:
    return corpus(tmp_path_factory.mktemp("corpus") / "c", 6)


def test_models_are_learned_and_scored(made: Corpus) -> None:
    found = mien.evaluate(made, protocol="random", test_names=["take00"], models=["cosine"])
    assert found.takes == 1
    assert found.scores["cosine"]["opening_r"].value > 0.9
    hardest = mien.evaluate(made.folder, protocol="leave-words-out", words="hardest", models=["mean pose"])
    assert hardest.folds[0].words


def test_a_performer_is_scored_by_its_name(made: Corpus) -> None:
    found = mien.evaluate("hand-made", made)
    assert found.takes == 6
    assert "hand-made" in found.scores


@pytest.mark.parametrize(
    ("subject", "heldout", "options", "said"),
    [
        ("hand-made", None, {}, "name the corpus of held-out takes"),
        ("hand-made", "c", {"folds": 2}, "--folds is for learning afresh"),
        ("c", None, {}, "learning afresh needs --protocol"),
        ("c", "c", {"protocol": "random"}, "a second corpus is for a performer"),
        ("c", None, {"protocol": "random", "words": "hardest"}, "--words is for --protocol leave-words-out"),
        ("c", None, {"protocol": "random", "seed": -1}, "a seed is a whole number"),
    ],
)
def test_options_that_do_not_go_together_are_refused(
    subject: str, heldout: str | None, options: dict[str, object], said: str
) -> None:
    with pytest.raises(mien.InputError, match=said):
        mien.evaluate(Path(subject) if subject == "c" else subject, heldout, **options)  # type: ignore[arg-type]
