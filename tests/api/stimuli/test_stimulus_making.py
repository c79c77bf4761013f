from __future__ import annotations

import csv
import json
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mien.api.stimuli import Stimulus, make_stimuli, read_design
from mien.api.stimuli.row_performance import performed
from mien.cli import main
from mien.core.errors import InputError
from mien.core.files import replace_when_complete
from mien.face.library import load_face
from mien.face.storage import write_face
from tests.serve.modules.speaking import toy_voice

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
        ("sentence,face\nOh.,amarra\n", "line 2: unknown face 'amarra': did you mean 'amara'"),
        ("sentence,face\nOh.,amara+mei:9\n", "line 2: a blend of two faces"),
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
    made, _ = performed(Stimulus("a", "Now.", offset_ms=offset, performer="hand-made"))
    speech = made.utterance
    heard = np.flatnonzero(np.abs(speech.audio.samples) > 0.01)
    seen = [phone for phone in speech.phones if phone.label != "SIL"]
    rate = speech.audio.rate
    assert heard[0] / rate == pytest.approx(seen[0].start + offset / 1000, abs=0.003)
    assert heard[-1] / rate == pytest.approx(seen[-1].end + offset / 1000, abs=0.003)
    assert len(made.channels) == made.rate.frames_covering(speech.duration)


@pytest.mark.usefixtures("toy_voice")
def test_a_mcgurk_pair() -> None:
    made, heard = performed(Stimulus("a", "Go.", heard="Bananas.", performer="hand-made"))
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
def test_batch_says_every_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "lines.txt").write_text("Oh.\n # a remark\nNo <HeadNod/> no.\n")
    monkeypatch.setattr(
        "mien.api.stimuli.stimulus_making._write_picture", lambda s, animation, path: path.write_bytes(b"film")
    )
    command = ["batch", str(tmp_path / "lines.txt"), "-o", str(tmp_path / "out"), "--workers", "0"]
    assert main([*command, "--emotion", "sad:0.5", "--performer", "hand-made"]) == 0
    assert "lines.txt: lines passed over because they start with #: 1\n" in capsys.readouterr().err
    assert sorted(p.name for p in (tmp_path / "out").glob("*.csv")) == [
        "line00001.csv",
        "line00003.csv",
        "manifest.csv",
    ]


@pytest.mark.usefixtures("toy_voice")
def test_a_run_killed_after_any_file_goes_on_to_the_same_bits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = "name,sentence,still_ms,performer,width,height\na,Oh.|No.,100,hand-made,32,32\n"
    path = design(tmp_path, text)
    make_stimuli(path, tmp_path / "whole", lists=1, workers=0)
    written: list[int] = []

    class Killed(BaseException):
        pass

    @contextmanager
    def dying(target: Path) -> Iterator[Path]:
        with replace_when_complete(target) as unfinished:
            yield unfinished
        written.append(1)
        if len(written) == limit:
            raise Killed

    monkeypatch.setattr("mien.api.stimuli.stimulus_making.replace_when_complete", dying)
    for limit in range(1, 7):
        folder = tmp_path / f"killed{limit}"
        written.clear()
        with pytest.raises(Killed):
            make_stimuli(path, folder, lists=1, workers=0)
        written.append(0)  # past the limit: it lives from here on
        kept = make_stimuli(path, folder, lists=1, workers=0).kept
        assert len(kept) == limit // 3
        for first in sorted((tmp_path / "whole").iterdir()):
            assert first.read_bytes() == (folder / first.name).read_bytes(), (limit, first.name)


@pytest.mark.usefixtures("toy_voice")
def test_a_face_file_of_other_content_is_another_stimulus(tmp_path: Path) -> None:
    face = load_face("default")
    write_face(face, tmp_path / "my.npz")
    row = Stimulus(
        "a", "Oh.", face=str(tmp_path / "my.npz"), performer="hand-made", still_ms="100", width=32, height=32
    )
    make_stimuli([row], tmp_path / "out", workers=0)
    assert make_stimuli([row], tmp_path / "out", workers=0).kept == ("a",)
    write_face(replace(face, licence="another"), tmp_path / "my.npz")
    assert make_stimuli([row], tmp_path / "out", workers=0).made == ("a",)


