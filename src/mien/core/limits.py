"""How much mien takes: sizes are judged here before anything is decoded or allocated.

Every limit has a name. What is too large is one line that names the limit and the variable that raises it::

    bomb.png: 169,000,000 pixels; the limit is 100,000,000: MIEN_MOST_PIXELS=... raises it

The limits are far above what recordings, faces and scripts hold, and far below what fills a computer's memory.
"""

from __future__ import annotations

import math
import os
import re
import struct
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from mien.core.errors import InputError

if TYPE_CHECKING:  # help reads a table, and is not to wait for numpy
    import numpy as np
    from numpy.typing import NDArray

__all__ = [
    "LIMITS",
    "Limit",
    "array_header",
    "array_of",
    "check_begun",
    "check_size",
    "file_beside",
    "fraction_of",
    "is_whole",
    "load_array",
    "load_arrays",
    "most",
    "opened",
    "read_bytes",
    "read_member",
]


@dataclass(frozen=True)
class Limit:
    """How much of something is taken.

    Attributes
    ----------
    most : int
    unit : str
        What is counted, for the message.
    """

    most: int
    unit: str


LIMITS: dict[str, Limit] = {
    "file": Limit(4 * 2**30, "bytes in one file"),
    "text": Limit(2**26, "bytes of text"),
    "document": Limit(2**29, "bytes of JSON"),
    "mesh": Limit(2**30, "bytes of a mesh"),
    "unpacked": Limit(2 * 2**30, "bytes when unpacked"),
    "numbers": Limit(100_000_000, "numbers"),
    "pixels": Limit(100_000_000, "pixels"),
    "hours": Limit(4, "hours of sound"),
    "channels": Limit(64, "channels of sound"),
    "frames": Limit(5_000_000, "frames"),
    "rows": Limit(5_000_000, "rows"),
    "keys": Limit(1_000_000, "keys"),
    "levels": Limit(200, "levels, one inside the other"),
    "elements": Limit(1_000_000, "elements"),
    "spoken": Limit(300_000, "characters to say at once, about four hours"),
    "word": Limit(200, "letters in one word"),
    "name": Limit(10_000, "characters in a name"),
    "stimuli": Limit(1_000_000, "stimuli"),
    "digits": Limit(400, "characters in a number"),
}
"""Every limit by its name; the environment variable ``MIEN_MOST_<NAME>`` sets another."""

_MOST_DIGITS = 18
_ROOM = 2**20  # bytes
_NUMBER = re.compile(r"\s*[-+]?(?:\d+(?:/\d+)?|\d*\.?\d+|\d+\.)(?:[eE](?P<power>[-+]?\d+))?\s*", re.ASCII)


def most(name: str) -> float:
    """The limit of this name, or what the environment sets instead.

    Examples
    --------
    >>> most("levels")
    200
    """
    asked = os.environ.get(f"MIEN_MOST_{name.upper()}", "")
    try:
        return float(asked) if asked.strip() else LIMITS[name].most
    except ValueError as problem:
        raise InputError(f"MIEN_MOST_{name.upper()}: expected a number, got {asked!r}") from problem


def check_size(name: str, size: float, where: object) -> None:
    """Refuse what is larger than a limit.

    Parameters
    ----------
    name : str
        One of `LIMITS`.
    size : float
        In the unit of that limit.
    where : object
        The file (and the place in it), for the message.

    Raises
    ------
    InputError
        If ``size`` is above the limit.

    Examples
    --------
    >>> check_size("pixels", 13_000 * 13_000, "bomb.png")
    Traceback (most recent call last):
    mien.core.errors.InputError: bomb.png: 169,000,000 pixels; the limit is 100,000,000: MIEN_MOST_PIXELS=... raises it
    """
    limit = most(name)
    if not size <= limit:
        told = f"{size:,.0f}" if float(size).is_integer() else f"{size:,.1f}"
        raise InputError(
            f"{where}: {told} {LIMITS[name].unit}; the limit is {limit:,.0f}: MIEN_MOST_{name.upper()}=... raises it"
        )


def read_bytes(path: str | Path, limit: str = "file") -> bytes:
    """The content of a file that is a file, and no larger than a limit.

    Raises
    ------
    InputError
        If it is missing, a folder, a device or a pipe, too large, or cannot be read.
    """
    with opened(path, limit) as file, _told_of(path):
        content = file.read(int(most(limit)) + 1)
    check_size(limit, len(content), path)
    return content


