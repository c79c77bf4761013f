"""Fuzz every reader: ``python -m tools.fuzz --minutes 30 --seed 1 [--only NAME] [--out FOLDER]``.

A process of its own reads a batch of damaged files. Each file must end in a result or in one line (`MienError`) within
25 seconds and 1.5 GB, reading no file outside its folder and speaking to no host. Whatever else happens is kept in the
folder for faults: the file and what was seen. Exit code 1 if there was any. The same seed makes the same files.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import os
import shutil
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path

import numpy as np
from tools.fuzz.mutator import mutated
from tools.fuzz.targets import TARGETS, Target
from tools.processor_time import spent

from mien.core.errors import MienError

SECONDS, MEGABYTES, BATCH = 25.0, 1536, 40
_ASLEEP = 0.5  # processor seconds; a file that takes so little for so long waits for something, not for its turn
_READABLE = (
    "/dev/null",
    "/dev/urandom",
    "/proc/",
    "/sys/",
    "/etc/ld",
    "/usr/",
    "/lib",
    "/opt/",
    "/etc/mime",
    "/etc/localtime",
)


def main() -> int:
    """Run; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", action="append", default=[], help="name of a target (repeatable)")
    parser.add_argument("--out", type=Path, default=Path("fuzz-faults"), help="folder for faults")
    options = parser.parse_args()
    chosen = [target for target in TARGETS if not options.only or target.name in options.only]
    options.out.mkdir(exist_ok=True)
    work = Path(tempfile.mkdtemp(prefix="mien-fuzz-"))
    try:
        return _run(chosen, options.minutes * 60, options.seed, options.out, work)
    finally:
        shutil.rmtree(work, ignore_errors=True)


def _run(targets: list[Target], seconds: float, seed: int, out: Path, work: Path) -> int:
    seeds = {}
    for target in targets:
        folder = work / "seeds" / target.name.replace(" ", "-")
        folder.mkdir(parents=True)
        made = target.seeds(folder)
        seeds[target.name] = [item if isinstance(item, bytes) else item.read_bytes() for item in made]
        if not seeds[target.name]:
            raise SystemExit(f"{target.name}: no seeds")
    for target in targets:  # loads what they need once, and shows that the seeds are sound
        for content in seeds[target.name]:
            _write(work / f"seed{target.suffix}", content)
            with contextlib.suppress(MienError):
                target.read(work / f"seed{target.suffix}")
    outcomes: dict[str, Counter[str]] = {target.name: Counter() for target in targets}
    known: set[str] = set()
    began, batch = time.monotonic(), 0
    while time.monotonic() - began < seconds:
        for number, target in enumerate(targets):
            _batch(target, seeds[target.name], [seed, number, batch], work, outcomes[target.name], known, out)
            if time.monotonic() - began >= seconds:
                break
        print(f"{(time.monotonic() - began) / 60:.1f} minutes, batch {batch + 1}, faults: {len(known)}", flush=True)
        batch += 1
    _report(outcomes, (time.monotonic() - began) / 60)
    return 1 if known else 0


def _write(path: Path, content: bytes) -> Path:
    path.write_bytes(content)
    return path


def _batch(
    target: Target,
    seeds: list[bytes],
    seed: list[int],
    work: Path,
    outcomes: Counter[str],
    known: set[str],
    out: Path,
) -> None:
    """Read a batch in a process of its own; where that is lost, the rest of the batch goes to a new one."""
    first = 0
    while first < BATCH:
        log = _write(work / "log", b"")
        child = os.fork()
        if child == 0:
            try:
                _child(target, seeds, seed, first, work, log)
            finally:
                os._exit(1)  # never up into our own ends, which remove the folder
        lost = _watch(child, log)
        lines = [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines() if line.endswith("}")]
        done = [line for line in lines if "kind" in line]
        for line in done:
            outcomes[line["kind"]] += 1
            if line["kind"] not in ("read", "refused"):
                _keep(target, seeds, seed, line["n"], line["kind"], line["what"], known, out)
        if not lost:
            return
        at = max((line["n"] for line in lines), default=first)
        outcomes[lost] += 1
        _keep(target, seeds, seed, at, lost, lost, known, out)
        first = at + 1


def _content(seeds: list[bytes], seed: list[int], number: int) -> bytes:
    random = np.random.default_rng([*seed, number])
    return mutated(seeds[int(random.integers(len(seeds)))], random, seeds)


