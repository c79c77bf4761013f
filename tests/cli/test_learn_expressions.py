"""A performer with expressions of its own, from the corpus to the animation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mien
from mien.cli import main
from mien.corpus.recordings import Corpus
from mien.formats.native import read_native
from mien.motion.performers import load_learned_performer
from tests.motion.expressive_takes import LAYOUT, take, takes


@pytest.fixture(scope="module")
def performer(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("expressive")
    corpus = Corpus.create(folder / "corpus", {"layout": LAYOUT})
    for one in takes(4):
        corpus.add(one)
    made = folder / "anna.mien"
    assert main(["learn", str(folder / "corpus"), "-o", str(made), "--speech-model", "coarticulation"]) == 0
    return made


def test_expressions_are_learned_and_told(performer: Path, capsys: pytest.CaptureFixture[str]) -> None:
    learned = load_learned_performer(performer)
    assert learned.expressions is not None
    assert learned.expressions.space.emotions == ("happy", "surprised")
    assert len(learned.trained_on) == 12  # expressive takes too: they must not be scored as held out
    assert learned.emotion_maps is not None
    assert set(learned.emotion_maps.sentences.values()) == {4}
    assert main(["inspect", str(performer)]) == 0
    assert "expressions" in (told := capsys.readouterr().out)
    assert "happy" in told
    assert "neutral to happy" in told


def test_recolor_takes_the_learned_map(performer: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line, happy = tmp_path / "line.json", tmp_path / "happy.json"
    mien.save(mien.say("Me too."), line)
    assert main(["recolor", str(line), "--to", "happy", "--performer", str(performer), "-o", str(happy)]) == 0
    assert "learned from recordings: neutral to happy (4 sentences)" in capsys.readouterr().err
    smile = [read_native(path).channels.channel("mouthSmileLeft").mean() for path in (line, happy)]
    assert 0.25 < smile[1] - smile[0] < 0.75


def test_the_performer_smiles_as_recorded_and_borrows_the_rest(performer: Path) -> None:
    happy = mien.say("Me too.", performer=performer, emotion="happy")
    assert happy.channels.channel("mouthSmileLeft").mean() == pytest.approx(0.5, abs=0.2)
    assert not [note for note in happy.notes if "hand-made" in note.message]
    sad = mien.say("Me too.", performer=performer, emotion="sad")
    assert [note.message for note in sad.notes if "hand-made" in note.message] == [
        "sad was not recorded for this performer: its motion is hand-made"
    ]


def test_saved_and_loaded_it_moves_alike(performer: Path, tmp_path: Path) -> None:
    from mien.motion.performer_file import save_learned

    learned = load_learned_performer(performer)
    save_learned(learned, tmp_path / "again.mien")
    again = load_learned_performer(tmp_path / "again.mien")
    assert learned.expressions is not None
    assert again.expressions is not None
    one, other = (
        x.space.sample("happy", 3.0, np.random.default_rng(1)) for x in (learned.expressions, again.expressions)
    )
    np.testing.assert_array_equal(one.carried, other.carried)
    assert (tmp_path / "again.mien").read_bytes() == performer.read_bytes()


def test_twins_that_do_not_say_the_same_are_refused_before_the_long_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from dataclasses import replace

    corpus = Corpus.create(tmp_path / "corpus", {"layout": LAYOUT})
    corpus.add(take(1, "neutral"))
    corpus.add(replace(take(2, "happy"), sentence="s1"))
    assert main(["learn", str(tmp_path / "corpus"), "-o", str(tmp_path / "x.mien")]) == 2
    *judged, told = capsys.readouterr().err.splitlines()
    assert all(
        line.startswith(("mien: warning: ", "mien: note: ")) for line in judged
    )  # what is missing is said before it stops
    assert "expected the same sentence in both takes" in told
