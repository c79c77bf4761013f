"""No command looks a host up or speaks to one unless it is told to."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

GUARD = """
import socket, sys

def denied(*given, **named):
    with open({log!r}, "a") as log:
        log.write(f"{{given}} {{sys.argv[1:3]}}\\n")
    raise OSError("no look-ups in this test")

for name in ("getaddrinfo", "gethostbyname", "gethostbyname_ex", "gethostbyaddr", "getnameinfo", "getfqdn"):
    setattr(socket, name, denied)
connect = socket.socket.connect
socket.socket.connect = lambda one, at: connect(one, at) if one.family == socket.AF_UNIX else denied("connect", at)
"""
COMMANDS = (
    ["say", "Hello.", "-o", "a.csv", "--also", "a.wav", "--also", "a.json"],
    ["animate", "a.wav", "-o", "b.csv"],
    ["align", "a.wav", "--text", "hello", "-o", "a.srt"],
    ["express", "a.json", "--emotion", "sad", "-o", "c.csv"],
    ["emotion", "a.wav"],
    ["serve", "a.json", "--port", "0"],
    ["doctor"],
)


def test_commands_run_where_every_look_up_fails(tmp_path: Path) -> None:
    log = tmp_path / "log"
    (tmp_path / "sitecustomize.py").write_text(GUARD.format(log=str(log)))
    script = "import sys; sys.path.insert(0, '.'); import sitecustomize; from mien.cli import main\n"
    script += f"codes = [main(command) for command in {COMMANDS!r}]\nassert not any(codes), codes"
    run = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert not log.exists(), log.read_text()
