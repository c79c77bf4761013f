"""What all benchmarks have in common."""

from __future__ import annotations

from pathlib import Path

import pytest

# live_timing.py starts itself as its own clients; live.py reads its options.
PROGRAMS = sorted(
    path
    for path in (Path(__file__).parent.parent / "benchmarks").glob("*.py")
    if '__name__ == "__main__"' in path.read_text(encoding="utf-8") and path.stem != "live_timing"
)


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: path.stem)
def test_a_benchmark_reads_its_options_so_that_help_is_no_input(program: Path) -> None:
    text = program.read_text(encoding="utf-8")
    assert "parse_args(" in text or "run(sys.argv[1:])" in text
