"""What a stimulus costs, and how a design of thousands of rows grows. Writes docs/tables/stimuli.md.

    python benchmarks/stimuli.py           two minutes with --rows 8, about six without
    python benchmarks/stimuli.py --rows 10 --print-only

Made rows are real (the default voice and performer, 640 x 480). Designs of thousands are not made: finished stimuli of
tiny size are laid into a folder as a run leaves them, and a second run goes over them.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import json
import platform
import resource
import tempfile
import time
from pathlib import Path

from mien.api.stimuli import Stimulus, make_stimuli, read_design
from mien.api.stimuli.stimulus_making import fingerprint

OUT = Path(__file__).parent.parent / "docs" / "tables" / "stimuli.md"
SENTENCES = (
    "I never said that.",
    "Maybe five people heard my voice.",
    "Tell me more about it.",
    "We were away a year.",
)
EMOTIONS = ("happy", "sad", "angry", "surprised", "afraid")


def rows(count: int, still: bool) -> list[Stimulus]:
    """So many rows, no two alike."""
    return [
        Stimulus(
            f"s{number:05d}",
            SENTENCES[number % len(SENTENCES)],
            emotion=EMOTIONS[number % len(EMOTIONS)],
            seed=number,
            still_ms="600" if still else "",
        )
        for number in range(count)
    ]


def seconds_to_make(count: int, still: bool, workers: int) -> float:
    """For all of them, processes and models loaded included."""
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        report = make_stimuli(rows(count, still), folder, workers=workers)
        assert not report.failed, report.failed[0]
        return time.perf_counter() - start


def seconds_to_go_over(count: int) -> tuple[float, float, float]:
    """Reading a design, going over its finished stimuli, and MB of memory added."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with (folder / "design.csv").open("w", newline="") as stream:
            writer = csv.writer(stream)
            writer.writerow(["name", "sentence", "emotion", "seed", "still_ms"])
            for row in rows(count, True):
                writer.writerow([row.name, row.sentence, row.emotion, row.seed, row.still_ms])
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        start = time.perf_counter()
        design = read_design(folder / "design.csv")
        read = time.perf_counter() - start
        for row in design:
            files = {row.file: b"picture", f"{row.name}.csv": b"log"}
            for file, content in files.items():
                (folder / file).write_bytes(content)
            hashes = {file: hashlib.sha256(content).hexdigest() for file, content in files.items()}
            facts = {"fingerprint": fingerprint(row), "frames": 1, "seconds": 1.0, "sha256": hashes}
            (folder / f"{row.name}.json").write_text(json.dumps(facts))
        start = time.perf_counter()
        report = make_stimuli(design, folder, lists=4, workers=0)
        assert len(report.kept) == count
        spent = time.perf_counter() - start
        return read, spent, (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024


def table(count: int) -> str:
    """The page."""
    lines = [
        "# What stimuli cost",
        "",
        f"`python benchmarks/stimuli.py --rows {count}`, {platform.machine()}, Python {platform.python_version()}. "
        "Default voice and performer, 640 x 480, sentences of about 1.5 s; the first row also pays for starting the "
        "processes and loading the models.",
        "",
        "| what | workers | rows | seconds | seconds per row | against one row |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for still in (True, False):
        kind = "one picture" if still else "a video at 25 frames/s"
        one = seconds_to_make(1, still, 1)
        for workers, made in ((1, 1), (1, count), (2, count)):
            spent = one if made == 1 else seconds_to_make(made, still, workers)
            lines.append(
                f"| {kind} | {workers} | {made} | {spent:.1f} | {spent / made:.2f} | {spent / made / one:.2f} |"
            )
    lines += [
        "",
        "Going over a design that is made already (files checked by their hashes, manifest and four lists written):",
        "",
        "| rows | reading the design, s | going over it, s | ms per row | memory added, MB |",
        "| --- | --- | --- | --- | --- |",
    ]
    for size in (300, 3000, 30000):
        read, spent, added = seconds_to_go_over(size)
        lines.append(f"| {size} | {read:.2f} | {spent:.2f} | {1000 * spent / size:.2f} | {added:.0f} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, default=40, help="rows that are made (default 40)")
    parser.add_argument("--print-only", action="store_true", help="leave the table in docs alone")
    options = parser.parse_args()
    page = table(options.rows)
    print(page)
    if not options.print_only:
        OUT.write_text(page)


if __name__ == "__main__":
    main()
