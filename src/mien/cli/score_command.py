"""``mien score``: one face in motion scored against another, whatever holds them."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

__all__ = ["add_command"]


def add_command(commands: Any) -> None:
    """Add ``mien score`` to the commands."""
    parser = commands.add_parser(
        "score",
        help="compare two motions: animations, face capture, markers, takes",
        description="Each of the two is an animation (.json), a Live Link Face recording (.csv), marker motion "
        "(.c3d, "
        ".csv, .npz) or a take of a corpus (CORPUS/NAME), in any combination. If both are folders or corpora, "
        "items with the same name are compared. Every metric that applies is printed. See docs/metrics.md.",
    )
    parser.add_argument("reference", metavar="REFERENCE", help="the motion taken as correct, such as a recording")
    parser.add_argument("estimate", metavar="ESTIMATE", help="the motion to judge")
    parser.add_argument("--fps", help="frames per second of a .csv without times")
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    parser.add_argument("-o", "--output", metavar="X.csv", help="also write every figure on its own line")
    parser.set_defaults(run=_score)


def _score(options: argparse.Namespace) -> int:
    from mien.core.errors import OutputError
    from mien.core.files import check_writable
    from mien.metrics.scoring import mean_of, score, score_folders, write_csv

    if options.output and check_writable(options.output).suffix.lower() != ".csv":
        raise OutputError(f"mien score writes a .csv file, not {options.output!r}; give -o NAME.csv")
    names = (options.reference, options.estimate)
    if all(Path(name).is_dir() for name in names):
        each, missing = score_folders(*names, fps=options.fps)
        shown = mean_of(each, *names)
        if missing:
            print(f"mien: warning: {len(missing)} in {names[0]} alone, first {missing[0]!r}", file=sys.stderr)
    else:
        shown = score(*names, fps=options.fps)
        each = [shown]
    if options.output:
        write_csv(each, options.output)
    if options.json:
        print(shown.as_json() if len(each) == 1 else _many(shown.as_json(), [one.as_json() for one in each]))
    else:
        print(shown)
    return 0


def _many(mean: str, pairs: list[str]) -> str:
    return json.dumps({"mean": json.loads(mean), "pairs": [json.loads(pair) for pair in pairs]}, indent=2)
