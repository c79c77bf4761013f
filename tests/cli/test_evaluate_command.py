from __future__ import annotations

from pathlib import Path

import pytest

from mien.cli import main
from tests.metrics.synthetic import corpus


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return corpus(tmp_path_factory.mktemp("corpus") / "c").folder


def evaluate(folder: Path, *options: str) -> int:
    return main(["evaluate", str(folder), "--models", "cosine,mean pose", *options])


def test_random_takes(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report = tmp_path / "results.md"
    report.write_text("# Results\n")
    assert evaluate(folder, "--protocol", "random", "--seed", "3", "--report", str(report)) == 0
    out, err = capsys.readouterr()
    assert out.startswith("### Unseen takes\n\n2 takes, ")
    assert "Learned from 14 takes, scored on 2." in out
    assert "written" in err
    assert out.strip() in report.read_text()
    assert "(results-random.png)" in report.read_text()
    assert (tmp_path / "results-random.png").stat().st_size > 5000
    assert evaluate(folder, "--protocol", "random", "--seed", "3", "--quiet") == 0
    assert capsys.readouterr().out == out


def test_named_takes_and_words(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names, words = tmp_path / "names.txt", tmp_path / "words.txt"
    names.write_text("take01\ntake05\ntake09\n")
    words.write_text("Tea")
    assert evaluate(folder, "--protocol", "random", "--test-names", str(names)) == 0
    assert "Learned from 13 takes, scored on 3." in capsys.readouterr().out
    assert evaluate(folder, "--protocol", "leave-words-out", "--words", str(words)) == 0
    out = capsys.readouterr().out
    assert "inside the words tea." in out
    assert "frames of all takes pooled" in out
    assert "onset" not in out


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ([], "learning afresh needs --protocol random or --protocol leave-words-out"),
        (["--protocol", "random", "--words", "LIST"], "--words is for --protocol leave-words-out"),
        (["--protocol", "leave-words-out", "--test-names", "LIST"], "--test-names is for --protocol random"),
        (["--protocol", "random", "--test-names", "LIST", "--folds", "2"], "--folds deals the test at random"),
        (["--protocol", "random", "--folds", "9"], "from 1 to 8, not 9"),
        (["--protocol", "random", "--test-names", "LIST"], "takes in the list that are not in the corpus: nothing"),
        (["--protocol", "leave-words-out", "--words", "LIST"], "words in the list that are not in the corpus: nothing"),
        (["--protocol", "leave-words-out", "--words", "EMPTY"], "found none"),
        (["--protocol", "leave-words-out"], "at least 8 words, the corpus has 4"),
        (["--protocol", "random", "--seed", "-1"], "a seed is a whole number"),
        (["--protocol", "random", "--report", "results.txt"], "give --report NAME.md"),
        (["--protocol", "random", "--models", "mean pose,cosin"], "did you mean 'cosine'"),
    ],
)
def test_bad_input_is_told_in_one_line(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], reason: str
) -> None:
    (tmp_path / "LIST").write_text("nothing")
    (tmp_path / "EMPTY").write_text("# none\n")
    options = [str(tmp_path / o) if o in ("LIST", "EMPTY") else o for o in options]
    assert evaluate(folder, *options) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("mien: error: ")
    assert reason in err
    assert err.count("\n") == 1


def test_a_second_corpus_is_for_a_performer(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evaluate", str(folder), "other", "--protocol", "random"]) == 2
    assert "other: a second corpus is for a performer" in capsys.readouterr().err


def test_a_folder_that_is_no_corpus_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert evaluate(tmp_path, "--protocol", "random") == 2
    assert "mien corpus import" in capsys.readouterr().err


def test_a_performer_needs_held_out_takes_and_no_protocol(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    performer = str(tmp_path / "anna.mien")
    assert main(["evaluate", performer]) == 2
    assert "name the corpus of held-out takes too" in capsys.readouterr().err
    assert main(["evaluate", performer, "held", "--folds", "2"]) == 2
    assert "--folds is for learning afresh" in capsys.readouterr().err
    assert main(["evaluate", performer, "held"]) == 2
    assert "no such file" in capsys.readouterr().err


def test_a_learned_performer_is_scored_on_held_out_takes_only(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from mien.corpus.recordings import Corpus
    from mien.motion.learning import learn
    from mien.motion.performer_file import save_learned

    made = Corpus(folder)
    performer = tmp_path / "anna.mien"
    save_learned(learn([made.take(name) for name in made.names[:8]], name="anna"), performer)
    held = Corpus.create(tmp_path / "held", {"layout": "mediapipe-218"})
    for name in made.names[8:12]:
        held.add(made.take(name))
    assert main(["evaluate", str(performer), str(held.folder)]) == 0
    out = capsys.readouterr().out
    assert out.startswith("### Performer anna on held-out takes\n\n4 takes, ")
    assert "| speech motion |" in out
    held.add(made.take(made.names[2]))
    assert main(["evaluate", str(performer), str(held.folder)]) == 2
    assert f"was learned from takes of {held.folder}: {made.names[2]}; score it on takes" in capsys.readouterr().err
