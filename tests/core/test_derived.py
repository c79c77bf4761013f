"""What was worked out when mien was built is what would be worked out now."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from mien.core import derived

ROOT = Path(__file__).parents[2]


def _tool() -> ModuleType:
    found = importlib.util.spec_from_file_location("derive", ROOT / "tools/derive.py")
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


MADE = _tool().MADE


@pytest.mark.parametrize("name", MADE)
def test_it_is_current(name: str) -> None:
    sources, made = MADE[name]
    kept = derived.read_derived(name, sources)
    assert kept is not None, f"{name} is out of date: a file of {sources} changed; run: python tools/derive.py"
    fresh = made()
    assert sorted(kept) == sorted(fresh)
    for key, array in fresh.items():
        np.testing.assert_allclose(
            kept[key], array, rtol=1e-9, atol=1e-12, err_msg=f"{name}: {key}; run: python tools/derive.py"
        )


def test_nothing_is_read_once_a_source_has_changed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(derived, "assets_folder", lambda: tmp_path)
    monkeypatch.setattr(derived, "asset", lambda path: tmp_path / path)
    (tmp_path / "derived").mkdir()
    (tmp_path / "source").write_text("one")
    assert derived.read_derived("made", ["source"]) is None
    derived.write_derived("made", ["source"], {"numbers": np.arange(3)})
    kept = derived.read_derived("made", ["source"])
    assert kept is not None
    assert kept["numbers"].tolist() == [0, 1, 2]
    (tmp_path / "source").write_text("two")
    assert derived.read_derived("made", ["source"]) is None
