"""Tables and files that come with mien, and tables of the user's own, which go before them.

Knowledge is data: a language, a light or a recipe is a file under ``assets``. Whoever wants another one puts a file of
the same form, under the same path, into a folder of their own (`own_folder`); nothing of mien is edited.
"""

from __future__ import annotations

import os
import tomllib
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from mien.core.border import guarded
from mien.core.errors import InputError
from mien.core.plain_text import read_plain_text

__all__ = ["OWN_TABLES", "asset", "asset_table", "assets_folder", "assets_in", "own_folder", "own_tables", "read_table"]

OWN_TABLES = "MIEN_TABLES"
"""Environment variable that names the folder of tables of one's own."""
_FOLDERS = (OWN_TABLES, "XDG_CONFIG_HOME", "HOME")


@cache
def assets_folder() -> Path:
    """The folder of what comes with mien."""
    return Path(str(resources.files("mien") / "assets"))


def own_folder() -> Path | None:
    """The folder of tables of the user's own: ``MIEN_TABLES``, or ``mien`` in the user's folder of settings; or None.

    Raises
    ------
    InputError
        If ``MIEN_TABLES`` names no folder.
    """
    named = os.environ.get(OWN_TABLES)
    if named:
        if not Path(named).is_dir():
            raise InputError(f"{named}: no such folder ({OWN_TABLES} names the folder of your own tables)")
        return Path(named)
    settings = os.environ.get("XDG_CONFIG_HOME") or os.path.expanduser("~/.config")  # noqa: PTH111 - HOME may be missing
    folder = Path(settings) / "mien"
    return folder if folder.is_dir() else None


def own_tables() -> tuple[str, ...]:
    """Paths in `own_folder` of every table that is read from there, in order."""
    own = own_folder()
    return () if own is None else tuple(sorted(str(path.relative_to(own)) for path in own.rglob("*.toml")))


def asset(path: str) -> Path:
    """Where a file of ``assets`` lies; the user's own goes before, if it is a table.

    Examples
    --------
    >>> asset("phones/arpabet.toml").name
    'arpabet.toml'
    """
    return _place(path, *(os.environ.get(name) for name in _FOLDERS))


@cache
def _place(path: str, *_folders: str | None) -> Path:
    """Looked up once for each setting of the folders: tables are asked for word by word."""
    own = own_folder() if path.endswith(".toml") else None
    return own / path if own is not None and (own / path).is_file() else assets_folder() / path


def asset_table(path: str) -> dict[str, Any]:
    """A table of ``assets`` as nested dictionaries; read once, so leave it as it is.

    Raises
    ------
    InputError
        If it is the user's own and no TOML.

    Examples
    --------
    >>> sorted(asset_table("phones/arpabet.toml"))[:2]
    ['affricate', 'diphthong']
    """
    return _table(asset(path))


@cache
def _table(path: Path) -> dict[str, Any]:
    return read_table(path)


@guarded("a table")
def read_table(path: Path) -> dict[str, Any]:
    """A TOML file as nested dictionaries.

    Raises
    ------
    InputError
        If it cannot be read, or is no TOML.
    """
    text, _ = read_plain_text(path, "a table")
    return tomllib.loads(text)


def assets_in(folder: str, suffix: str = ".toml") -> dict[str, Path]:
    """Files of a folder of ``assets`` by their names without suffix, in order; the user's own among them.

    Examples
    --------
    >>> "fi" in assets_in("languages")
    True
    """
    folders = [assets_folder() / folder]
    own = own_folder() if suffix == ".toml" else None
    if own is not None:
        folders.append(own / folder)
    found = {path.name.removesuffix(suffix): path for one in folders for path in one.glob(f"*{suffix}")}
    return {name: found[name] for name in sorted(found)}
