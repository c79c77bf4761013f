"""Writing files so that a reader never meets half of one, and nobody loses one that was there.

What is written goes into a temporary file beside its target, to the disk, and only then takes the target's name. The
temporary is locked while it is written: one that nobody holds was left by a program that was killed, and the next that
writes the same file takes it over. A command claims its outputs when it first asks whether they can be written
(`claimed_outputs`), so that of two that write the same file the second is told at once.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mien.core.errors import OutputError
from mien.core.temporary_folder import users_folder

__all__ = [
    "check_writable",
    "claimed_outputs",
    "folder_until_complete",
    "held_alone",
    "made_folders",
    "replace_when_complete",
]

_LONGEST_SUFFIX = 32
"""Characters; a longer one is no suffix that any program goes by, and the temporary's name stays short."""
_MOST_WRITERS = 16
"""Programs that write the same file at once and find a temporary of a known name."""
_STALE = 3600  # seconds
made_folders: list[Path] = []
"""Folders that were made for outputs, the outermost of each: a mistyped path is to be seen."""
_claims: dict[Path, tuple[Path, int]] | None = None
"""What this command claimed, with the lock files and the descriptors that hold them; None: nothing is claimed."""


@contextmanager
def claimed_outputs() -> Iterator[None]:
    """Claim each file that `check_writable` is asked about inside, until it is written or the block ends."""
    global _claims
    _claims = {}
    try:
        yield
    finally:
        for path in list(_claims):
            _release(path)
        _claims = None


def check_writable(path: str | Path) -> Path:
    """Say early whether a file could be written at ``path``; returns it as a Path.

    Raises
    ------
    OutputError
        If its folder is not writable and cannot be made, if ``path`` is a folder, or another command claimed it.
    """
    path = Path(path)
    _checked(path)
    _claim(path)
    return path


def _checked(path: Path) -> None:
    folder = path.parent
    try:
        path.lstat()
    except OSError as problem:
        if problem.errno not in (errno.ENOENT, errno.ENOTDIR, errno.EACCES):  # those are told apart below
            raise OutputError(f"cannot write {str(path)[:80]}: {problem.strerror}") from problem
    if path.is_dir():
        raise OutputError(f"cannot write {path}: it is a folder; give a file name")
    folder = next(above for above in (folder, *folder.parents) if above.exists())  # what is missing will be made
    if not folder.is_dir():
        raise OutputError(f"cannot write {path}: {folder} is not a folder")
    if not os.access(folder, os.W_OK) or (path.exists() and not os.access(path, os.W_OK)):
        raise OutputError(f"cannot write {path}: permission denied")


