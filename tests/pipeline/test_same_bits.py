"""The same bits with any number of threads, in any locale, time zone and folder."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from tests.programs import voice_or_skip


def test_threads_locale_time_zone_and_folder_change_nothing(tmp_path: Path) -> None:
    voice = voice_or_skip("espeak").name
    made = []
    for number, (threads, locale, zone) in enumerate((("1", "C", "UTC"), ("2", "fi_FI.UTF-8", "Asia/Kolkata"))):
        folder = tmp_path / f"place {number}"
        folder.mkdir()
        about = {"OPENBLAS_NUM_THREADS": threads, "OMP_NUM_THREADS": threads, "MKL_NUM_THREADS": threads}
        command = [sys.executable, "-m", "mien", "say", "Maybe five people heard my voice.", "--voice", voice]
        command += ["--emotion", "happy:0.7", "-o", "a.json", "--also", "a.csv", "--quiet"]
        paths = os.pathsep.join(path or str(Path.cwd()) for path in sys.path)
        environment = {**os.environ, **about, "LC_ALL": locale, "TZ": zone, "PYTHONPATH": paths}
        subprocess.run(command, cwd=folder, env=environment, check=True)
        made.append([(folder / name).read_bytes() for name in ("a.json", "a.csv")])
    assert made[0] == made[1]
