"""The contract that every output format keeps."""

from __future__ import annotations

import errno
import json
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


def named(kind, suffix):
    """A name with all that shells and writers stumble over, or as long as the file system takes."""
    odd = f" näyte “1” 'a' \"b\" 😀 %s {{id}} #?*&;$HOME{suffix}"
    return odd if kind == "odd" else "é" * ((255 - len(suffix)) // 2) + "x" * ((255 - len(suffix)) % 2) + suffix


@pytest.mark.parametrize("kind", ["odd", "long"])
@every_own
def test_any_name_and_overwriting(exporter, kind, animation, face, tmp_path):
    if exporter.companion and kind == "long":
        pytest.skip("its folder beside it has a longer name; that is refused in one line")
    folder = tmp_path / "Äänet 声 ' \" 😀"
    folder.mkdir()
    path = folder / named(kind, exporter.suffix)
    path.write_text("old")
    save(animation, path, face=face)
    assert path.read_bytes() != b"old"
    assert sorted(folder.iterdir()) == sorted([path, *beside(exporter, path)])


FULL = """
import json, resource, sys
from pathlib import Path
from mien.core.errors import OutputError
from mien.face.render.view import View
from mien.formats import EXPORTERS, save
from tests.faces import tiny_animation, tiny_face
animation, face, told, view = tiny_animation(6), tiny_face(), {}, View().of_size(160, 160)
for exporter in (one for one in EXPORTERS if one.suffix != ".fbx"):
    folder = Path(sys.argv[1]) / exporter.suffix[1:]
    (folder / "full").mkdir(parents=True)
    save(animation, folder / f"a{exporter.suffix}", face=face, view=view)
    most = max(path.stat().st_size for path in folder.rglob("*") if path.is_file()) // 2
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, -1))
    try:
        save(animation, folder / "full" / f"a{exporter.suffix}", face=face, view=view)
        told[exporter.suffix] = "written"
    except OutputError as problem:
        told[exporter.suffix] = str(problem)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (-1, -1))
print(json.dumps(told))
"""


def test_a_file_that_cannot_grow_is_one_line_and_leaves_nothing(tmp_path):
    """As on a full disk, but that the writers themselves meet it, in the middle of what they write."""
    done = subprocess.run([sys.executable, "-c", FULL, str(tmp_path)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    told = json.loads(done.stdout.splitlines()[-1])
    assert set(told) == {exporter.suffix for exporter in EXPORTERS} - {".fbx"}
    assert all(words.startswith("cannot write") and "\n" not in words for words in told.values()), told
    assert [path for folder in tmp_path.iterdir() for path in (folder / "full").iterdir()] == []


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
