"""The contract that every output format keeps."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from mien.core.errors import InputError, Note, OutputError
from mien.formats import EXPORTERS, check_output, save
from mien.formats.registry import FRAMES
from tests.faces import tiny_animation, tiny_face

every_exporter = pytest.mark.parametrize("exporter", EXPORTERS, ids=lambda exporter: exporter.suffix)
# FBX (Blender writes it, with the time of day in it) and single pictures (many files) have tests of their own.
every_own = pytest.mark.parametrize(
    "exporter", [one for one in EXPORTERS if one.suffix not in (".fbx", FRAMES)], ids=lambda exporter: exporter.suffix
)


@pytest.fixture(scope="module")
def animation():
    return tiny_animation(6)


@pytest.fixture(scope="module")
def face():
    return tiny_face()


@every_own
def test_writes_the_same_bytes_twice(exporter, animation, face, tmp_path):
    first, second = tmp_path / "1" / f"a{exporter.suffix}", tmp_path / "2" / f"a{exporter.suffix.upper()}"
    for path in (first, second):
        path.parent.mkdir()
        notes = save(animation, path, face=face)
        assert isinstance(notes, tuple)
        assert all(isinstance(note, Note) for note in notes)
    assert first.stat().st_size > 100
    assert first.read_bytes() == second.read_bytes()
    for path in (first, second):
        assert sorted(path.parent.iterdir()) == sorted([path, *beside(exporter, path)])


def beside(exporter, path):
    """The folder that a format keeps beside its file."""
    return [exporter.companion(path)] if exporter.companion else []


@every_own
def test_name_in_any_script_and_overwriting(exporter, animation, face, tmp_path):
    folder = tmp_path / "Äänet 声"
    folder.mkdir()
    path = folder / f"näyte “1”{exporter.suffix}"
    path.write_text("old")
    save(animation, path, face=face)
    assert path.read_bytes() != b"old"
    assert sorted(folder.iterdir()) == sorted([path, *beside(exporter, path)])


@every_own
def test_full_disk_leaves_nothing_and_keeps_the_old_file(exporter, animation, face, tmp_path, monkeypatch):
    path = tmp_path / f"out{exporter.suffix}"
    path.write_text("old")

    def full(self, target):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(OutputError, match="disk is full"):
        save(animation, path, face=face)
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]
    assert path.read_text() == "old"


@every_own
def test_refuses_early_where_it_cannot_write(exporter, tmp_path):
    with pytest.raises(OutputError, match="does not exist"):
        check_output(tmp_path / "missing" / f"out{exporter.suffix}")
    (tmp_path / f"folder{exporter.suffix}").mkdir()
    with pytest.raises(OutputError, match="is a folder"):
        check_output(tmp_path / f"folder{exporter.suffix}")


@every_own
def test_locked_folder(exporter, animation, face, tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may write anywhere, so a real lock would not do
    with pytest.raises(OutputError, match="permission denied"):
        save(animation, tmp_path / f"out{exporter.suffix}", face=face)
    assert list(tmp_path.iterdir()) == []


@every_exporter
def test_says_what_it_loses_and_is_documented(exporter):
    formats = (Path(__file__).parents[2] / "docs" / "formats.md").read_text(encoding="utf-8")
    assert f"## `{exporter.suffix}`" in formats
    assert exporter.loses in formats
    assert "\n" not in exporter.loses


def test_unknown_suffix():
    with pytest.raises(InputError, match=r"unknown output format '.mp5': did you mean '.mp4'\?"):
        check_output("a.mp5")
    with pytest.raises(InputError, match=r"did you mean '.TextGrid'"):
        check_output("a.textgird")
    with pytest.raises(InputError, match=r"end its name in one of .*\.glb, \.fbx, .*\.TextGrid, \.wav, \.json"):
        check_output("a")


def test_importing_the_registry_is_light():
    """No renderer, codec or numerics library is loaded just to know the formats."""
    heavy = ("numba", "scipy", "av", "PIL", "soundfile", "pxr", "ezc3d")
    code = f"import sys, mien.formats; print([m for m in {heavy} if m in sys.modules])"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "[]"
