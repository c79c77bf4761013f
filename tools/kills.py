"""Kill commands at random moments and see that they go on to the same bits: ``python -m tools.kills --rounds 10``.

Each command is run once for reference. In each round it is killed (SIGKILL, with all its workers) at one to three
random moments, then run to its end. What lies in its folder must then be what the reference has, byte for byte, and
nothing else; the folder for temporary files must be empty but for locks. Exit code 1 if not.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from tests.corpus.recordings import write_csv, write_npz, write_speech
from tests.fit.heads import mesh_of, other_shape
from tests.metrics.synthetic import corpus
from tools.processor_time import spent

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
    taught, motion, head = corpus(folder / "corpus").folder, folder / "motion.json", folder / "head.obj"
    mesh = mesh_of(other_shape())
    head.write_text(
        "".join(f"v {x:.4f} {y:.4f} {z:.4f}\n" for x, y, z in mesh.vertices)
        + "".join(f"f {a} {b} {c}\n" for a, b, c in mesh.triangles + 1),
        encoding="utf-8",
    )
    say = ["say", "Hello there.", "-o", str(motion), "--also", str(folder / "sound.wav")]
    subprocess.run([*MIEN, *say], check=True, capture_output=True)
    sound = str(folder / "sound.wav")
    return [
        ("import", lambda out: ["corpus", "import", str(source), "-o", str(out / "c"), "--workers", "2"]),
        ("learn", lambda out: ["learn", str(taught), "-o", str(out / "a.mien")]),
        ("stimuli", lambda out: ["stimuli", str(table), "-o", str(out / "s"), "--workers", "2"]),
        ("batch", lambda out: ["batch", str(lines), "-o", str(out / "b"), "--format", ".csv", "--workers", "2"]),
        ("say", lambda out: ["say", "Hello there.", "-o", str(out / "a.glb"), "--also", str(out / "a.mp4")]),
        ("face-fit", lambda out: ["face", "fit", str(head), "-o", str(out / "f.npz"), "--also", str(out / "f.glb")]),
        (
            "evaluate",
            lambda out: [
                "evaluate",
                str(taught),
                "--protocol",
                "random",
                "--workers",
                "2",
                "--report",
                str(out / "r.md"),
            ],
        ),
        ("recolor", lambda out: ["recolor", str(motion), "--to", "angry", "-o", str(out / "r.json")]),
        ("animate", lambda out: ["animate", sound, "-o", str(out / "a.c3d"), "--also", str(out / "a.usdz")]),
        ("express", lambda out: ["express", str(motion), "-o", str(out / "e.gif"), "--also", str(out / "e.webm")]),
    ]


def content(folder: Path) -> dict[str, str]:
    """Every file of a folder with the digest of what is in it."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()[:16]
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def left(temporary: Path) -> list[str]:
    """What lies in the folder for temporary files, but for locks."""
    return [
        str(path.relative_to(temporary)) for path in temporary.rglob("*") if not path.is_dir() and path.stat().st_size
    ]


def killed(arguments: list[str], after: float, environment: dict[str, str]) -> bool:
    """Run a command and kill it and its workers after some processor seconds; whether it was still running."""
    process = subprocess.Popen(
        [*MIEN, *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        env=environment,
    )
    while process.poll() is None and spent(process.pid) < after:
        time.sleep(0.02)
    ended = process.poll() is not None
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    return not ended


def main() -> int:
    """Run; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", action="append", default=[])
    options = parser.parse_args()
    dice, faults = random.Random(options.seed), 0
    with tempfile.TemporaryDirectory(prefix="mien-kills-") as place:
        temporary = Path(place) / "temporary"
        temporary.mkdir()
        environment = {**os.environ, "TMPDIR": str(temporary)}
        for name, arguments in made_inputs(Path(place)):
            if not options.only or name in options.only:
                faults += _tried(name, arguments, Path(place), options.rounds, dice, environment)
    print(f"faults: {faults}")
    return 1 if faults else 0


def _tried(
    name: str,
    arguments: Callable[[Path], list[str]],
    place: Path,
    rounds: int,
    dice: random.Random,
    environment: dict[str, str],
) -> int:
    """Kill one command in every round; how often something was wrong."""
    reference, temporary, kills, faults = place / name, Path(environment["TMPDIR"]), 0, 0
    reference.mkdir()  # of the same name as that of the rounds: some files name others
    subprocess.run([*MIEN, *arguments(reference)], check=True, capture_output=True, env=environment)
    expected = content(reference)
    shutil.rmtree(reference)
    reference.mkdir()
    began = resource.getrusage(resource.RUSAGE_CHILDREN)  # what is compiled and kept is there now
    subprocess.run([*MIEN, *arguments(reference)], check=True, capture_output=True, env=environment)
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    took = ended.ru_utime + ended.ru_stime - began.ru_utime - began.ru_stime
    if content(reference) != expected:
        faults += 1
        print(f"{name}: two whole runs differ", flush=True)
    shutil.rmtree(reference)
    for number in range(rounds):
        out = place / name
        out.mkdir()
        for _ in range(dice.randint(1, 3)):
            kills += killed(arguments(out), dice.uniform(0.1, 1.0) * took, environment)
        done = subprocess.run([*MIEN, *arguments(out)], check=False, capture_output=True, text=True, env=environment)
        found, behind = content(out), left(temporary)
        if done.returncode or found != expected or behind:
            faults += 1
            odd = sorted(name for name in {*found, *expected} if found.get(name) != expected.get(name))
            told = f"exit code {done.returncode}, differs in {odd}, left {behind[:5]}: {done.stderr[-300:]}"
            print(f"{name}, round {number}: {told}", flush=True)
        shutil.rmtree(out)
    print(f"{name}: {rounds} rounds, {kills} kills of a run of {took:.1f} processor seconds", flush=True)
    return faults


if __name__ == "__main__":
    sys.exit(main())
