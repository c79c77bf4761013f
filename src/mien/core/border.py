"""The border of every reader: whatever a library raises on a damaged file becomes one line that names the file.

A reader opens with ``with reading(path, "a GLB file"):``. Inside it may rely on its library and on the shapes it
expects; an `mien.core.errors.InputError` passes as it is, anything else is put into words here. Only here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Concatenate, ParamSpec, TypeVar

from mien.core.errors import InputError, MienError

__all__ = ["guarded", "reading"]

Given = ParamSpec("Given")
Source = TypeVar("Source")
Content = TypeVar("Content")

_ADDRESS = re.compile(r"<[^<>]* at 0x[0-9a-fA-F]+>")  # what Python shows of an object without a name
_LONGEST = 160


@contextmanager
def reading(path: object, kind: str) -> Iterator[None]:
    """Turn what goes wrong inside into one line.

    Parameters
    ----------
    path : object
        The file, for the message.
    kind : str
        What is expected, with its article: ``"a GLB file"``.

    Raises
    ------
    InputError
        If anything but a `MienError` is raised inside (that one passes).

    Examples
    --------
    >>> with reading("a.json", "a face"):
    ...     {}["frames"]
    Traceback (most recent call last):
    mien.core.errors.InputError: a.json: cannot be read as a face (it lacks 'frames'): damaged, or of another kind?
    """
    try:
        yield
    except MienError:
        raise
    except OSError as problem:
        if problem.strerror is not None:
            raise InputError(f"{path}: cannot be read ({problem.strerror})") from problem
        raise InputError(_sentence(path, kind, problem)) from problem
    except Exception as problem:
        raise InputError(_sentence(path, kind, problem)) from problem


Reader = Callable[Concatenate[Source, Given], Content]


def guarded(kind: str) -> Callable[[Reader[Source, Given, Content]], Reader[Source, Given, Content]]:
    """Have a reader, whose first argument is its file, run inside `reading`.

    Examples
    --------
    >>> @guarded("a number")
    ... def read(path): return float(path)
    >>> read("7")
    7.0
    """

    def around(read: Reader[Source, Given, Content]) -> Reader[Source, Given, Content]:
        @wraps(read)
        def guarded_read(path: Source, /, *given: Given.args, **named: Given.kwargs) -> Content:
            with reading(path, kind):
                return read(path, *given, **named)

        return guarded_read

    return around


def _sentence(path: object, kind: str, problem: Exception) -> str:
    return f"{path}: cannot be read as {kind} ({_reason(problem)}): damaged, or of another kind?"


def _reason(problem: Exception) -> str:
    """What an exception means, in a few words."""
    match problem:
        case MemoryError():
            return "not enough memory"
        case RecursionError():
            return "nested too deeply"
        case UnicodeDecodeError():
            return f"no text in {problem.encoding} at byte {problem.start}"
        case KeyError():
            return f"it lacks {str(problem)[:60]}"
        case IndexError():
            return "it refers to something that is not there"
    words = " ".join(_ADDRESS.sub("", str(problem)).split())
    return words[:_LONGEST] if words else type(problem).__name__
