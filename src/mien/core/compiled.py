"""The compiler of our kernels, and where it keeps what it compiled.

numba keeps machine code beside the source, or under the home directory, and refuses to compile at all where it can
write to neither (a read-only installation, a service without a home). So the folder is chosen here, once, before numba
is loaded: beside the source, ``~/.cache/mien``, the folder for temporary files; else nothing is kept and every start
compiles again. All kernels take ``njit`` from here.
"""

from __future__ import annotations

import contextlib
import os
import stat
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

__all__ = ["KEPT", "cache_folder", "cache_note", "njit", "prange"]

_VARIABLE = "NUMBA_CACHE_DIR"


def cache_folder(environment: Mapping[str, str], source: Path, temporary: Path) -> Path | None:
    """Where compiled kernels are kept; None if nowhere.

    Parameters
    ----------
    environment : mapping
        ``NUMBA_CACHE_DIR`` is obeyed if it can be written.
    source : Path
        The folder of the kernels' source: numba's own place, ``__pycache__`` in it.
    temporary : Path
        The folder for temporary files; in it a folder of this user's alone.
    """
    given = environment.get(_VARIABLE)
    home = environment.get("XDG_CACHE_HOME") or (environment.get("HOME") and f"{environment['HOME']}/.cache")
    own = temporary / f"mien-{os.getuid() if hasattr(os, 'getuid') else 0}"
    choices = ([Path(given)] if given else []) + [source / "__pycache__"]
    choices += [Path(home) / "mien"] if home else []
    found = next((folder for folder in choices if _is_writable(folder)), None)
    return found or (own if _is_writable(own) and _is_ours_alone(own) else None)


def _is_writable(folder: Path) -> bool:
    with contextlib.suppress(OSError):
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    return False


def _is_ours_alone(folder: Path) -> bool:
    """Whether nobody else can write there: machine code is loaded from it."""
    about = folder.lstat()
    own = not hasattr(os, "getuid") or about.st_uid == os.getuid()
    return own and stat.S_ISDIR(about.st_mode) and not about.st_mode & (stat.S_IWOTH | stat.S_IWGRP)


def _temporary_folder() -> Path:
    try:
        return Path(tempfile.gettempdir())
    except OSError:  # not even a temporary file can be written
        return Path(os.devnull)


_source = Path(__file__).parent
_folder = cache_folder(os.environ, _source, _temporary_folder())
if _folder is not None and _folder != _source / "__pycache__":
    os.environ[_VARIABLE] = str(_folder)

import numba  # noqa: E402 - it reads the variable when it is loaded

if _VARIABLE in os.environ:  # somebody may have loaded it before
    numba.config.CACHE_DIR = os.environ[_VARIABLE]  # type: ignore[attr-defined]

prange = numba.prange
KEPT = _folder is not None
"""Whether compiled kernels are kept between starts."""


def njit(**options: Any) -> Callable[[Any], Any]:
    """`numba.njit`, kept between starts where there is a place for it."""
    return numba.njit(**{**options, "cache": options.get("cache", False) and KEPT})  # type: ignore[no-any-return]


def cache_note() -> str:
    """One line on where compiled kernels are kept, for `mien doctor`."""
    if _folder is None:
        return "compiled kernels are kept nowhere (nothing can be written): each start compiles for half a minute"
    return f"compiled kernels are kept in {_folder}"
