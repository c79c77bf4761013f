"""Kill commands at random moments and see that they go on to the same bits: ``python -m tools.kills --rounds 10``.

Each command is run once for reference. In each round it is killed (SIGKILL, with all its workers) at one to three
random moments, then run to its end. What lies in its folder must then be what the reference has, byte for byte but for
what tells the time, and nothing else. Exit code 1 if not.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from tests.corpus.recordings import write_csv, write_npz, write_speech
from tests.metrics.synthetic import corpus

MIEN = (sys.executable, "-m", "mien")
_TABLE = "name,voice,sentence,still_ms,width,height,performer\n"
Command = tuple[str, Callable[[Path], list[str]]]


def made_inputs(folder: Path) -> list[Command]:
    """Small inputs for every command that works long, and its arguments for a folder of outputs."""
    source, table, lines = folder / "source", folder / "design.csv", folder / "lines.txt"
    for number in range(6):
        (write_csv if number % 2 else write_npz)(source, f"take{number}")
        write_speech(source, f"take{number}")
    rows = (f"s{n},espeak,Oh no {n}.,200,32,32,hand-made\n" for n in range(6))
    table.write_text(_TABLE + "".join(rows), encoding="utf-8")
    lines.write_text("".join(f"Line {word}.\n" for word in ("one", "two", "three", "four")), encoding="utf-8")
    taught = corpus(folder / "corpus").folder
    return [
        ("import", lambda out: ["corpus", "import", str(source), "-o", str(out / "c"), "--workers", "2"]),
        ("learn", lambda out: ["learn", str(taught), "-o", str(out / "a.mien")]),
        ("stimuli", lambda out: ["stimuli", str(table), "-o", str(out / "s"), "--workers", "2"]),
        ("batch", lambda out: ["batch", str(lines), "-o", str(out / "b"), "--format", ".csv", "--workers", "2"]),
        ("say", lambda out: ["say", "Hello there.", "-o", str(out / "a.glb"), "--also", str(out / "a.mp4")]),
    ]


def content(folder: Path) -> dict[str, str]:
    """Every file of a folder with the digest of what is in it."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()[:16]
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def killed(arguments: list[str], after: float) -> bool:
    """Run a command and kill it and its workers after some seconds; whether it was still running."""
    process = subprocess.Popen(
        [*MIEN, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    )
    try:
        process.wait(after)
        return False
    except subprocess.TimeoutExpired:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        return True


def main() -> int:
    """Run; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", action="append", default=[])
    options = parser.parse_args()
    dice, faults = random.Random(options.seed), 0
    with tempfile.TemporaryDirectory(prefix="mien-kills-") as place:
        for name, arguments in made_inputs(Path(place)):
            if options.only and name not in options.only:
                continue
            reference, kills = Path(place) / "reference" / name, 0
            reference.mkdir(parents=True)
            subprocess.run([*MIEN, *arguments(reference)], check=True, capture_output=True)
            expected = content(reference)
            shutil.rmtree(reference)
            reference.mkdir()
            began = time.monotonic()  # what is compiled and kept is there now
            subprocess.run([*MIEN, *arguments(reference)], check=True, capture_output=True)
            took = time.monotonic() - began
            if content(reference) != expected:
                faults += 1
                print(f"{name}: two whole runs differ", flush=True)
            for number in range(options.rounds):
                out = Path(place) / name
                out.mkdir()
                for _ in range(dice.randint(1, 3)):
                    kills += killed(arguments(out), dice.uniform(0.1, 1.0) * took)
                done = subprocess.run([*MIEN, *arguments(out)], check=False, capture_output=True, text=True)
                found = content(out)
                if done.returncode or found != expected:
                    faults += 1
                    odd = sorted(name for name in {*found, *expected} if found.get(name) != expected.get(name))
                    print(
                        f"{name}, round {number}: exit code {done.returncode}, differs in {odd}: {done.stderr[-300:]}"
                    )
                shutil.rmtree(out)
            print(f"{name}: {options.rounds} rounds, {kills} kills of a run of {took:.1f} s", flush=True)
    print(f"faults: {faults}")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
