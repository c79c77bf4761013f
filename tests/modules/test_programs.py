"""The four modules as four processes. Scripts without words, so that no voice is needed."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from mien.cli import main

NOD = '<HeadNod at="1000" amplitude="60" count="2"/>'
EXPANDED = (
    '<HeadNod><key at="1000" value="0"/><key at="1166.5" value="0.09"/><key at="1333" value="0"/>'
    '<key at="1416.5" value="-0.015"/><key at="1500" value="0"/><key at="1666.5" value="0.09"/>'
    '<key at="1833" value="0"/><key at="1916.5" value="-0.015"/><key at="2000" value="0"/></HeadNod>\n'
)
MIEN = [sys.executable, "-m", "mien"]


def run(name: str, given: str, *options: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*MIEN, name, *options], input=given, capture_output=True, text=True, timeout=60, check=False)


def test_the_papers_example_through_the_program() -> None:
    done = run("translate", NOD + "\n")
    assert (done.returncode, done.stdout, done.stderr) == (0, EXPANDED, "")


def test_the_papers_printed_form() -> None:
    assert run("translate", '<HeadNod at="1000" amplitude="60"\ncount="2">').stdout == EXPANDED


def test_every_module_takes_a_bare_command() -> None:
    assert run("interpret", NOD).stdout == NOD + "\n"
    assert run("speak", NOD).stdout == NOD + "\n"
    assert run("translate", EXPANDED).stdout == EXPANDED
    for given in (NOD, EXPANDED):
        lines = [json.loads(line) for line in run("perform", given, "--performer", "authored").stdout.splitlines()]
        pitch = lines[0]["channels"].index("headPitch")
        assert lines[-1] == {"end": "1", "frames": lines[0]["frames"]}
        assert len(lines) == lines[0]["frames"] + 2
        still = run("perform", NOD.replace('"60"', '"0"'), "--performer", "authored").stdout.splitlines()[36]
        assert lines[36]["values"][pitch] - json.loads(still)["values"][pitch] == pytest.approx(-5.4, abs=0.06)


@pytest.mark.parametrize(
    ("name", "given", "words"),
    [
        ("translate", '<HeadNodd at="1"/>', "did you mean 'HeadNod'"),
        ("translate", "hello", "not well-formed XML"),
        ("translate", "<spoken>\n<text>", "not well-formed XML"),
        ("translate", "", "nothing came in"),
        ("translate", "<interpreted/>", "expected <spoken> from 'mien speak'"),
        ("speak", "<spoken/>", "expected <interpreted> from 'mien interpret'"),
        ("speak", "<interpreted><segment>x</segment><do at='q'><HeadNod/></do></interpreted>", "there is no mark 'q'"),
        ("interpret", "Oh <HeadNodd/>", "did you mean <HeadNod>"),
        ("interpret", "<emotion name='sad'> oh", "never closed"),
        ("perform", "<interpreted/>", "expected <directed> from 'mien translate'"),
        ("perform", "<directed/>", "lacks <sound>"),
    ],
)
def test_malformed_input_is_told_and_ends_with_two(name: str, given: str, words: str) -> None:
    done = run(name, given)
    assert done.returncode == 2
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stderr.startswith(f"mien {name}: error: ")


def test_bytes_that_are_no_text() -> None:
    done = subprocess.run([*MIEN, "translate"], input=b"\xff\xfe<a/>\n", capture_output=True, check=False)
    assert done.returncode == 2
    assert b"expected UTF-8" in done.stderr


def test_options_that_do_not_fit(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    script = tmp_path / "a.txt"
    script.write_text("Oh.")
    for arguments, words in (
        (["translate", "--stay"], "--stay is for --listen"),
        (["translate", "--connect", "x"], "an address is PORT"),
        (["speak", "--voice", "nobody"], "unknown voice"),
        (["speak", "--seed", "-1"], "a seed is"),
        (["perform", "-o", "a.mp5"], "unknown output format"),
        (["interpret", str(script), "--listen", "0"], "give one of them"),
        (["interpret", "nowhere.txt"], "no such script"),
        (["translate", "--commands", str(tmp_path / "no")], "expected a folder"),
    ):
        assert main(arguments) == 2
        assert words in capsys.readouterr().err


def free_ports(count: int) -> list[int]:
    sockets = [socket.socket() for _ in range(count)]
    for item in sockets:
        item.bind(("127.0.0.1", 0))
    ports = [item.getsockname()[1] for item in sockets]
    for item in sockets:
        item.close()
    return ports


class Chain:
    """speak, translate and perform at ports of their own; interpret is fed by the test."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.ports = folder, free_ports(3)
        self.running: dict[str, subprocess.Popen[str]] = {}
        self.frames = folder / "frames.jsonl"

    def start(self, name: str) -> None:
        place = ["speak", "translate", "perform"].index(name)
        options = ["--listen", str(self.ports[place])]
        if name != "perform":
            options += ["--connect", str(self.ports[place + 1])]
        else:
            options += ["--performer", "authored"]
        with self.frames.open("a") as frames, (self.folder / f"{name}.err").open("a") as errors:
            self.running[name] = subprocess.Popen([*MIEN, name, *options], stdout=frames, stderr=errors, text=True)

    def interpret(self, text: str) -> subprocess.Popen[str]:
        script = self.folder / "given.txt"
        script.write_text(text)
        with script.open() as given:
            command = [*MIEN, "interpret", "--connect", str(self.ports[0])]
            self.running["interpret"] = subprocess.Popen(command, stdin=given, stderr=subprocess.PIPE, text=True)
        return self.running["interpret"]

    def utterances(self) -> list[str]:
        return [json.loads(line)["utterance"] for line in self.frames.read_text().splitlines() if "utterance" in line]

    def wait_for(self, count: int) -> None:
        end = time.monotonic() + 40
        while len(self.utterances()) < count:
            assert time.monotonic() < end, f"only {self.utterances()} came; {self.errors()}"
            time.sleep(0.05)

    def errors(self) -> str:
        return "".join(path.read_text() for path in self.folder.glob("*.err"))


