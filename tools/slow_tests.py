"""Write tests/slow_tests.txt, which `make test-quick` leaves out, from the times of a whole run.

    python tools/slow_tests.py test-times.xml      (what `make slow-tests` does)

A file in which one test takes more than `LONG` is slow as a whole: what its tests share is made by whichever comes
first. Of the others the slowest tests are named, one by one, until what is left fits into `SECONDS` on the machine that
was measured. Lines stand in the order in which the files are best run (tests/conftest.py): those that take longest
first, so that no process is left with a long one at the end. Measure where no test is skipped: one that was (without a
browser, without Blender) counts as fast.
"""

from __future__ import annotations

import argparse
import xml.etree.ElementTree as ElementTree
from pathlib import Path

SECONDS = 30.0  # of processor time, shared by two processes that also start and collect
LONG = 2.5  # seconds
OUT = Path(__file__).parent.parent / "tests" / "slow_tests.txt"


def main() -> None:
    """Name the slowest tests until the others fit."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("times", type=Path, help="JUnit report of a whole run")
    times: dict[str, float] = {}
    for case in ElementTree.parse(parser.parse_args().times).getroot().iter("testcase"):
        name = f"{case.get('classname', '')}::{case.get('name', '').partition('[')[0]}"
        times[name] = times.get(name, 0.0) + float(case.get("time", 0))
    longest: dict[str, float] = {}
    whole: dict[str, float] = {}
    for name, seconds in times.items():
        file = name.partition("::")[0]
        longest[file] = max(longest.get(file, 0.0), seconds)
        whole[file] = whole.get(file, 0.0) + seconds
    slow = [name for name in times if longest[name.partition("::")[0]] > LONG]
    left = sum(times.values()) - sum(times[name] for name in slow)
    for name in sorted(times.keys() - set(slow), key=lambda name: -times[name]):
        if left <= SECONDS:
            break
        slow.append(name)
        left -= times[name]
    slow.sort(key=lambda name: (-whole[name.partition("::")[0]], name))
    OUT.write_text("".join(f"{name}\n" for name in slow), encoding="utf-8")
    print(f"{len(slow)} of {len(times)} tests are slow; the others take {left:.0f} s one after another")


if __name__ == "__main__":
    main()
