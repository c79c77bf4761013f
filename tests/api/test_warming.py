"""After warming up, nothing is compiled for a picture."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from mien.core.compiled import cache_note

CODE = """
from mien.animation.animation import imported
from mien.api.warming import warm_up
from mien.core import channels, compiled
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.formats.saving import save
import numpy as np, sys
print(warm_up())
rest = ChannelTrack(channels.ALL, np.zeros((1, len(channels.ALL))), FrameRate.of(30))
before = compiled.compilations()
save(imported(rest, "test"), sys.argv[1])
assert compiled.compilations() == before > 0, (before, compiled.compilations())
"""


def test_it_compiles_all_that_a_video_needs(tmp_path: Path) -> None:
    command = [sys.executable, "-c", CODE, str(tmp_path / "x.mp4")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == cache_note()
    assert (tmp_path / "x.mp4").stat().st_size > 0
