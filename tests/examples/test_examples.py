"""The examples are run, or as much of them as needs no other program."""

from __future__ import annotations

import csv
import importlib.util
import shutil
import socket
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import mien
from mien.api.stimuli import make_stimuli, read_design
from mien.api.stimuli.row_performance import performed
from mien.cli import main
from mien.serve.modules.transport import Sender
from mien.text.commands import Command, CommandLibrary
from tests.examples.fake_psychopy import Session, install
from tests.serve.modules.speaking import toy_voice

__all__ = ["toy_voice"]
EXAMPLES = Path(__file__).parents[2] / "examples"
SIX = EXAMPLES / "six_expressions"


def loaded(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def experiment(tmp_path: Path) -> ModuleType:
    """A copy of the experiment with stimuli that are only names."""
    shutil.copytree(SIX, tmp_path / "six")
    module = loaded(tmp_path / "six" / "experiment.py")
    (module.HERE / "stimuli").mkdir()
    for stimulus in read_design(module.HERE / "design.csv"):
        (module.HERE / "stimuli" / stimulus.file).touch()
    return module


def order_of(module: ModuleType, seed: int) -> list[dict[str, str]]:
    with (module.HERE / "conditions.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    return [rows[number] for number in np.random.default_rng(seed).permutation(len(rows))]


def test_every_condition_is_a_stimulus_of_the_design(experiment: ModuleType) -> None:
    made = {f"stimuli/{stimulus.file}" for stimulus in read_design(SIX / "design.csv")}
    conditions = order_of(experiment, 0)
    assert {row["stimulus"] for row in conditions} == made
    assert len(conditions) == len(made) == 24
    assert all(experiment.KEYS[row["correct_key"]] == row["expression"] for row in conditions)
    assert not experiment.missing(conditions)


def test_a_participant_who_knows_the_answers(experiment: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    session = Session()
    install(monkeypatch, session)
    trials = order_of(experiment, 7)
    session.keys = ["space", *(key for row in trials for key in (row["correct_key"], "6")), "space"]
    assert experiment.run("p01", 7) == 24
    with (experiment.HERE / "data" / "p01-today.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["stimulus"] for row in rows] == [row["stimulus"] for row in trials]
    assert {(row["correct"], row["naturalness"], row["participant"]) for row in rows} == {("1", "6", "p01")}
    assert [name for name in session.shown if "-static-" in name or "-dynamic-" in name] == [
        Path(row["stimulus"]).name for row in trials
    ]
    stills = [row for row in rows if row["presentation"] == "static"]
    films = [row for row in rows if row["presentation"] == "dynamic"]
    assert all(float(row["longest_frame_ms"]) == pytest.approx(1000 / 60, abs=0.01) for row in films)
    assert all(len(row["frame_intervals_ms"].split()) == 3 for row in films), "every flip of a film is written down"
    assert all(float(row["shown_seconds"]) >= experiment.STILL_SECONDS for row in stills)
    assert session.closed == 1


def test_escape_ends_and_keeps_what_was_answered(experiment: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    session = Session()
    install(monkeypatch, session)
    session.keys = ["space", "a", "1", "escape"]
    assert experiment.run("p02", 1) == 1
    assert len((experiment.HERE / "data" / "p02-today.csv").read_text().splitlines()) == 2
    assert session.closed == 1


def test_stimuli_that_were_not_made_are_told(experiment: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    install(monkeypatch, Session())
    (experiment.HERE / "stimuli" / "sad-static-001.png").unlink()
    with pytest.raises(SystemExit, match=r"sad-static-001.png is not there: run 'mien stimuli"):
        experiment.run("p03", 1)


def test_the_design_made_small(tmp_path: Path) -> None:
    """A film and its picture; at the time of the pictures the expression is there and no eye blinks."""
    small = [replace(item, width=48, height=64, fps="5") for item in read_design(SIX / "design.csv")]
    chosen = [item for item in small if item.name in ("happy-dynamic-001", "happy-static-001")]
    made = make_stimuli(chosen, tmp_path, workers=0)
    assert not made.failed
    assert {path.name for path in tmp_path.iterdir()} >= {"happy-dynamic-001.mp4", "happy-static-001.png"}
    for stimulus in small:
        if stimulus.still_ms and stimulus.seed == 1:
            animation, _ = performed(replace(stimulus, fps="25"))
            names, values = animation.channels.names, animation.channels.values
            assert values[35, names.index("eyeBlinkLeft")] < 0.35
            assert np.abs(values[35] - values[8]).sum() > 0.5, stimulus.name


@pytest.mark.usefixtures("toy_voice")
def test_the_mcgurk_pairs_are_seen_and_heard_apart(tmp_path: Path) -> None:
    rows = read_design(EXAMPLES / "mcgurk" / "design.csv")
    assert len(rows) == 10
    (pair,) = [row for row in rows if row.name == "mcgurk-003"]
    assert (pair.offset_ms, pair.crop) == (0, "mouth")
    seen, heard = performed(replace(pair, performer="hand-made"))
    assert {phone.label for phone in seen.utterance.phones} >= {"G"}
    assert {phone.label for phone in heard.utterance.phones} >= {"B"}


def test_the_command_of_ones_own() -> None:
    library = CommandLibrary.of(EXAMPLES / "own_command")
    curves = library.translate(Command("Sniff", (("at", "500"),))).curves
    assert {curve.parameter for curve in curves} >= {"noseSneerLeft", "HeadNod"} or {
        curve.parameter for curve in curves
    } == {"noseSneer", "mouthUpperUp", "HeadNod"}


@pytest.mark.usefixtures("toy_voice")
def test_ten_lines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    saved = list[str]()
    monkeypatch.setattr(mien, "save", lambda line, *paths: saved.extend(path.name for path in paths))
    loaded(EXAMPLES / "ten_lines.py")
    assert saved == ["line.mp4", "line.glb"]
    assert "true" in capsys.readouterr().out


def test_the_listener_shows_frames_and_answers() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
    listener = subprocess.Popen(
        [sys.executable, str(EXAMPLES / "frames_listener.py"), str(port)], stdout=subprocess.PIPE, text=True
    )
    answers = list[str | None]()
    sender = Sender("127.0.0.1", port)
    lines = [
        '{"utterance": "1", "channels": ["jawOpen"], "frames": 1}',
        '{"frame": 0, "time": 0, "values": [0.5]}',
        '{"end": "1", "frames": 1}',
    ]
    sending = threading.Thread(
        target=lambda: sender.send("\n".join(lines), "0000abcd:1", lambda why, _: answers.append(why))
    )
    sending.start()
    sending.join(20)
    sender.close()
    shown, _ = listener.communicate(timeout=20)
    assert answers == [None]
    assert "0.000 s  ##############################" in shown


def test_the_commands_of_the_page_are_read(tmp_path: Path) -> None:
    """An option that a README names and the program lacks would end with 2 here."""
    assert main(["say", "Well.", "--commands", str(tmp_path / "none"), "-o", str(tmp_path / "a.wav")]) == 2
