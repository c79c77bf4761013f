from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from mien.cli import main
from mien.motion.performers import load_learned_performer
from tests.metrics.synthetic import corpus


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return corpus(tmp_path_factory.mktemp("corpus") / "c").folder


def learn(folder: Path, *options: str) -> int:
    return main(["learn", str(folder), *options])


def test_a_performer_is_learned_and_speaks(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = tmp_path / "anna.mien"
    assert learn(folder, "-o", str(output)) == 0
    assert "learned from 16 of 16 takes" in capsys.readouterr().out
    assert load_learned_performer(output).name == "anna"
    spoken = ["say", "Me too.", "--performer", str(output), "-o", str(tmp_path / "a.csv"), "--quiet"]
    assert main(spoken) == 0
    assert (tmp_path / "a.csv").exists()


def test_the_same_corpus_gives_the_same_bytes(folder: Path, tmp_path: Path) -> None:
    for name in ("a", "b"):
        assert learn(folder, "-o", str(tmp_path / f"{name}.mien"), "--name", "same", "--quiet") == 0
    assert (tmp_path / "a.mien").read_bytes() == (tmp_path / "b.mien").read_bytes()


def test_words_and_names_are_left_out(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "words.txt").write_text("Tea\n")
    (tmp_path / "names.txt").write_text("take03\n")
    all_but_one, without_word = tmp_path / "n.mien", tmp_path / "w.mien"
    assert learn(folder, "-o", str(all_but_one), "--exclude-names", str(tmp_path / "names.txt")) == 0
    assert "learned from 15 of 16 takes" in capsys.readouterr().out
    assert learn(folder, "-o", str(without_word), "--exclude-words", str(tmp_path / "words.txt")) == 0
    assert len(load_learned_performer(without_word).trained_on) < 16


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["-o", "{dir}/a.csv"], "writes a .mien file"),
        (["-o", "{dir}/a.mien", "--exclude-names", "{dir}/missing.txt"], "no such text file"),
        (["-o", "{dir}/a.mien", "--exclude-names", "{dir}/names.txt"], "nobody"),
    ],
)
def test_what_cannot_be_is_one_line(
    folder: Path, tmp_path: Path, options: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "names.txt").write_text("nobody\n")
    assert learn(folder, *(option.format(dir=tmp_path) for option in options)) == 2
    line = capsys.readouterr().err
    assert words in line
    assert line.count("\n") == 1
    assert not (tmp_path / "a.mien").exists()


def test_a_folder_without_a_corpus_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert learn(tmp_path, "-o", str(tmp_path / "a.mien")) == 2
    assert "mien corpus import" in capsys.readouterr().err


def test_the_speech_model_is_chosen_and_asked_for(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = tmp_path / "curves.mien"
    assert learn(folder, "-o", str(output), "--speech-model", "coarticulation", "--quiet") == 0
    for performer, model in ((str(output), "graph"), ("hand-made", "both")):
        asked = ["say", "Me too.", "--performer", performer, "--speech-model", model, "-o", str(tmp_path / "a.csv")]
        assert main(asked) == 2
        line = capsys.readouterr().err
        assert f"has no speech model '{model}'" in line
        assert line.count("\n") == 1
    assert not (tmp_path / "a.csv").exists()
    written = []
    for model in ("coarticulation", "graph", "both"):
        path = tmp_path / f"{model}.csv"
        assert main(["say", "Me too.", "--speech-model", model, "-o", str(path), "--quiet"]) == 0
        written.append(path.read_bytes())
    assert len(set(written)) == 3
    assert main(["say", "Me too.", "-o", str(tmp_path / "own.csv"), "--quiet"]) == 0
    assert (tmp_path / "own.csv").read_bytes() == written[2]


def test_what_is_missing_is_said_and_several_speakers_are_refused(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    manifest = folder / "manifest.jsonl"
    named = tmp_path / "two"
    shutil.copytree(folder, named)
    lines = manifest.read_text().splitlines()
    lines[0] = lines[0].replace('"speaker": ""', '"speaker": "bob"')
    (named / "manifest.jsonl").write_text("\n".join(lines) + "\n")
    assert learn(named, "-o", str(tmp_path / "a.mien"), "--speech-model", "coarticulation") == 2
    assert "2 speakers: (not named) 15 takes, bob 1 takes" in capsys.readouterr().err
    assert main(["corpus", "check", str(named)]) in (0, 1)
    assert "'mien learn' would refuse it: one mouth cannot be learned from 2 speakers" in capsys.readouterr().out
    mixed = ["-o", str(tmp_path / "b.mien"), "--speech-model", "coarticulation", "--speakers", "mixed"]
    assert learn(named, *mixed) == 0
    told = capsys.readouterr().err
    assert "one mouth is learned from 2 speakers" in told
    assert "phones: 4 of 39, none of" in told


def test_an_import_that_was_killed_is_reported(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    killed = tmp_path / "killed"
    shutil.copytree(folder, killed)
    (killed / "manifest.jsonl").rename(killed / "importing.jsonl")
    for command in (["learn", str(killed), "-o", str(tmp_path / "k.mien")], ["evaluate", "hand-made", str(killed)]):
        assert main(command) == 2
        assert "its import was not finished (16 takes made and not in the corpus yet)" in capsys.readouterr().err
    assert main(["corpus", "check", str(killed)]) == 1
    assert "its import was not finished" in capsys.readouterr().out
