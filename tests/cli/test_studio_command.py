"""`mien studio` as a program: opens, answers, ends."""

from __future__ import annotations

import json
import re
import signal
import socket
import subprocess
import sys
import urllib.request

import pytest

from mien.cli import main


@pytest.fixture
def opened(tmp_path, monkeypatch):
    """A studio that is open, and its address."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    command = [sys.executable, "-m", "mien", "studio", "--no-browser", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as program:
        told = program.stdout.readline()
        yield program, re.search(r"http://\S+", told).group(), tmp_path
        program.kill()


@pytest.mark.parametrize("request_to_end", [signal.SIGINT, signal.SIGTERM])
def test_it_opens_answers_and_ends_cleanly(opened, request_to_end):
    program, address, folder = opened
    with urllib.request.urlopen(f"{address}api/about", timeout=60) as answer:
        assert "voices" in json.load(answer)
    assert len([path for path in folder.iterdir() if path.name.startswith("mien-studio-")]) == 1
    program.send_signal(request_to_end)
    _, complaints = program.communicate(timeout=60)
    assert program.returncode == 0
    assert "Traceback" not in complaints
    assert not [path for path in folder.rglob("*") if path.is_file()]
    assert not [path for path in folder.iterdir() if path.name.startswith("mien-studio-")]


def test_a_port_that_is_taken_and_strangers_without_a_token_are_told_in_one_line(capsys):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert main(["studio", "--no-browser", "--port", str(port)]) == 2
    assert f"cannot listen on 127.0.0.1:{port}" in capsys.readouterr().err
    assert main(["studio", "--no-browser", "--host", "0.0.0.0"]) == 2
    assert "give --token" in capsys.readouterr().err
    assert main(["studio", "--no-browser", "--port", "70000"]) == 2
    assert main(["studio", "--no-browser", "--token", "short"]) == 2
