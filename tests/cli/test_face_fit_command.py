"""``mien face fit`` and ``mien face from-photos``: what they refuse, in one line, before any work."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from mien.cli.main import main


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "head.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "points.csv").write_text("chin,0\n")
    Image.fromarray(np.zeros((80, 80, 3), np.uint8)).save("front.png")
    Image.fromarray(np.zeros((20, 20, 3), np.uint8)).save("tiny.png")
    return tmp_path


FIT = ["face", "fit", "head.obj", "--landmarks", "points.csv", "-o", "out.npz"]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["face", "fit"], "missing: HEAD.obj, -o"),
        (FIT, "no head was found in it"),
        ([*FIT[:-1], "out.fbx"], "a face file ends in .npz"),
        ([*FIT, "--also", "x.npz"], "expected a name that ends in .glb"),
        ([*FIT, "--unit", "mile"], "unknown unit 'mile'"),
        ([*FIT, "--add", "wings"], "unknown part 'wings'"),
        ([*FIT[:3], "--landmarks", "none.csv", "-o", "out.npz"], "none.csv: no such file"),
        (["face", "from-photos", "front.png", "-o", "me.png"], "a face file ends in .npz"),
        (["face", "from-photos", "front.png", "-o", "me.npz", "--eye-distance", "6"], "between 20 and 120 mm"),
        (["face", "from-photos", "front.png", "-o", "me.npz", "--even-light", "2"], "between 0 and 1"),
        (["face", "from-photos", "front.png", "-o", "me.npz", "--texture-size", "1001"], "multiple of 4"),
        (["face", "from-photos", "tiny.png", "-o", "me.npz"], "are too few"),
        (["face", "from-photos", "none.png", "-o", "me.npz"], "none.png: no such file"),
        (
            ["face", "from-photos", "front.png", "front.png", "-o", "me.npz", "--landmarks", "points.csv"],
            "1 files for 2 photographs",
        ),
        (
            ["face", "from-photos", "front.png", "-o", "me.npz", "--landmarks", "points.csv"],
            "chin: expected 2 numbers, got 1",
        ),
    ],
)
def test_refused_in_one_line(folder, capsys, arguments, told):
    assert main(arguments) == 2
    message = capsys.readouterr().err
    assert told in message
    assert len(message.strip().splitlines()) == 1
    assert not (folder / "out.npz").exists()
    assert not (folder / "me.npz").exists()


def test_landmarks_are_listed(capsys):
    assert main(["face", "fit", "--list-landmarks"]) == 0
    told = capsys.readouterr().out
    assert "chin (needed): middle of the chin's front" in told
