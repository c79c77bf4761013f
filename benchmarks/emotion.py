"""Measure how well emotion is told from voices and write docs/tables/emotion.md.

    python benchmarks/emotion.py [CORPUS ...]      # default: emodb in MIEN_DATA or ../shared/data

The same as `mien emotion-table CORPUS ... --report docs/tables/emotion.md`. Each CORPUS is a folder or table as in
docs/emotion.md; several of them add the rows across corpora.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from mien.cli import main

HERE = Path(__file__).parent

if __name__ == "__main__":
    data = Path(os.environ.get("MIEN_DATA", HERE.parent.parent / "shared" / "data"))
    corpora = sys.argv[1:] or [str(data / "emodb" / "audio")]
    sys.exit(main(["emotion-table", *corpora, "--report", str(HERE.parent / "docs" / "tables" / "emotion.md")]))
