"""The studio's page: what is committed is what its sources build, and it needs nothing from elsewhere."""

from __future__ import annotations

import re
from pathlib import Path

from tests.node import ROOT, installed, run

BUILT = ROOT / "src" / "mien" / "assets" / "studio"


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def test_built_page_is_that_of_its_sources(tmp_path, monkeypatch):
    folder = installed("studio")
    monkeypatch.setenv("MIEN_PAGE", str(tmp_path / "page"))
    run("npm", "run", "types", folder=folder)
    run("npm", "run", "build", folder=folder)
    assert contents(tmp_path / "page") == contents(BUILT), "run make page, and commit what it writes"


def test_unit_tests():
    run("npm", "test", folder=installed("studio"))


def test_lock_files_name_no_host():
    for package in ("studio", "viewer"):
        text = (ROOT / package / "package-lock.json").read_text("utf-8")
        assert '"resolved"' not in text
        versions = re.findall(
            r'"(?:dev)?Dependencies": \{([^}]*)\}', (ROOT / package / "package.json").read_text("utf-8")
        )
        assert not re.search(r'"[\^~><*]', ",".join(versions)), "exact versions only"


def test_page_is_small_and_all_its_own():
    page = contents(BUILT)
    assert not [name for name in page if name.endswith(".map")]
    decoders = [name for name in page if "basis" in name or "draco" in name]  # fetched when a head needs them
    assert sum(len(content) for name, content in page.items() if name not in decoders) < 1_500_000
    index = page["index.html"].decode()
    for address in re.findall(r'(?:src|href)="([^"]+)"', index):
        assert address.startswith(("./assets/", "data:")), address
    assert not re.search(r"<script(?![^>]*src=)", index), "the policy of the studio forbids scripts in the page itself"
    styles = b"".join(content for name, content in page.items() if name.endswith(".css"))
    assert b"@import" not in styles
    assert b"url(http" not in styles
