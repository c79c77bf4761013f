"""Every command line that the README and the docs show is one that mien understands."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from mien.cli.main import _parser

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted((ROOT / "examples").rglob("*.md"))]
LINE = re.compile(r"^(?: {4}|\$ )?(mien [a-z].*)$", re.MULTILINE)
_PLACEHOLDERS = re.compile(r"\.\.\.|…|\[|\]|\b(?:TEXT|FILE|OUT|AUDIO|CORPUS|MOTION)\b|\|")


def commands(page: Path) -> list[str]:
    """Command lines of code blocks, without remarks, redirections and what stands for something else."""
    found = []
    inside = False
    for line in page.read_text(encoding="utf-8").splitlines():
        inside ^= line.startswith("```")
        if not (inside or line.startswith("    ")):
            continue
        for part in re.split(r"\s&&\s|\s\|\s", line.strip()):
            part = re.split(r"\s{2,}|\s#|\s>|\s&$|\s<\s", part.strip())[0]
            if part.startswith("mien ") and not _PLACEHOLDERS.search(part) and not part.endswith("\\"):
                found.append(part)
    return found


CASES = [(page, line) for page in PAGES for line in commands(page)]


def test_there_are_many() -> None:
    assert len(CASES) > 100


@pytest.mark.parametrize(("page", "line"), CASES, ids=lambda value: value if isinstance(value, str) else value.stem)
def test_it_is_understood(page: Path, line: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = shlex.split(line)[1:]
    try:
        _parser().parse_args(words)
    except SystemExit as ended:
        if ended.code:
            pytest.fail(f"{page.name}: {line}: {capsys.readouterr().err.strip()}")
    except Exception as problem:
        pytest.fail(f"{page.name}: {line}: {problem}")