@contextmanager
def replace_when_complete(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path beside ``path``; it takes the place of ``path`` only if the block ends well.

    The temporary file keeps the suffix of ``path`` and is removed if the block fails. A folder that is missing is made.

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
    made = _missing_folders(path)
    unfinished, handle = _temporary(path)
    try:
        with _writing(path):
            yield unfinished
            umask = os.umask(0)
            os.umask(umask)
            unfinished.chmod(0o666 & ~umask)
            _to_disk(unfinished)
            unfinished.replace(path)
            _to_disk(path.parent)
            _release(path)
    finally:
        unfinished.unlink(missing_ok=True)
        os.close(handle)
        _remove_empty(made)


@contextmanager
def folder_until_complete(path: str | Path) -> Iterator[Path]:
    """Yield an empty folder beside ``path``, in which many files are made before they take their places; then it goes.

    One that a killed program left is emptied and used again.

    Raises
    ------
    OutputError
        If it cannot be made, or the disk fills up.
    """
    path = check_writable(path)
    mark = hashlib.sha256(path.name.encode("utf-8", "surrogateescape")).hexdigest()[:12]
    folder = path.parent / f".mien-{mark}-files"
    made = _missing_folders(path)
    try:
        with _writing(path):
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        _remove_empty(made)


def _missing_folders(path: Path) -> list[Path]:
    """Make the folders above a file that are missing; those that were made, the outermost first."""
    missing = [folder for folder in reversed(path.parents) if not folder.exists()]
    with _writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    made_folders.extend(missing[:1])
    return missing


def _remove_empty(folders: list[Path]) -> None:
    for folder in reversed(folders):
        with contextlib.suppress(OSError):
            folder.rmdir()  # stays where something lies in it


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    """Put what the system has against writing into one line."""
    try:
        yield
    except OSError as problem:
        if problem.errno == errno.ENOSPC:
            raise OutputError(f"cannot write {path}: the disk is full; free some space and run again") from problem
        raise OutputError(f"cannot write {path}: {problem.strerror or problem}") from problem


@contextmanager
def held_alone(path: str | Path, otherwise: str) -> Iterator[None]:
    """Hold a lock file while something is written that two programs must not write at once.

    The lock ends with the program, however that ends. Where the file system has no locks, nothing is held.

    Parameters
    ----------
    path : path-like
        Of the lock file; made, and removed at the end.
    otherwise : str
        What to say if another program holds it.

    Raises
    ------
    OutputError
        If another program holds it.
    """
    try:
        handle = _locked(Path(path))
    except BlockingIOError as problem:
        raise OutputError(f"{otherwise}: wait until it has ended") from problem
    except OSError as problem:
        raise OutputError(f"cannot write {path}: {problem.strerror}") from problem
    try:
        yield
    finally:
        Path(path).unlink(missing_ok=True)
        if handle is not None:
            os.close(handle)


def _locked(path: Path) -> int | None:
    """Make and lock a lock file; its descriptor, or None where there are no locks.

    Raises
    ------
    BlockingIOError
        If another holds it.
    OSError
        If it cannot be made.
    """
    try:
        import fcntl
    except ImportError:
        return None
    while True:
        handle = os.open(path, os.O_CREAT | os.O_RDWR | os.O_CLOEXEC | os.O_NOFOLLOW, 0o600)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as problem:
            os.close(handle)
            if isinstance(problem, BlockingIOError):
                raise
            return None  # no locks here
        if _is_at(handle, path):
            return handle
        os.close(handle)  # removed by the one that held it, between our opening and our locking


def _is_at(handle: int, path: Path) -> bool:
    """Whether an open file is the one, and the only one, of this name."""
    try:
        mine, there = os.fstat(handle), path.stat()
    except OSError:
        return False
    return (mine.st_dev, mine.st_ino) == (there.st_dev, there.st_ino) and mine.st_nlink == 1


def _claim(path: Path) -> None:
    """Hold the claim to an output; where no lock files can be made, nothing is claimed."""
    real = path.resolve()
    if _claims is None or real in _claims:
        return
    folder = users_folder()
    if folder is None:
        return
    lock = folder / hashlib.sha256(os.fsencode(real)).hexdigest()[:24]
    try:
        if not _claims:
            _sweep(folder)
        handle = _locked(lock)
    except BlockingIOError as problem:
        raise OutputError(
            f"cannot write {path}: another mien command is at work on it; wait until it has ended, or give another name"
        ) from problem
    except OSError:
        return
    if handle is not None:
        _claims[real] = (lock, handle)


def _sweep(folder: Path) -> None:
    """Remove what killed commands left of claims."""
    for lock in folder.iterdir():
        if not lock.is_file():
            continue
        with contextlib.suppress(OSError):
            if time.time() - lock.stat().st_mtime > _STALE and (handle := _locked(lock)) is not None:
                lock.unlink()
                os.close(handle)


def _release(path: Path) -> None:
    claim = _claims.pop(path.resolve(), None) if _claims else None
    if claim is not None:
        with contextlib.suppress(OSError):
            claim[0].unlink()
        os.close(claim[1])


def _temporary(path: Path) -> tuple[Path, int]:
    """A locked empty file beside ``path``, and its descriptor, which holds the lock.

    Its name follows from that of ``path``, so that what a killed program left is found and taken over.
    """
    mark = hashlib.sha256(path.name.encode("utf-8", "surrogateescape")).hexdigest()[:12]
    suffix = path.suffix if len(path.suffix) <= _LONGEST_SUFFIX else ""
    try:
        for number in range(_MOST_WRITERS):
            name = path.parent / f".mien-{mark}-{number}{suffix}"
            handle = _taken(name)
            if handle is not None:
                return name, handle
        handle, other = tempfile.mkstemp(prefix=f".mien-{mark}-", suffix=suffix, dir=path.parent)
    except OSError as problem:
        raise OutputError(f"cannot write {path}: {problem.strerror}") from problem
    return Path(other), handle


def _taken(name: Path) -> int | None:
    """Make or take over a temporary and lock it; None if it is somebody else's, or there are no locks here."""
    try:
        import fcntl

        handle = os.open(name, os.O_CREAT | os.O_RDWR | os.O_CLOEXEC | os.O_NOFOLLOW, 0o600)
    except ImportError:
        return None
    except OSError as problem:
        if problem.errno in (errno.ELOOP, errno.EACCES, errno.EPERM, errno.EISDIR):  # another's, or a trap
            return None
        raise
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if _is_at(handle, name):
            os.ftruncate(handle, 0)
            return handle
    except OSError:  # held, renamed or removed meanwhile, or a file system without locks
        pass
    os.close(handle)
    return None


def _to_disk(path: Path) -> None:
    """Have a file's content, or a folder's names, on the disk; file systems that cannot are left in peace."""
    with contextlib.suppress(OSError):
        handle = os.open(path, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
