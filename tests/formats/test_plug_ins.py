"""Formats that other packages bring: a tiny package with an entry point, on the path as an installed one is."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from mien.core import plug_ins
from mien.core.errors import InputError
from mien.formats import registry
from tests.faces import tiny_animation

MODULE = """
from pathlib import Path

from mien.formats import Exporter


def write(animation, path, face, progress):
    Path(path).write_text(f"{len(animation.channels)} frames")
    return ()


COUNT = Exporter(".frames", "how many frames there are", "everything else", False, write)
TAKEN = Exporter(".GLB", "a rival", "everything", False, write)
NOTHING = "no exporter"
"""


@pytest.fixture
def bring(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Installs a package ``framecount`` whose entry point is the given name in its module."""

    def install(value: str) -> None:
        (tmp_path / "framecount.py").write_text(MODULE)
        about = tmp_path / "framecount-1.0.dist-info"
        about.mkdir()
        (about / "METADATA").write_text("Metadata-Version: 2.1\nName: framecount\nVersion: 1.0\n")
        (about / "entry_points.txt").write_text(f"[{registry.PLUG_INS}]\nframes = {value}\n")
        monkeypatch.syspath_prepend(str(tmp_path))
        monkeypatch.delitem(sys.modules, "framecount", raising=False)
        plug_ins._entries.cache_clear()

    yield install
    plug_ins._entries.cache_clear()


def test_a_format_of_another_package_is_written_and_listed(bring, tmp_path: Path) -> None:
    bring("framecount:COUNT")
    assert registry.exporters()[-1].suffix == ".frames"
    assert registry.save(tiny_animation(6), tmp_path / "line.frames") == ()
    assert (tmp_path / "line.frames").read_text() == "6 frames"
    with pytest.raises(InputError, match=r"known: .*\.frames"):
        registry.check_output(tmp_path / "line.frame5")


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("framecount:TAKEN", "framecount brings the format .GLB, which mien has already"),
        ("framecount:NOTHING", "expected an Exporter, got str"),
        ("framecount:MISSING", "cannot be loaded"),
        ("not_there:COUNT", "cannot be loaded"),
    ],
)
def test_a_package_at_fault_is_named_and_own_formats_go_on(bring, tmp_path: Path, value: str, said: str) -> None:
    bring(value)
    with pytest.raises(InputError, match=said) as caught:
        registry.exporters()
    assert "framecount" in str(caught.value)
    assert registry.check_output(tmp_path / "line.csv")
