"""Python that the README and the docs show runs, or at least finds what it imports."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from tests.programs import voice_or_skip
from tests.test_documented_commands import PAGES, ROOT

BLOCKS = [
    (page.relative_to(ROOT).as_posix(), block)
    for page in [*PAGES, *sorted((ROOT / "viewer").glob("*.md"))]
    for block in re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
]
WHOLE = {"README.md", "docs/face.md", "docs/extending.md"}
"""Pages whose code needs nothing that the text before it has made."""


@pytest.mark.parametrize(("page", "block"), BLOCKS, ids=[page for page, _ in BLOCKS])
def test_it_runs(page: str, block: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    if "mien.say" in block and page in WHOLE:
        voice_or_skip("kokoro-heart")
        block = block.replace('"line.mp4"', '"line.csv"')  # it is drawn elsewhere
    tree = ast.parse(block)
    if page not in WHOLE:
        tree.body = [line for line in tree.body if isinstance(line, ast.Import | ast.ImportFrom)]
    exec(compile(tree, page, "exec"), {"__name__": "documented"})