def _keep(
    target: Target, seeds: list[bytes], seed: list[int], number: int, kind: str, what: str, known: set[str], out: Path
) -> None:
    """One file for each different fault."""
    key = f"{target.name} {kind} {what.splitlines()[-1] if kind == 'traceback' else ''} {_where(what)}"
    if key in known:
        return
    known.add(key)
    name = f"{target.name.replace(' ', '-')}-{kind}-{hashlib.sha256(key.encode()).hexdigest()[:8]}"
    _write(out / f"{name}{target.suffix}", _content(seeds, seed, number))
    (out / f"{name}.told").write_text(f"seed {seed} number {number}\n{what}\n", encoding="utf-8")
    print(f"{kind}: {target.name}: {_where(what)} {what.splitlines()[-1][:150]}", flush=True)


def _where(what: str) -> str:
    """The last place in mien that a traceback names."""
    places = [line.strip() for line in what.splitlines() if "/mien/" in line and line.strip().startswith("File")]
    return places[-1].rpartition("/mien/")[2] if places else ""


def _child(target: Target, seeds: list[bytes], seed: list[int], first: int, work: Path, log: Path) -> None:
    os.setsid()  # so that what it starts is counted, and ended, with it
    place = work / "in"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    os.dup2(null, 2)
    seen: list[str] = []
    watching = [False]
    allowed = (
        str(place),
        str(work),
        sys.prefix,
        sys.base_prefix,
        tempfile.gettempdir() + "/mien-",
        *sys.path,
        *_READABLE,
    )

    def audit(event: str, details: tuple) -> None:
        if not watching[0]:
            return
        if event == "open" and isinstance(details[0], str) and not os.path.abspath(details[0]).startswith(allowed):
            seen.append(f"opened {details[0]}")
        elif event in ("socket.connect", "socket.getaddrinfo", "os.system"):
            seen.append(f"{event} {details}")

    sys.addaudithook(audit)
    warnings.simplefilter("ignore")
    with log.open("a", encoding="utf-8") as told:
        for number in range(first, BATCH):
            path = _write(place / f"x{target.suffix}", _content(seeds, seed, number))
            print(json.dumps({"n": number}), file=told, flush=True)
            seen.clear()
            watching[0] = True
            kind, what = _outcome(target, path)
            watching[0] = False
            if seen:
                kind, what = "outside", "; ".join(seen)
            print(json.dumps({"n": number, "kind": kind, "what": what}), file=told, flush=True)
    os._exit(0)


def _outcome(target: Target, path: Path) -> tuple[str, str]:
    try:
        target.read(path)
    except MienError as problem:
        if len(str(problem)) > 1200 or "\n" in str(problem):
            return "long line", f"{len(str(problem))} characters: {str(problem)[:300]}"
        return "refused", ""
    except BaseException:
        return "traceback", traceback.format_exc()
    return "read", ""


def _watch(child: int, log: Path) -> str:
    """Wait for a process; returns how it was lost, empty if it ended as it should."""
    size, since, used = 0, time.monotonic(), 0.0
    held = _megabytes(os.getpid())  # what the child has from us
    while True:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            return "" if status == 0 else f"crash ({status})"
        now = log.stat().st_size
        if now != size:
            size, since, used = now, time.monotonic(), spent(child)
        worked = spent(child) - used
        slow = worked > SECONDS or (worked < _ASLEEP and time.monotonic() - since > 8 * SECONDS)
        kind = "hang" if slow else "memory" if _megabytes(child) - held > MEGABYTES else ""
        if kind:
            os.killpg(child, 9)
            os.waitpid(child, 0)
            return kind
        time.sleep(0.1)


def _megabytes(child: int) -> float:
    try:
        for line in Path(f"/proc/{child}/status").read_text(encoding="utf-8").splitlines():
            if line.startswith("VmHWM"):
                return int(line.split()[1]) / 1024
    except OSError:
        pass
    return 0.0


def _report(outcomes: dict[str, Counter[str]], minutes: float) -> None:
    kinds = sorted({kind for counts in outcomes.values() for kind in counts})
    print(f"{'reader':24}" + "".join(f"{kind:>14}" for kind in kinds))
    for name, counts in outcomes.items():
        print(f"{name:24}" + "".join(f"{counts[kind]:14}" for kind in kinds))
    total = sum((counts for counts in outcomes.values()), Counter())
    print(f"{sum(total.values())} files in {minutes:.1f} minutes: {dict(total)}")


if __name__ == "__main__":
    sys.exit(main())
