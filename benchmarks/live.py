"""How good and how fast is live? Writes docs/tables/live.md.

    python benchmarks/live.py accuracy [--data FOLDER]      about ten minutes on two cores
    python benchmarks/live.py timing                        about four minutes, on a machine that does nothing else
    python benchmarks/live.py page                          about a minute; wants Chromium

FOLDER (default: MIEN_DATA, or ../shared/data beside the clone) holds timit-sample. Each part is written to its own
place in the file; the others stay. Definitions stand at the heads of ``live_accuracy.py``, ``live_timing.py`` and
``live_page.py``.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from pathlib import Path

from threadpoolctl import threadpool_limits

ROOT = Path(__file__).parent.parent
OUT = ROOT / "docs" / "tables" / "live.md"
HEAD = "# Live\n\nWritten by `python benchmarks/live.py`, a part each by `accuracy`, `timing` and `page`.\n"
PARTS = ("accuracy", "timing", "page")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", choices=PARTS)
    parser.add_argument(
        "--data",
        type=Path,
        default=Path(os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data")),
        help="for accuracy: the folder that holds timit-sample (default: MIEN_DATA, or ../shared/data)",
    )
    parser.add_argument("--subset", type=int, help="for accuracy: so many utterances, for a quick look")
    options = parser.parse_args()
    with threadpool_limits(1):
        text = "\n".join(lines(options)) + "\n"
    print(text)
    write(options.part, text)


def lines(options: argparse.Namespace) -> Iterator[str]:
    if options.part == "timing":
        import live_timing

        return live_timing.section()
    if options.part == "page":
        import live_page

        return live_page.section()
    import hand_labels
    import live_accuracy

    return live_accuracy.section(*hand_labels.timit(options.data / "timit-sample", options.subset))


def write(part: str, text: str) -> None:
    """Put one part into the file and keep the other."""
    kept = OUT.read_text(encoding="utf-8") if OUT.exists() else ""
    parts = {name: _part(kept, name) for name in PARTS} | {part: text}
    marked = [f"<!-- {name} -->\n{parts[name]}<!-- end of {name} -->\n" for name in PARTS]
    OUT.write_text("\n".join([HEAD, *marked]), encoding="utf-8")


def _part(kept: str, name: str) -> str:
    _, found, rest = kept.partition(f"<!-- {name} -->\n")
    return rest.partition(f"<!-- end of {name} -->")[0] if found else ""


if __name__ == "__main__":
    main()
