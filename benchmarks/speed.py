"""All tables of speed, one after another, with the load of the machine: run it on one that does nothing else.

    python benchmarks/speed.py --data FOLDER [--corpus CORPUS] [--only stages,startup]      about forty minutes

FOLDER holds grid-s1. CORPUS is a folder that `mien corpus import --recipe grid` made of it; without one it is made
first, for some minutes more. Each table is written by its own program; what ran, for how long and under which load
goes to docs/tables/load.md. One that fails does not stop the others, and is named at the end (exit code 1).
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parent.parent
TABLES = ROOT / "docs" / "tables"
COMMANDS = {
    "startup": ["startup.py", "--write"],
    "stages": ["stages.py"],
    "live": ["live.py", "timing"],
    "posing": ["posing_speed.py"],
    "rendering": ["render_speed.py", "--out", "{tables}/rendering.md"],
    "graph_search": ["graph_search.py", "{corpus}", "-o", "{tables}/graph_search.md"],
    "learning_cost": ["learning_cost.py", "{corpus}", "-o", "{tables}/learning_cost.md"],
    "studio": ["studio.py"],
}
HEADER = """# Under which load the tables of speed were written

Written by `python benchmarks/speed.py`, on {machine}, {cores} processor(s). Load: processes that run or wait to run,
mean of the last minute (1 is one core at work; what is measured counts itself at the end).

| table | command | load before | load after | minutes |
| --- | --- | ---: | ---: | ---: |
"""


def main() -> int:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of grid-s1")
    parser.add_argument("--corpus", type=Path, help="grid-s1 as mien corpus import made it (default: made first)")
    parser.add_argument("--only", default=",".join(COMMANDS), help="names of tables, comma between them")
    options = parser.parse_args()
    names = options.only.split(",")
    if unknown := set(names) - set(COMMANDS):
        parser.error(f"--only takes {', '.join(COMMANDS)}, not {', '.join(sorted(unknown))}")
    rows, failed = [], []
    with tempfile.TemporaryDirectory() as folder:
        corpus = options.corpus or Path(folder) / "grid"
        if options.corpus is None and any("{corpus}" in COMMANDS[name] for name in names):
            made = [sys.executable, "-m", "mien", "corpus", "import", str(options.data / "grid-s1"), "-o", str(corpus)]
            subprocess.run([*made, "--recipe", "grid"], check=True)
        for name in names:
            command = [part.format(tables=TABLES, corpus=corpus) for part in COMMANDS[name]]
            before, start = os.getloadavg()[0], time.monotonic()
            print(f"{name}: load {before:.2f}", flush=True)
            script = ROOT / "benchmarks" / command[0]
            done = subprocess.run([sys.executable, str(script), *command[1:]], cwd=ROOT, check=False)
            minutes = (time.monotonic() - start) / 60
            print(f"{name}: {minutes:.1f} minutes, load {os.getloadavg()[0]:.2f}", flush=True)
            failed += [name] if done.returncode else []
            shown = "failed" if done.returncode else f"`benchmarks/{command[0]}`"
            rows.append(f"| {name} | {shown} | {before:.2f} | {os.getloadavg()[0]:.2f} | {minutes:.1f} |\n")
    (TABLES / "load.md").write_text(
        HEADER.format(machine=platform.machine(), cores=os.cpu_count()) + "".join(rows), encoding="utf-8"
    )
    if failed:
        print(f"failed: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