def opened(path: str | Path, limit: str = "file") -> IO[bytes]:
    """Open a file that is a file, and no larger than a limit.

    Raises
    ------
    InputError
        As `read_bytes`.
    """
    path = Path(path)
    with _told_of(path):
        if path.is_dir():
            raise InputError(f"{path}: expected a file, got a folder")
        if not path.exists():
            raise InputError(f"{path}: no such file")
        if not path.is_file() and not path.is_fifo():
            raise InputError(f"{path}: expected a file, got a device")
        check_size(limit, path.stat().st_size, path)
        return path.open("rb")  # the caller closes it


@contextmanager
def _told_of(path: object) -> Iterator[None]:
    try:
        yield
    except (OSError, ValueError) as problem:  # ValueError: a zero byte in the name
        raise InputError(f"{str(path)[:200]}: cannot be read ({getattr(problem, 'strerror', problem)})") from problem


def check_begun(path: str | Path) -> None:
    """Refuse a file that begins with a million zeros: room that a download or a copy set aside and never filled.

    Decoders look through all of it for a beginning, for minutes.

    Raises
    ------
    InputError
        If it does, or cannot be read.
    """
    if not Path(path).is_file():  # a pipe is read once; what is missing is told by who reads it
        return
    with open_quietly(path) as file:
        begin = file.read(_ROOM)
    if len(begin) == _ROOM and not begin.strip(b"\0"):
        raise InputError(f"{path}: nothing but zeros at its beginning: did its download or copy come to an end?")


def fraction_of(value: float | str | Fraction, where: str) -> Fraction:
    """An exact number out of a text, without the minutes that ``Fraction("1e99999999")`` would take.

    Raises
    ------
    InputError
        If it is no number, or one with too many digits or too large a power of ten.

    Examples
    --------
    >>> fraction_of("30000/1001", "rate")
    Fraction(30000, 1001)
    """
    if isinstance(value, str):
        check_size("digits", len(value), where)
        found = _NUMBER.fullmatch(value)
        power = found and found["power"]
        if found is None or (power and (len(power) > 4 or abs(int(power)) > 300)):
            raise InputError(f"{where}: expected a number such as 30 or 30000/1001, got {value[:40]!r}")
    try:
        return Fraction(value)
    except (ValueError, TypeError, ZeroDivisionError, OverflowError) as problem:
        raise InputError(f"{where}: expected a number, got {str(value)[:40]!r}") from problem


def is_whole(text: str) -> bool:
    """Whether a text is a whole number that ``int`` reads: plain digits, and not thousands of them.

    Examples
    --------
    >>> is_whole("12"), is_whole("²"), is_whole("-1"), is_whole("9" * 5000)
    (True, False, False, False)
    """
    return len(text) <= _MOST_DIGITS and text.isascii() and text.isdigit()


def file_beside(path: str | Path, name: str) -> Path:
    """The file that another names, if it lies in the same folder or below it.

    Parameters
    ----------
    path : path-like
        The file that names it.
    name : str
        Relative; a slash or a backslash between folders.

    Raises
    ------
    InputError
        If it lies elsewhere, is missing, or is no plain file.
    """
    folder = Path(path).resolve().parent
    try:
        place = (folder / name.replace("\\", "/")).resolve()
        if not place.is_relative_to(folder):
            raise InputError(f"{name[:80]!r} lies outside the folder of {Path(path).name}: put it beside the file")
        if not place.is_file():
            raise InputError(f"{name[:80]!r} is not there, beside {Path(path).name}")
    except (OSError, ValueError) as problem:
        raise InputError(f"{name[:80]!r} cannot be read ({getattr(problem, 'strerror', None) or problem})") from problem
    return place


# ------------------------------------------------------------------ archives of arrays


def load_arrays(
    source: str | Path | IO[bytes], name: object = None, only: Callable[[str], bool] = lambda name: True
) -> dict[str, NDArray[Any]]:
    """The arrays of an ``.npz`` file, each judged by its header before it is unpacked.

    Parameters
    ----------
    source : path-like or open file
    name : object, optional
        For messages; the default is ``source``.
    only : callable, optional
        Which arrays to read, by their names.

    Raises
    ------
    InputError
        If it is no such file, is damaged, holds Python objects, or is larger than the limits ``unpacked`` and
        ``numbers``.
    """
    name = source if name is None else name
    try:
        with zipfile.ZipFile(source) as archive:
            members = [m for m in archive.infolist() if not m.is_dir() and only(m.filename.removesuffix(".npy"))]
            check_size("unpacked", sum(member.file_size for member in members), name)
            return {m.filename.removesuffix(".npy"): _member(archive, m, name) for m in members}
    except InputError:
        raise
    except MemoryError as problem:
        raise InputError(f"{name}: not enough memory to unpack it") from problem
    except OSError as problem:
        raise InputError(f"{name}: cannot be read ({problem.strerror or problem})") from problem
    except Exception as problem:  # zipfile, zlib, lzma and numpy raise a dozen kinds on damaged files
        raise InputError(f"{name}: not an archive of arrays (.npz), or damaged ({problem})") from problem


