"""``mien live`` as a person uses it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from mien.cli import main
from mien.core.audio import Audio
from mien.formats.native import read_native

RATE = 16_000


def sound(seconds: float = 1.0) -> Audio:
    times = np.arange(round(seconds * RATE)) / RATE
    return Audio(0.1 * sum(np.sin(2 * np.pi * 120 * k * times) / k for k in range(1, 20)), RATE)


def test_a_file_is_performed_and_recorded(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = tmp_path / "sound.wav", tmp_path / "out.json"
    sound().write(path)
    code = main(["live", str(path), "--no-websocket", "-o", str(out), "--also", str(tmp_path / "out.TextGrid"),
                 "--performer", "hand-made", "--emotion", "happy:0.5"])  # fmt: skip
    told = capsys.readouterr()
    assert code == 0, told.err
    assert "listening to sound.wav, 150 ms look-ahead" in told.out
    assert "ms behind the sound" in told.err
    made = read_native(out)
    assert made.utterance.duration >= 1.0
    assert made.utterance.timing == "recognised"
    assert [span.name for span in made.score.emotions] == ["happy"]
    assert (tmp_path / "out.TextGrid").exists()


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["nothere.wav"], "no such file or pipe"),
        (["-", "--look-ahead", "30"], "between 50 and 300 ms, not 30"),
        (["-", "--also", "x.csv"], "give the first with -o"),
        (["-", "-o", "x.foo"], "unknown output format"),
        (["-", "--device", "2"], "leave it out"),
        (["--follow"], "not for a microphone"),
        (["-", "--emotion", "hapy"], "did you mean 'happy'"),
        (["-", "--emotion", "happy[0-1]"], "one intensity throughout"),
        (["-", "--no-websocket"], "nothing to stream to"),
        (["-", "--host", "0.0.0.0"], "--token"),
        (["-", "--format", "s16"], "did you mean 's16le'"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(
    options: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["live", *options, "--performer", "hand-made"]) == 2
    error = capsys.readouterr().err
    assert told in error
    assert error.count("\n") == 1


def test_ctrl_c_ends_a_live_stream_and_keeps_its_recording(tmp_path: Path) -> None:
    out = tmp_path / "out.csv"
    command = [sys.executable, "-m", "mien", "live", "-", "--no-websocket", "-o", str(out), "--performer", "hand-made"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        assert running.stdin is not None
        assert running.stdout is not None
        data = np.round(sound(0.5).samples * 2**15).astype("<i2").tobytes()
        running.stdout.readline()  # it listens
        running.stdin.write(data)
        running.stdin.flush()
        time.sleep(1.0)
        os.kill(running.pid, signal.SIGINT)
        told = running.stderr.read().decode() if running.stderr else ""
        code = running.wait(60)
    assert code == 0, told
    assert len(out.read_text().splitlines()) > 5
