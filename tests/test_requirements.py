"""The lock files say what `pyproject.toml` asks for, in the versions of `constraints.txt`, with hashes."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
ABOUT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
EXTRAS = ABOUT["project"]["optional-dependencies"]


def called(requirement: str) -> str:
    return re.sub(r"[-_.]+", "-", re.split(r"[\s=<>;\[!~]", requirement.strip(), maxsplit=1)[0]).lower()


def locked(name: str) -> dict[str, str]:
    entries = re.split(r"\n(?=\w)", (ROOT / "requirements" / f"{name}.txt").read_text(encoding="utf-8"))[1:]
    assert all("--hash=sha256:" in entry for entry in entries)
    return {called(entry): entry.split()[0].partition("==")[2] for entry in entries}


@pytest.mark.parametrize("name", ["core", *EXTRAS])
def test_what_is_asked_for_is_locked_in_the_pinned_version(name: str) -> None:
    found = locked("core") | locked(name)
    asked = ABOUT["build-system"]["requires"] + ABOUT["project"]["dependencies"] + EXTRAS.get(name, [])
    assert {called(requirement) for requirement in asked} - {"mien"} <= set(found), "run make lock"
    pinned = (line.partition("==") for line in (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines())
    versions = {called(package): version for package, mark, version in pinned if mark}
    assert {p: v for p, v in found.items() if p in versions and v != versions[p]} == {}, "run make lock"