@pytest.fixture
def chain(tmp_path: Path) -> Iterator[Chain]:
    made = Chain(tmp_path)
    for name in ("perform", "translate", "speak"):
        made.start(name)
    yield made
    for process in made.running.values():
        if process.poll() is None:
            process.send_signal(signal.SIGCONT)
            process.kill()
        process.wait()


def lines(count: int) -> str:
    return "".join(f'<pause ms="{300 + 10 * number}"/> <HeadNod/>\n' for number in range(count))


def test_four_processes_keep_order_and_report_refusals_upstream(chain: Chain) -> None:
    given = lines(3) + "<pause ms='200'/> <Smlie/>\n" + "<pause ms='200'/> <HeadNod at='9000'/>\n" + lines(1)
    interpret = chain.interpret(given)
    _, told = interpret.communicate(timeout=60)
    assert interpret.returncode == 2
    assert "line 4: text, line 1: unknown tag <Smlie>: did you mean <Smile>" in told
    assert "line 5 refused by speak: text, line 1: HeadNod: its time, 9 s, lies outside the sound" in told
    for name in ("speak", "translate", "perform"):
        chain.running[name].wait(20)
    assert chain.utterances() == ["1", "2", "3", "6"]
    assert [chain.running[name].returncode for name in ("speak", "translate", "perform")] == [2, 0, 0]


def test_a_slow_module_holds_the_others_up_and_one_that_died_comes_back(chain: Chain) -> None:
    interpret = chain.interpret(lines(16))
    chain.wait_for(1)
    chain.running["perform"].send_signal(signal.SIGSTOP)
    time.sleep(0.7)
    assert interpret.poll() is None  # it waits: at most WINDOW messages are under way to each module
    chain.running["translate"].kill()
    chain.running["translate"].wait()
    chain.start("translate")
    time.sleep(0.3)
    chain.running["perform"].send_signal(signal.SIGCONT)
    _, told = interpret.communicate(timeout=60)
    assert interpret.returncode == 0, told + chain.errors()
    for name in ("speak", "translate", "perform"):
        assert chain.running[name].wait(20) == 0, chain.errors()
    assert chain.utterances() == [str(number) for number in range(1, 17)]


@pytest.mark.skipif(
    os.geteuid() != 0
    or shutil.which("ip") is None
    or subprocess.run(["ip", "netns", "list"], check=False).returncode != 0,
    reason="network namespaces need root and ip netns",
)
def test_two_computers(tmp_path: Path) -> None:
    """translate and perform in a network namespace of their own, joined by a virtual cable."""
    space, here, there = f"mien{os.getpid()}", f"mh{os.getpid()}"[:14], f"mt{os.getpid()}"[:14]
    wires = [
        ["netns", "add", space],
        ["link", "add", here, "type", "veth", "peer", "name", there, "netns", space],
        ["addr", "add", "10.213.7.1/24", "dev", here],
        ["link", "set", here, "up"],
        ["-n", space, "addr", "add", "10.213.7.2/24", "dev", there],
        ["-n", space, "link", "set", there, "up"],
        ["-n", space, "link", "set", "lo", "up"],
    ]
    try:
        for wire in wires:
            done = subprocess.run(["ip", *wire], capture_output=True, text=True, check=False)
            if done.returncode:
                pytest.skip(f"ip {' '.join(wire)}: {done.stderr.strip()}")
        frames = tmp_path / "frames.jsonl"
        inside = ["ip", "netns", "exec", space, *MIEN]
        with frames.open("w") as output:
            perform = subprocess.Popen(
                [*inside, "perform", "--listen", "7004", "--performer", "authored"], stdout=output
            )
        translate = subprocess.Popen([*inside, "translate", "--listen", "0.0.0.0:7003", "--connect", "7004"])
        given = run("interpret", lines(3)).stdout
        speak = run("speak", given, "--connect", "10.213.7.2:7003")
        assert speak.returncode == 0, speak.stderr
        assert (translate.wait(20), perform.wait(20)) == (0, 0)
        assert [json.loads(line).get("end") for line in frames.read_text().splitlines() if "end" in line] == [
            "1",
            "2",
            "3",
        ]
    finally:
        subprocess.run(["ip", "netns", "del", space], capture_output=True, check=False)
        subprocess.run(["ip", "link", "del", here], capture_output=True, check=False)
