"""The studio's server is killed in the middle of the work; the page, a reload and a second window lose nothing."""

from __future__ import annotations

import json
import sys

import pytest

from tests.node import ROOT, chromium, installed, run

CHECK = ROOT / "tests" / "studio_check" / "survive.mjs"


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    browser, package, folder = chromium(), installed("studio"), tmp_path_factory.mktemp("survive")
    printed = run("node", str(CHECK), str(package), sys.executable, browser, str(folder), folder=ROOT)
    told = json.loads(printed.splitlines()[-1])
    assert "failed" not in told, told
    return told


def test_nothing_is_lost_when_the_server_is_killed(seen: dict) -> None:
    assert seen["complaints"] == []
    assert "is kept here until then" in seen["told"]
    assert seen["afterKill"] == [["jawOpen", 3]]
    assert seen["afterReload"] == {"same": True, "keys": [["jawOpen", 3]]}
    assert seen["secondWindow"]
    assert seen["handedBack"] == [["jawOpen", 3]], "one was undone in the second window, one came after"
    assert seen["address"]


def test_many_keys_are_chosen_copied_deleted_and_mirrored(seen: dict) -> None:
    assert seen["chosen"] == 3
    assert not seen["menuCut"], "something sticks out of the menu"
    assert seen["pasted"][0][1] > 3
    assert seen["deleted"] == []
    assert seen["undone"] == seen["pasted"]
    assert seen["mirrored"] == ["jawOpen", "mouthSmileLeft", "mouthSmileRight"]


def test_axe_finds_nothing_and_targets_are_large_enough_on_every_screen(seen: dict) -> None:
    assert seen["axe"] == {}
    assert seen["small"] == {}
    assert (seen["desk"], seen["upright"], seen["lying"]) == (1280, 390, 844)
