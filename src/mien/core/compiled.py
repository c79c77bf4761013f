"""The compiler of our kernels, and where it keeps what it compiled.

numba keeps machine code beside the source, or under the home directory, and refuses to compile at all where it can
write to neither (a read-only installation, a service without a home). So the folder is chosen here, once, before numba
is loaded: beside the source, ``~/.cache/mien``, the folder for temporary files; else nothing is kept and every start
compiles again. All kernels take ``njit`` from here.

numba is loaded when a kernel is first called: loading it takes longer than speaking a line, which needs none.
"""

from __future__ import annotations

import contextlib
import os
import stat
import tempfile
import threading
import warnings
from collections.abc import Callable, Mapping
from functools import cache, update_wrapper
from pathlib import Path
from types import ModuleType
from typing import Any

__all__ = ["Kernel", "cache_folder", "cache_note", "compilations", "kept", "njit", "when_compiling"]

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


@cache
def _folder() -> Path | None:
    return cache_folder(os.environ, Path(__file__).parent, _temporary_folder())


def kept() -> bool:
    """Whether compiled kernels are kept between starts."""
    return _folder() is not None


@cache
def _numba() -> ModuleType:
    folder = _folder()
    if folder is not None and folder != Path(__file__).parent / "__pycache__":
        os.environ[_VARIABLE] = str(folder)
    import numba

    # Without semaphores (/dev/shm read-only) it warns of programs that fork while they compile: we do not.
    warnings.simplefilter("ignore", numba.errors.NumbaSystemWarning)
    if _VARIABLE in os.environ:  # somebody may have loaded it before
        numba.config.CACHE_DIR = os.environ[_VARIABLE]  # type: ignore[attr-defined]
    return numba


_one_at_a_time = threading.RLock()
_in_work: list[Kernel] = []
_made: list[Any] = []
_to_tell: Callable[[], None] | None = None


class Kernel:
    """A function that numba compiles (or reads from its cache) when it is first called.

    Parameters
    ----------
    function : callable
    options : mapping
        Of `numba.njit`.
    """

    def __init__(self, function: Callable[..., Any], options: Mapping[str, Any]) -> None:
        self.py_func, self._options = function, options
        self._compiled: Callable[..., Any] | None = None
        self._ready: Callable[..., Any] | None = None
        update_wrapper(self, function)

    def __call__(self, *given: Any) -> Any:
        """Run it."""
        return (self._ready or self.compiled())(*given)

    def compiled(self) -> Callable[..., Any]:
        """What numba makes of it; the kernels that it calls by name become numba's as well.

        A kernel is ready only when all that it calls are: another thread that comes meanwhile waits.
        """
        with _one_at_a_time:
            if self._compiled is not None:
                return self._compiled
            _in_work.append(self)
            numba, options = _numba(), dict(self._options)
            options["cache"] = options.get("cache", False) and kept()
            compiled = self._compiled = numba.njit(**options)(self.py_func)
            _made.append(compiled)
            _tell_if_new(compiled)
            names = self.py_func.__globals__
            found = {name: value for name, value in names.items() if isinstance(value, Kernel)}
            # All at once: another thread that takes one of them from its module calls it without waiting here.
            names.update({name: value.compiled() for name, value in found.items()})
            if _in_work[0] is self:
                for kernel in _in_work:
                    kernel._ready = kernel._compiled
                _in_work.clear()
            return compiled  # type: ignore[no-any-return]


def njit(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """`numba.njit` at the first call, kept between starts where there is a place for it."""
    return lambda function: Kernel(function, options)


def when_compiling(tell: Callable[[], None] | None) -> None:
    """Have something called, once, when a kernel is about to be compiled that no earlier start has kept."""
    global _to_tell
    _to_tell = tell


def _tell_if_new(compiled: Any) -> None:
    global _to_tell
    index = getattr(getattr(getattr(compiled, "_cache", None), "_cache_file", None), "_index_path", None)
    if _to_tell is not None and (index is None or not Path(index).exists()):
        tell, _to_tell = _to_tell, None
        tell()


def compilations() -> int:
    """How many versions of kernels numba has compiled or read from its cache so far."""
    return sum(len(kernel.signatures) for kernel in _made)


def cache_note() -> str:
    """One line on where compiled kernels are kept, for `mien doctor`."""
    folder = _folder()
    if folder is None:
        return "compiled kernels are kept nowhere (nothing can be written): each start compiles for half a minute"
    return f"compiled kernels are kept in {folder}"
