"""Anything scored against anything, from files and from the command line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import mien
from mien.animation.animation import imported
from mien.cli.main import main
from mien.core.errors import InputError
from mien.core.tracks import ChannelTrack
from mien.face.library import load_face
from mien.metrics.face_track import FaceTrack
from mien.metrics.scoring import TASKS, score, score_folders
from tests.metrics.faces_in_motion import JAW, RATE, TIMES


def motion(size: float = 1.0) -> ChannelTrack:
    curves = {"jawOpen": size * JAW, "browInnerUp": 0.3 + 0.2 * np.sin(3 * TIMES), "headYaw": 4 * np.sin(2 * TIMES)}
    return ChannelTrack(tuple(curves), np.stack(list(curves.values()), axis=1), RATE)


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scored")
    animation = imported(motion(), "a test")
    for suffix in ("json", "csv", "c3d"):
        mien.save(animation, folder / f"one.{suffix}", face=load_face())
    mien.save(imported(motion(0.5), "a test"), folder / "half.json")
    return folder


@pytest.mark.parametrize("reference", ["json", "csv", "c3d"])
@pytest.mark.parametrize("estimate", ["json", "csv", "c3d"])
def test_the_same_motion_in_any_two_formats_is_the_same(files: Path, reference: str, estimate: str) -> None:
    scores = score(files / f"one.{reference}", files / f"one.{estimate}").flat()
    assert scores["opening_r"] > 0.99
    assert scores["opening_spread"] == pytest.approx(1.0, abs=0.03)
    assert scores["inner_brow_r"] > 0.97
    assert scores["yaw_r"] > 0.99
    assert abs(scores["lag_ms"]) < 5


def test_the_table_can_be_printed_and_says_what_does_not_apply() -> None:
    still = FaceTrack.of_channels(ChannelTrack(("jawOpen",), JAW[:, None] / 2, RATE), "mine")
    text = str(score(FaceTrack.of_channels(motion(), "recording"), still))
    assert "| opening (mm) | 1.00 | 1.00 | 0.5" in text
    assert "not scored: head: mine does not say how the head moves" in text
    assert "phones are known of neither" in text


def test_every_task_is_asked() -> None:
    assert set(score(motion(), motion()).scores) == set(TASKS)


def test_the_command_prints_tables_json_and_csv(files: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one, half = str(files / "one.json"), str(files / "half.json")
    assert main(["score", one, half, "-o", str(files / "scores.csv")]) == 0
    assert "| opening (mm) | 1.00" in capsys.readouterr().out
    assert main(["score", one, half, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["scores"]["mouth"]["opening_spread"] == pytest.approx(0.5, abs=0.02)
    assert told["scores"]["sync"]["onset_lag_ms"] is None if "onset_lag_ms" in told["scores"]["sync"] else True
    lines = (files / "scores.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "reference,estimate,task,figure,unit,value"
    assert any(",mouth,opening_bias,mm,-" in line for line in lines)


def test_folders_are_compared_by_name(tmp_path: Path, files: Path) -> None:
    for folder, size in (("a", 1.0), ("b", 0.5)):
        (tmp_path / folder).mkdir()
        mien.save(imported(motion(size), "a test"), tmp_path / folder / "line.json")
    mien.save(imported(motion(), "a test"), tmp_path / "a" / "alone.json")
    found, missing = score_folders(tmp_path / "a", tmp_path / "b")
    assert len(found) == 1
    assert missing == ("alone",)
    assert main(["score", str(tmp_path / "a"), str(tmp_path / "b")]) == 0


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("nothing.json", None, "there is nothing of that name"),
        ("text.json", "hello", "is not a whole mien-animation file"),
        ("table.csv", "a,b\n1,2\n", "expected an animation"),
        ("notes.txt", "hello", "expected an animation"),
    ],
)
def test_what_cannot_be_scored_is_one_line(
    tmp_path: Path, files: Path, capsys: pytest.CaptureFixture[str], name: str, content: str | None, said: str
) -> None:
    if content is not None:
        (tmp_path / name).write_text(content, encoding="utf-8")
    assert main(["score", str(files / "one.json"), str(tmp_path / name)]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_two_that_share_nothing_are_refused() -> None:
    brows = FaceTrack.of_channels(motion(), "brows").only(["4.1"])
    lips = FaceTrack.of_channels(ChannelTrack(("jawOpen",), JAW[:, None], RATE), "lips").only(["2.2", "2.3"])
    with pytest.raises(InputError, match="nothing to score"):
        score(brows, lips)
