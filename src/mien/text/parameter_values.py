"""Reading the attributes of an element."""

from __future__ import annotations

import math

from mien.core.errors import InputError, unknown_name

__all__ = ["Given", "needed", "number", "only"]

Given = dict[str, str]


def only(given: Given, *names: str) -> None:
    """Refuse attributes that an element does not have."""
    for name in given:
        if name not in names and not name.startswith("xml:") and name != "id":
            raise unknown_name("attribute", name, names) if names else InputError(f"it has no attribute {name!r}")


def number(given: Given, name: str, default: float | None = None) -> float:
    """A number; without a default it has to be given."""
    if name not in given:
        if default is None:
            raise InputError(f"{name}= is missing")
        return default
    try:
        found = float(given[name])
    except ValueError:
        found = math.nan
    if not math.isfinite(found):
        raise InputError(f"{name} is a number, not {given[name]!r}")
    return found


def needed(given: Given, name: str) -> str:
    """A text that has to be given."""
    if not given.get(name, "").strip():
        raise InputError(f"{name}= is missing")
    return given[name].strip()
