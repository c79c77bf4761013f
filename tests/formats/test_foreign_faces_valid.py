"""The Khronos validator over every driven animal of the zoo: no error that was not in the file before."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.formats.driven_glb import drive_glb
from tests.zoo import ZOO

FOLDER = Path(__file__).parent.parent / "viewer_check"
TRACK = ChannelTrack(("jawOpen", "headYaw", "eyeLookUpLeft"), [[0.0, 0.0, 0.1], [0.5, 9.0, 0.2]], FrameRate.of(30))


@pytest.fixture(scope="module")
def validated(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[str]]:
    """Errors of each file, before and after, from one run of the validator."""
    absent = [name for name in ("node", "npm") if shutil.which(name) is None]
    if absent:
        reason = f"{', '.join(absent)} not installed: the validator needs Node and npm"
        if os.environ.get("CI"):
            pytest.fail(reason)
        pytest.skip(reason)
    if not (FOLDER / "node_modules" / "gltf-validator").is_dir():
        made = subprocess.run(["npm", "ci"], cwd=FOLDER, capture_output=True, text=True, timeout=600)
        assert made.returncode == 0, made.stderr
    files = []
    for name, make in ZOO.items():
        folder = tmp_path_factory.mktemp(name)
        animal = make(folder)
        drive_glb(TRACK, animal.path, folder / f"{name}-driven.glb", animal.names)
        shutil.copy(animal.path, folder / f"{name}-before{animal.path.suffix}")
        files += [folder / f"{name}-before{animal.path.suffix}", folder / f"{name}-driven.glb"]
    ran = subprocess.run(
        ["node", "validate.js", *map(str, files)], cwd=FOLDER, capture_output=True, text=True, timeout=300
    )
    assert ran.returncode == 0, ran.stderr
    reports = [json.loads(line) for line in ran.stdout.splitlines()]
    return {Path(report["file"]).stem: report["errors"] for report in reports}


@pytest.mark.parametrize("name", sorted(ZOO))
def test_driving_adds_no_error(name: str, validated: dict[str, list[str]]) -> None:
    before = {re.sub(r"/(bufferViews|accessors)/\d+", "", error) for error in validated[f"{name}-before"]}
    added = [
        error
        for error in validated[f"{name}-driven"]
        if re.sub(r"/(bufferViews|accessors)/\d+", "", error) not in before
    ]
    assert added == []
    assert len(validated[f"{name}-driven"]) <= len(validated[f"{name}-before"])