@pytest.mark.usefixtures("toy_voice")
def test_every_factor_changes_what_comes_out(tmp_path: Path) -> None:
    write_face(load_face("default"), tmp_path / "other.npz")
    plain = {"name": "plain", "performer": "hand-made", "still_ms": "350", "width": 64, "height": 48}
    text = "I know this."
    changed: dict[str, Any] = {
        "emotion": "happy", "intensity": 0.5, "au": "AU12:0.7", "rate": 2.0, "crop": "eyes", "background": "black",
        "width": 96, "still_ms": "500", "seed": 3, "fps": "60", "offset_ms": -100.0,
    }  # fmt: skip
    rows = [Stimulus(sentence=text, **plain), Stimulus(sentence="Oh bananas.", **{**plain, "name": "sentence"})]
    for name, value in changed.items():
        more = {"emotion": "sad"} if name == "intensity" else {}
        rows.append(Stimulus(sentence=text, **{**plain, **more, name: value, "name": name}))
    assert make_stimuli(rows, tmp_path / "out", workers=0).failed == ()
    facts = [json.loads((tmp_path / "out" / f"{row.name}.json").read_text()) for row in rows]
    logs = {row.name: (tmp_path / "out" / f"{row.name}.csv").read_bytes() for row in rows}
    assert len({fact["fingerprint"] for fact in facts}) == len(rows)
    pictures = {row.name: (tmp_path / "out" / row.file).read_bytes() for row in rows}
    same_motion = {"plain", "crop", "background", "width", "still_ms"}
    assert len({logs[name] for name in same_motion}) == 1
    assert len({log for name, log in logs.items() if name not in same_motion} | {logs["plain"]}) == len(rows) - 4
    assert len(set(pictures.values())) == len(rows)


@pytest.mark.usefixtures("toy_voice")
def test_further_formats_lie_beside_the_picture(tmp_path: Path) -> None:
    row = Stimulus("a", "Oh.", performer="hand-made", still_ms="100", width=32, height=32)
    make_stimuli([row], tmp_path, formats=[".csv", ".json", ".wav"], workers=0)
    found = {path.name for path in tmp_path.iterdir()}
    assert found == {"a.png", "a.csv", "a.json", "a-livelink.csv", "a-take.json", "a.wav", "manifest.csv"}
    assert make_stimuli([row], tmp_path, formats=[".wav"], workers=0).kept == ("a",)
    assert make_stimuli([row], tmp_path, formats=[".fap"], workers=0).made == ("a",)
    with pytest.raises(InputError, match="unknown output format"):
        make_stimuli([row], tmp_path, formats=[".mp5"], workers=0)


def test_a_spreadsheet_with_semicolons_and_a_byte_order_mark(tmp_path: Path) -> None:
    path = tmp_path / "design.csv"
    path.write_bytes("\ufeffname;sentence;crop\r\na;Oh, no.;oval|eyes\r\n;;\r\n".encode())
    assert [(row.name, row.sentence, row.crop) for row in read_design(path)] == [
        ("a-001", "Oh, no.", "oval"),
        ("a-002", "Oh, no.", "eyes"),
    ]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("sentence,crop\nOh.,mouht\n", "line 2: unknown camera 'mouht': did you mean 'mouth'"),
        ("sentence,background\nOh.,grayish\n", "line 2: a background is a colour"),
        ("sentence,sentence\nOh.,Oh.\n", "line 1: the column 'sentence' is there 2 times"),
        ("sentence,emotion\nOh.|,sad\n", "line 2: one level of the sentence is empty"),
        ('sentence\n"Oh\n', "expected a table"),
        ("", "the column 'sentence' is missing"),
    ],
)
def test_more_faults_of_a_design(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(InputError) as problem:
        read_design(design(tmp_path, text))
    assert words in str(problem.value)


def test_a_cluster_that_loses_a_worker_gives_the_same_bits(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    plain: dict[str, Any] = {"voice": "espeak", "performer": "hand-made", "still_ms": "300", "width": 32, "height": 32}
    texts = ["Oh.", "No.", "Yes.", "I see."] * 2
    rows = [Stimulus(f"s{number}", text, seed=number, **plain) for number, text in enumerate(texts)]
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, host="127.0.0.1"
    ) as cluster:

        def lose_one(done: int, _: int) -> None:
            if done == 1:
                os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)

        address = cluster.scheduler_address
        report = make_stimuli(rows, tmp_path / "there", cluster=address, progress=lose_one)
    assert (len(report.made), report.failed) == (8, ())
    assert make_stimuli(rows, tmp_path / "here", workers=0).failed == ()
    for first in sorted((tmp_path / "here").iterdir()):
        assert first.read_bytes() == (tmp_path / "there" / first.name).read_bytes(), first.name
