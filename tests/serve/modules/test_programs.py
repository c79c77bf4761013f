"""The four modules as four processes. Scripts without words, so that no voice is needed."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO

import pytest

from mien.cli import main
from mien.serve.modules.transport import Sender

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
        lines = [json.loads(line) for line in run("perform", given, "--performer", "hand-made").stdout.splitlines()]
        pitch = lines[0]["channels"].index("headPitch")
        assert lines[-1] == {"end": "1", "frames": lines[0]["frames"]}
        assert len(lines) == lines[0]["frames"] + 2
        still = run("perform", NOD.replace('"60"', '"0"'), "--performer", "hand-made").stdout.splitlines()[36]
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
        (["perform", "-o", "a.mp4", "--connect", "7"], "both say where the frames go"),
        (["perform", "--face", "default"], "--face is for --output"),
        (["perform", "--deformer", "tree"], "--deformer is for --output"),
        (["perform", "-o", "a.mp4", "--deformer", "trea"], "tree"),
        (["perform", "--speech-model", "graph", "--performer", "hand-made"], "hand-made"),
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


ORDER = ("interpret", "speak", "translate", "perform")


class Chain:
    """The four modules at ports of their own; the test is the one who sends text, and the one who takes frames."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.ports = folder, free_ports(4)
        self.running: dict[str, subprocess.Popen[str]] = {}
        self.frames = folder / "frames.jsonl"
        self.to_consumer: int | None = None

    def start(self, name: str) -> None:
        place = ORDER.index(name)
        options = ["--listen", str(self.ports[place])]
        if name != "perform":
            options += ["--connect", str(self.ports[place + 1])]
        else:
            options += ["--performer", "hand-made"]
            options += ["--connect", str(self.to_consumer)] if self.to_consumer is not None else []
        with self.frames.open("a") as frames, (self.folder / f"{name}.err").open("a") as errors:
            self.running[name] = subprocess.Popen([*MIEN, name, *options], stdout=frames, stderr=errors, text=True)

    def interpret(self, text: str) -> subprocess.Popen[str]:
        """A fourth program that reads the text from standard input."""
        script = self.folder / "given.txt"
        script.write_text(text)
        with script.open() as given:
            command = [*MIEN, "interpret", "--connect", str(self.ports[1])]
            self.running["interpret"] = subprocess.Popen(command, stdin=given, stderr=subprocess.PIPE, text=True)
        return self.running["interpret"]

    def utterances(self) -> list[str]:
        """Ids of the utterances that are complete: half a one is followed by a whole one."""
        found, frames = [], 0
        for line in map(json.loads, self.frames.read_text().splitlines()):
            if "utterance" in line:
                frames = 0
            elif "values" in line:
                assert line["frame"] == frames
                frames += 1
            elif line["frames"] == frames:
                found.append(line["end"])
        return found

    def wait_for(self, count: int) -> None:
        end = time.monotonic() + 40
        while len(re.findall('"end"', self.frames.read_text())) < count:
            assert time.monotonic() < end, f"too little came; {self.errors()}"
            time.sleep(0.02)

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


@pytest.mark.parametrize("victim", ORDER)
def test_each_module_may_die_and_come_back(chain: Chain, victim: str) -> None:
    """All in the test's own hands at both ends: nothing is lost, nothing out of order, every message answered once."""
    chain.start("interpret")
    sender, answers = Sender("127.0.0.1", chain.ports[0]), list[str]()

    def feed() -> None:
        for number, line in enumerate(lines(8).splitlines(), start=1):
            sender.send(line, f"0000abcd:{number}", lambda why, _, n=number: answers.append(f"{n} {why}"))
        sender.close()

    feeding = threading.Thread(target=feed, daemon=True)
    feeding.start()
    chain.wait_for(1)
    chain.running[victim].kill()
    chain.running[victim].wait()
    if victim == "perform" and not chain.frames.read_text().endswith("\n"):
        with chain.frames.open("a") as frames:  # the kill cut a line; the file goes on behind it
            frames.write("\n")
        kept = [line for line in chain.frames.read_text().splitlines() if line.endswith("}")]
        chain.frames.write_text("".join(line + "\n" for line in kept))
    chain.start(victim)
    feeding.join(60)
    assert not feeding.is_alive(), chain.errors()
    for name in ORDER:
        assert chain.running[name].wait(20) == 0, chain.errors()
    assert answers == [f"{number} None" for number in range(1, 9)]
    done = chain.utterances()
    assert list(dict.fromkeys(done)) == [str(number) for number in range(1, 9)]
    assert len(done) == 8 or victim == "perform"  # one that died may do again what it had done