def read_member(archive: zipfile.ZipFile, member: str, name: object) -> bytes:
    """One member of a zip file, judged before it is unpacked.

    Raises
    ------
    InputError
        If it is larger than the limit ``unpacked``.
    KeyError
        If there is no such member.
    """
    about = archive.getinfo(member)
    check_size("unpacked", about.file_size, f"{name}, {member}")
    with archive.open(about) as file:
        return file.read(about.file_size)


def load_array(source: str | Path | IO[bytes], name: object = None) -> NDArray[Any]:
    """The array of an ``.npy`` file, judged by its header first.

    Raises
    ------
    InputError
        As `load_arrays`.
    """
    name = source if name is None else name
    if isinstance(source, (str, Path)):
        with open_quietly(source) as file:
            return load_array(file, name)
    start = source.tell()
    size = source.seek(0, os.SEEK_END) - start
    source.seek(start)
    try:
        return array_of(source, size, name)
    except InputError:
        raise
    except Exception as problem:  # numpy evaluates the header: a damaged one raises almost anything
        raise InputError(f"{name}: not an array (.npy), or damaged ({problem})") from problem


def open_quietly(path: str | Path) -> IO[bytes]:
    """Open a file for reading; what stops that is an `InputError`."""
    try:
        return Path(path).open("rb")  # the caller closes it
    except OSError as problem:
        raise InputError(f"{path}: cannot be read ({problem.strerror})") from problem


def _member(archive: zipfile.ZipFile, member: zipfile.ZipInfo, name: object) -> NDArray[Any]:
    with archive.open(member) as file:
        return array_of(file, member.file_size, f"{name}, {member.filename}")


def array_of(file: IO[bytes], size: int, where: object) -> NDArray[Any]:
    """An array out of an open ``.npy`` of ``size`` bytes: shape and type must fit that size before any is allocated.

    Raises
    ------
    InputError
        If they do not.
    """
    shape, in_columns, dtype, _ = array_header(file, size, where)
    count = math.prod(shape)
    wanted = count * dtype.itemsize
    content = file.read(wanted)
    if len(content) < wanted:
        raise InputError(f"{where}: cut short: {wanted} bytes promised, {len(content)} there")
    import numpy as np

    flat = np.frombuffer(bytearray(content), dtype=dtype, count=count)
    return flat.reshape(shape, order="F" if in_columns else "C")


def array_header(file: IO[bytes], size: int, where: object) -> tuple[tuple[int, ...], bool, np.dtype[Any], int]:
    """Shape, order (whether by columns) and type of an open ``.npy`` of ``size`` bytes, and where its numbers begin."""
    head = file.read(10)
    if len(head) < 10 or head[:6] != b"\x93NUMPY":
        raise InputError(f"{where}: not an array (.npy)")
    wide = head[6] >= 2
    rest = file.read(2) if wide else b""
    (length,) = struct.unpack("<I", head[8:10] + rest) if wide else struct.unpack("<H", head[8:10])
    if length > 10_000:
        raise InputError(f"{where}: its header is too long ({length} bytes): is it damaged?")
    shape, in_columns, dtype = _header(file.read(length).decode("latin-1"), where)
    count = math.prod(shape)
    check_size("numbers", count, where)
    begin = len(head) + len(rest) + length
    if dtype.hasobject or count * dtype.itemsize > size - begin:
        raise InputError(f"{where}: {count} elements of {dtype} promised, {size - begin} bytes there: is it cut short?")
    return shape, in_columns, dtype, begin


def _header(text: str, where: object) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    from ast import literal_eval

    import numpy as np

    try:
        facts = literal_eval(text.strip())
        shape, in_columns = tuple(facts["shape"]), bool(facts["fortran_order"])
        dtype = np.dtype(facts["descr"] if isinstance(facts["descr"], str) else [tuple(f) for f in facts["descr"]])
    except Exception as problem:  # literal_eval and dtype raise almost anything on nonsense
        raise InputError(f"{where}: the header of the array cannot be read: is it damaged?") from problem
    if not all(isinstance(n, int) and not isinstance(n, bool) and 0 <= n < 2**40 for n in shape) or len(shape) > 16:
        raise InputError(f"{where}: an array of shape {str(shape)[:60]}: is it damaged?")
    return shape, in_columns, dtype
