"""Folders for what a command makes on its way: gone when it ends, and swept by the next command when it was killed.

All lie in one folder of this user's alone, ``mien-UID`` in the folder for temporary files. Each is locked while it is
used: one that nobody holds was left by a program that was killed.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mien.core.errors import OutputError

__all__ = ["temporary_folder", "users_folder"]

_PREFIX = "work-"


def users_folder() -> Path | None:
    """The folder of this user's temporary files and locks, made if it is not there; None if there can be none."""
    user = os.getuid() if hasattr(os, "getuid") else 0
    try:
        folder = Path(tempfile.gettempdir()) / f"mien-{user}"
        folder.mkdir(mode=0o700, exist_ok=True)
        return folder if folder.lstat().st_uid == user and not folder.is_symlink() else None
    except OSError:
        return None


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Yield an empty folder that is removed at the end; what killed programs left of theirs is removed as well.

    Raises
    ------
    OutputError
        If none can be made.

    Examples
    --------
    >>> with temporary_folder() as folder:
    ...     folder.is_dir()
    True
    >>> folder.exists()
    False
    """
    try:
        folder, handle = _made()
    except OSError as problem:
        told = "no folder for temporary files can be written; set TMPDIR to one of yours"
        raise OutputError(f"{told} ({problem.strerror or problem})") from problem
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if handle is not None:
            os.close(handle)


def _made() -> tuple[Path, int | None]:
    """A new folder, and the descriptor that holds its lock (None where there are no locks)."""
    base = users_folder()
    try:
        import fcntl
    except ImportError:
        base = None
    if base is None:
        return Path(tempfile.mkdtemp(prefix="mien-")), None
    everyone = os.open(base, os.O_RDONLY | os.O_CLOEXEC)
    try:
        with contextlib.suppress(OSError):  # a file system without locks
            fcntl.flock(everyone, fcntl.LOCK_EX)  # nobody sweeps between the making and the locking of a folder
        _sweep(base)
        folder = Path(tempfile.mkdtemp(prefix=_PREFIX, dir=base))
        return folder, _held(folder)
    finally:
        os.close(everyone)


def _held(folder: Path) -> int | None:
    """A descriptor that holds a folder; None if another program does, or it cannot be known."""
    import fcntl

    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY | os.O_CLOEXEC | os.O_NOFOLLOW)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return handle
        except OSError:
            os.close(handle)
    return None


def _sweep(base: Path) -> None:
    for folder in base.glob(f"{_PREFIX}*"):
        if (handle := _held(folder)) is not None:
            shutil.rmtree(folder, ignore_errors=True)
            os.close(handle)
