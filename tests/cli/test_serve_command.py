"""``mien serve`` from the command line."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest

from mien.cli import main
from mien.formats.native import write_native
from mien.serve.live.livelink_packets import decode_livelink
from tests.cli.test_main import refused
from tests.faces import tiny_animation


@pytest.fixture
def line(tmp_path: Path) -> str:
    write_native(tiny_animation(), tmp_path / "line.json")
    return str(tmp_path / "line.json")


def test_packets_for_unreal(line: str, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as inbox:
        inbox.bind(("127.0.0.1", 0))
        inbox.settimeout(5)
        port = inbox.getsockname()[1]
        assert main(["serve", line, "--no-websocket", "--livelink", f"127.0.0.1:{port}", "--subject", "anna"]) == 0
        assert decode_livelink(inbox.recv(65536)).subject == "anna"
    assert f"127.0.0.1:{port} (UDP)" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--host", "0.0.0.0"], "give --token"),
        (["--no-websocket"], "leaves nothing to stream to"),
        (["--vmc", "localhost:http"], "a port from 1 to 65535"),
        (["--vmc", "localhost", "--vmc-shapes", "arkitt"], "did you mean 'arkit'"),
        (["--port", "70000"], "from 0 to 65535"),
    ],
)
def test_refusals(line: str, options: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert said in refused(capsys, "serve", line, *options)


def test_a_file_of_another_kind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "x.json").write_text("[]")
    assert "x.json" in refused(capsys, "serve", str(tmp_path / "x.json"))
