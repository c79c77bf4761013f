"""Cameras and lights by name or by file: a table (TOML) each, in ``assets/render``; a new file there is a new name."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from pathlib import Path
from typing import Any

from mien.core.assets import asset_table, assets_in, read_table
from mien.core.errors import InputError, unknown_name

__all__ = ["fields_of", "known_tables", "numbers", "table_of"]


def known_tables(kind: str) -> tuple[str, ...]:
    """Names of the tables of a kind, ``cameras`` or ``lights``, the usual one first.

    Examples
    --------
    >>> known_tables("lights")
    ('portrait', 'dramatic', 'even', 'soft')
    """
    return tuple(sorted(assets_in(f"render/{kind}"), key=lambda name: name != "portrait"))


def table_of(kind: str, name: str | Path) -> dict[str, Any]:
    """The table of a name, or of a ``.toml`` file.

    Raises
    ------
    InputError
        If there is neither, or the file is no TOML.
    """
    if str(name).lower().endswith(".toml"):
        return read_table(Path(name))
    if str(name) not in known_tables(kind):
        problem = unknown_name(kind.removesuffix("s"), str(name)[:80], known_tables(kind))
        raise InputError(f"{problem}; or a .toml file of yours")
    return asset_table(f"render/{kind}/{name}.toml")


def fields_of(table: Mapping[str, Any], names: tuple[str, ...], where: object) -> Mapping[str, Any]:
    """The table, if it has these fields and no other.

    Raises
    ------
    InputError
        Naming the field that is missing or not known.
    """
    if not isinstance(table, Mapping):
        raise InputError(f"{where}: expected a table with {', '.join(names)}")
    for name in table:
        if name not in names:
            raise InputError(f"{where}: {unknown_name('field', str(name), names)}")
    missing = [name for name in names if name not in table]
    if missing:
        raise InputError(f"{where}: the field {missing[0]!r} is missing; a table has {', '.join(names)}")
    return table


def numbers(value: object, count: int, field: str, where: object) -> list[float]:
    """So many finite numbers; one need not stand in a list.

    Raises
    ------
    InputError
        If it is anything else.
    """
    given: list[Any] = list(value) if isinstance(value, list) else [value]
    right = all(isinstance(each, (int, float)) and not isinstance(each, bool) and isfinite(each) for each in given)
    if len(given) != count or not right:
        raise InputError(f"{where}: {field} is {'a number' if count == 1 else f'{count} numbers'}, not {value!r}")
    return [float(each) for each in given]
