from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from mien.cli import main
from mien.errors import InputError
from mien.stimuli import Stimulus, make_stimuli, performed, read_design
from tests.modules.speaking import toy_voice

__all__ = ["toy_voice"]


def design(folder: Path, text: str) -> Path:
    path = folder / "design.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_levels_are_crossed_and_rows_are_listed(tmp_path: Path) -> None:
    text = "name,sentence,emotion,offset_ms\na,Oh no.|Oh yes.,happy|sad,0|200\nb,Oh.,,\n"
    found = read_design(design(tmp_path, text))
    assert len(found) == 9
    assert found[0].name == "a-001"
    assert found[-1].name == "b"
    assert len({(s.sentence, s.emotion, s.offset_ms) for s in found}) == 9


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("text\nOh.\n", "line 1: unknown column 'text'"),
        ("emotion\nhappy\n", "line 1: the column 'sentence' is missing"),
        ("sentence,emotoin\nOh.,sad\n", "did you mean 'emotion'"),
        ("sentence,intensity\nOh.,strong\n", "line 2: intensity is a number, not 'strong'"),
        ("sentence,intensity\nOh.,3\n", "line 2: intensity runs from 0 to 1"),
        ("sentence,emotion\nOh, no.,sad\n", "line 2: expected as many cells"),
        ("name,sentence\na,Oh.\na,No.\n", "line 3: the name 'a' is used at"),
        ("name,sentence\n../a,Oh.\n", "line 2: a name is letters"),
        ("sentence,width\nOh.,333\n", "even numbers"),
        ("sentence\n", "no stimulus"),
    ],
)
def test_a_design_with_a_fault_names_line_and_column(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(InputError) as problem:
        read_design(design(tmp_path, text))
    assert words in str(problem.value)


@pytest.mark.usefixtures("toy_voice")
@pytest.mark.parametrize("offset", [-150.0, 0.0, 40.0, 500.0])
def test_the_sound_is_off_by_what_was_asked_and_nothing_of_it_is_lost(offset: float) -> None:
    made, _ = performed(Stimulus("a", "Now.", offset_ms=offset, performer="authored"))
    speech = made.utterance
    heard = np.flatnonzero(np.abs(speech.audio.samples) > 0.01)
    seen = [phone for phone in speech.phones if phone.label != "SIL"]
    rate = speech.audio.rate
    assert heard[0] / rate == pytest.approx(seen[0].start + offset / 1000, abs=0.003)
    assert heard[-1] / rate == pytest.approx(seen[-1].end + offset / 1000, abs=0.003)
    assert len(made.channels) == made.rate.frames_covering(speech.duration)


@pytest.mark.usefixtures("toy_voice")
def test_a_mcgurk_pair() -> None:
    made, heard = performed(Stimulus("a", "Go.", heard="Bananas.", performer="authored"))
    assert [word.label for word in made.utterance.words] == ["go"]
    assert [word.label for word in heard.utterance.words] == ["bananas"]
    loud = np.flatnonzero(np.abs(made.utterance.audio.samples) > 0.01)
    assert loud[-1] / 8000 == pytest.approx(heard.utterance.words.intervals[-1].end, abs=0.003)


@pytest.mark.usefixtures("toy_voice")
def test_files_logs_the_same_bits_and_going_on(tmp_path: Path) -> None:
    text = (
        "name,sentence,emotion,still_ms,au,width,height\na,Oh.|No.,sad|happy,300,AU12:0.5,160,160\nb,Oh.,,,,160,160\n"
    )
    path = design(tmp_path, text)
    for folder in ("one", "two"):
        report = make_stimuli(path, tmp_path / folder, lists=2, workers=0)
        assert (len(report.made), report.failed) == (5, ())
    for first in sorted((tmp_path / "one").iterdir()):
        assert first.read_bytes() == (tmp_path / "two" / first.name).read_bytes(), first.name
    facts = json.loads((tmp_path / "one" / "b.json").read_text())
    log = list(csv.DictReader((tmp_path / "one" / "b.csv").open()))
    assert len(log) == facts["frames"]
    assert {"phone", "jawOpen", "headYaw"} <= set(log[0])
    assert "OW" in {row["phone"] for row in log}
    (tmp_path / "one" / "b.mp4").write_bytes(b"touched")
    again = make_stimuli(path, tmp_path / "one", workers=0)
    assert again.made == ("b",)
    assert len(again.kept) == 4
    lists = [list(csv.DictReader((tmp_path / "one" / f"list-{n}.csv").open())) for n in (1, 2)]
    assert sorted(row["name"] for rows in lists for row in rows) == ["a-001", "a-002", "a-003", "a-004", "b"]


@pytest.mark.usefixtures("toy_voice")
def test_one_fault_does_not_stop_the_others(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = design(tmp_path, "name,sentence,still_ms,width,height\na,Oh.,99000,160,160\nb,Oh.,10,160,160\n")
    assert main(["stimuli", str(path), "-o", str(tmp_path / "out"), "--workers", "0"]) == 2
    told = capsys.readouterr()
    assert "a: " in told.err
    assert "line 2: still_ms=99000 lies outside the sound" in told.err
    assert "made 1, kept 0, failed 1" in told.out
    assert not (tmp_path / "out" / "a.png").exists()


@pytest.mark.usefixtures("toy_voice")
def test_batch_says_every_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "lines.txt").write_text("Oh.\n\nNo <HeadNod/> no.\n")
    monkeypatch.setattr("mien.stimuli._write_picture", lambda s, animation, folder: Path(__file__))
    command = ["batch", str(tmp_path / "lines.txt"), "-o", str(tmp_path / "out"), "--workers", "0"]
    assert main([*command, "--emotion", "sad:0.5", "--performer", "authored"]) == 0
    assert sorted(p.name for p in (tmp_path / "out").glob("*.csv")) == [
        "line00001.csv",
        "line00003.csv",
        "manifest.csv",
    ]
