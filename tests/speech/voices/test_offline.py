"""Speaking touches nothing but what it is asked to: no diary in the home folder, no call home."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path


def test_speaking_writes_nothing_into_the_home_folder(tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.mkdir()
    cached = tmp_path / "numba"  # compiled code is kept beside the package, or here
    environment = {**os.environ, "HOME": str(home), "NUMBA_CACHE_DIR": str(cached)}
    environment.pop("ORT_DISABLE_TELEMETRY", None)
    environment.pop("XDG_CACHE_HOME", None)
    script = "import mien; print(mien.say('No.').utterance.duration > 0)"
    run = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=False)
    assert run.stdout.strip() == "True", run.stderr
    assert list(home.rglob("*")) == []