def test_frames_go_to_whoever_listens_and_are_sent_again(chain: Chain) -> None:
    """A consumer that dies amid the second utterance gets it again, whole, from its beginning."""
    chain.running["perform"].kill()
    chain.running["perform"].wait()
    with socket.create_server(("127.0.0.1", 0)) as server:
        chain.to_consumer = server.getsockname()[1]
        chain.start("perform")
        interpret = chain.interpret(lines(3))
        first, _ = server.accept()
        with first, first.makefile("r") as stream:
            heads = [_utterance(stream)]
            first.sendall(f'<done id="{heads[0]}"/>\n'.encode())
            heads.append(stream.readline().split(" ", 1)[0])
        second, _ = server.accept()
        with second, second.makefile("r") as stream:
            for _ in range(2):
                heads.append(_utterance(stream))
                second.sendall(f'<done id="{heads[-1]}"/>\n'.encode())
            assert stream.readline() == "<end/>\n"
            second.sendall(b"<end/>\n")
    _, told = interpret.communicate(timeout=30)
    assert interpret.returncode == 0, told + chain.errors()
    assert chain.running["perform"].wait(20) == 0
    assert [head.partition(":")[2] for head in heads] == ["1", "2", "2", "3"]


def test_a_consumer_that_refuses_frames_is_heard_by_the_first_module(chain: Chain) -> None:
    chain.running["perform"].kill()
    chain.running["perform"].wait()
    with socket.create_server(("127.0.0.1", 0)) as server:
        chain.to_consumer = server.getsockname()[1]
        chain.start("perform")
        interpret = chain.interpret(lines(1))
        connection, _ = server.accept()
        with connection, connection.makefile("r") as stream:
            identity = _utterance(stream)
            connection.sendall(f'<refused id="{identity}" module="screen">no face</refused>\n<end/>\n'.encode())
            _, told = interpret.communicate(timeout=30)
    assert interpret.returncode == 2
    assert "message of line 1 refused by screen: no face" in told


def _utterance(stream: IO[str]) -> str:
    """Read one utterance's frames; returns its identity."""
    identity, header = stream.readline().split(" ", 1)
    count = json.loads(header)["frames"]
    frames = [json.loads(stream.readline()) for _ in range(count)]
    assert [frame["frame"] for frame in frames] == list(range(count))
    assert json.loads(stream.readline())["frames"] == count
    return identity


def test_a_reader_that_is_slow_loses_nothing() -> None:
    perform = subprocess.Popen(
        [*MIEN, "perform", "--performer", "hand-made"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert perform.stdin is not None
    assert perform.stdout is not None
    perform.stdin.write((NOD + "\n") * 2 + "<Smlie at='0'/>\n" + NOD + "\n")
    perform.stdin.close()
    time.sleep(1.5)  # by now the pipe is full, and it waits
    found = [json.loads(line) for line in perform.stdout]
    assert perform.wait(20) == 2
    marks = [line.get("end") or line.get("refused") for line in found if "end" in line or "refused" in line]
    assert marks[0:2] + marks[3:] == ["1", "2", "4"]
    assert "did you mean" in marks[2]
    perform.stdout.close()


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
                [*inside, "perform", "--listen", "7004", "--performer", "hand-made", "--token", "secret-word"],
                stdout=output,
            )
        translate = subprocess.Popen(
            [*inside, "translate", "--listen", "0.0.0.0:7003", "--connect", "7004", "--token", "secret-word"]
        )
        given = run("interpret", lines(3)).stdout
        speak = run("speak", given, "--connect", "10.213.7.2:7003", "--token", "secret-word")
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
