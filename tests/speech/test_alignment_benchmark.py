from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent.parent


@pytest.mark.data
def test_the_benchmark_writes_its_table(shared_data: Path, tmp_path: Path) -> None:
    pytest.importorskip("hama")
    out = tmp_path / "alignment.md"
    command = [sys.executable, str(ROOT / "benchmarks" / "alignment_accuracy.py")]
    command += ["--data", str(shared_data), "--subset", "2", "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=os.environ)
    assert done.returncode == 0, done.stderr
    page = out.read_text(encoding="utf-8")
    medians = re.findall(r"^\| (?:TIMIT|EmoDB) [^|]*\|[^|]*\|[^|]*\| ([\d.]+) \|", page, flags=re.MULTILINE)
    assert len(medians) == 3
    assert all(float(median) < 25.0 for median in medians)
    assert "22 more are left out" in page
