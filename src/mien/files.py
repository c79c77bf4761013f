"""Writing files so that a reader never meets half of one."""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mien.errors import OutputError

__all__ = ["check_writable", "replace_when_complete"]


def check_writable(path: str | Path) -> Path:
    """Say early whether a file could be written at ``path``; returns it as a Path.

    Raises
    ------
    OutputError
        If its folder is missing or not writable, or if ``path`` is a folder.
    """
    path = Path(path)
    folder = path.parent
    try:
        path.lstat()
    except OSError as problem:
        if problem.errno not in (errno.ENOENT, errno.ENOTDIR, errno.EACCES):  # those are told apart below
            raise OutputError(f"cannot write {str(path)[:80]}: {problem.strerror}") from problem
    if path.is_dir():
        raise OutputError(f"cannot write {path}: it is a folder; give a file name")
    if not folder.exists():
        raise OutputError(f"cannot write {path}: the folder {folder} does not exist; make it first")
    if not folder.is_dir():
        raise OutputError(f"cannot write {path}: {folder} is not a folder")
    if not os.access(folder, os.W_OK) or (path.exists() and not os.access(path, os.W_OK)):
        raise OutputError(f"cannot write {path}: permission denied")
    return path


@contextmanager
def replace_when_complete(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path beside ``path``; it takes the place of ``path`` only if the block ends well.

    The temporary file keeps the suffix of ``path`` and is removed if the block fails.

    Raises
    ------
    OutputError
        If the file cannot be made, or the disk fills up.

    Examples
    --------
    >>> import tempfile; folder = tempfile.TemporaryDirectory()
    >>> with replace_when_complete(Path(folder.name) / "line.txt") as unfinished:
    ...     _ = unfinished.write_text("done")
    >>> (Path(folder.name) / "line.txt").read_text()
    'done'
    """
    path = check_writable(path)
    if path.is_symlink():  # what the link points to is replaced, not the link
        path = check_writable(path.resolve())
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent)
        os.close(handle)
    except OSError as problem:
        raise OutputError(f"cannot write {path}: {problem.strerror}") from problem
    unfinished = Path(name)
    try:
        yield unfinished
        umask = os.umask(0)
        os.umask(umask)
        unfinished.chmod(0o666 & ~umask)
        unfinished.replace(path)
    except OSError as problem:
        if problem.errno == errno.ENOSPC:
            raise OutputError(f"cannot write {path}: the disk is full; free some space and run again") from problem
        raise OutputError(f"cannot write {path}: {problem.strerror or problem}") from problem
    finally:
        unfinished.unlink(missing_ok=True)
