"""Whatever a library raises becomes one line that names the file."""

from __future__ import annotations

import errno
import json
import struct

import pytest

from mien.core.border import reading
from mien.core.errors import InputError, OutputError


@pytest.mark.parametrize(
    ("problem", "words"),
    [
        (KeyError("frames"), "it lacks 'frames'"),
        (IndexError("list index out of range"), "refers to something that is not there"),
        (RecursionError(), "nested too deeply"),
        (MemoryError(), "not enough memory"),
        (struct.error("unpack requires 4 bytes"), "unpack requires 4 bytes"),
        (json.JSONDecodeError("bad", "x", 0), "bad"),
        (UnicodeDecodeError("utf-8", b"\xff", 0, 1, "x"), "no text in utf-8 at byte 0"),
        (ZeroDivisionError(), "ZeroDivisionError"),
        (OSError(errno.EACCES, "Permission denied"), r"cannot be read \(Permission denied\)"),
        (OSError("odd"), "odd"),
        (ValueError("two\nlines " + "x" * 1000), "two lines xxx"),
    ],
)
def test_one_line(problem: Exception, words: str) -> None:
    with pytest.raises(InputError, match=words) as found, reading("a.glb", "a GLB file"):
        raise problem
    assert str(found.value).startswith("a.glb: ")
    assert "\n" not in str(found.value)
    assert len(str(found.value)) < 300


def test_our_own_errors_and_requests_to_end_pass() -> None:
    with pytest.raises(OutputError, match=r"^disk$"), reading("a", "a file"):
        raise OutputError("disk")
    with pytest.raises(KeyboardInterrupt), reading("a", "a file"):
        raise KeyboardInterrupt


def test_no_address_in_memory_is_shown() -> None:
    with pytest.raises(InputError) as problem, reading("a.png", "a picture"):
        raise ValueError("cannot identify image file <_io.BytesIO object at 0x7faa12>")
    assert "0x" not in str(problem.value)
    assert "cannot identify image file" in str(problem.value)
