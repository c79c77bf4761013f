"""Where compiled kernels are kept, wherever mien is installed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from mien.core.compiled import cache_folder, njit, when_compiling


def test_beside_the_source_if_that_can_be_written(tmp_path: Path) -> None:
    assert cache_folder({"HOME": str(tmp_path / "home")}, tmp_path, tmp_path) == tmp_path / "__pycache__"


def blocked(folder: Path) -> Path:
    """A folder in which nothing can be made, not even by root: a file stands where it should be."""
    folder.mkdir()
    (folder / "__pycache__").write_text("")
    return folder


def test_else_under_home_else_in_the_temporary_folder_else_nowhere(tmp_path: Path) -> None:
    source = blocked(tmp_path / "source")
    home, temporary, file = tmp_path / "home", tmp_path / "tmp", tmp_path / "file"
    home.mkdir()
    temporary.mkdir()
    file.write_text("")
    own = temporary / f"mien-{os.getuid()}"
    assert cache_folder({"HOME": str(home)}, source, temporary) == home / ".cache" / "mien"
    assert cache_folder({"HOME": str(file)}, source, temporary) == own
    assert cache_folder({}, source, temporary) == own
    assert cache_folder({}, source, file) is None
    given = {"NUMBA_CACHE_DIR": str(tmp_path / "given"), "HOME": str(home)}
    assert cache_folder(given, source, temporary) == tmp_path / "given"
    assert cache_folder({**given, "NUMBA_CACHE_DIR": str(file / "x")}, source, temporary) == home / ".cache" / "mien"


def test_code_is_not_taken_from_a_folder_that_others_can_write(tmp_path: Path) -> None:
    source, temporary = blocked(tmp_path / "source"), tmp_path / "tmp"
    own = temporary / f"mien-{os.getuid()}"
    own.mkdir(parents=True)
    own.chmod(0o777)
    assert cache_folder({}, source, temporary) is None
    own.rmdir()
    (temporary / "other").mkdir()
    own.symlink_to(temporary / "other")
    assert cache_folder({}, source, temporary) is None


def test_who_can_write_nowhere_compiles_all_the_same() -> None:
    code = (
        "import tempfile\n"
        "def refuse(*_, **__): raise PermissionError(13, 'Permission denied')\n"
        "tempfile.TemporaryFile = refuse\n"
        "import mien.core.compiled as c\n"
        "assert not c.kept() and 'nowhere' in c.cache_note()\n"
        "import numba.core.caching as n\n"
        "def no_place(*_): raise RuntimeError('no locator available')\n"
        "n.FunctionCache.__init__ = no_place\n"
        "@c.njit(cache=True)\n"
        "def double(x):\n    return 2 * x\n"
        "print(double(21))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "42", done.stderr


def test_numba_is_loaded_by_the_first_call_and_kernels_find_each_other() -> None:
    code = (
        "import sys\n"
        "from mien.core.compiled import njit\n"
        "@njit()\n"
        "def square(x):\n    return x * x\n"
        "@njit()\n"
        "def squares(n):\n"
        "    total = 0\n"
        "    for i in range(n):\n        total += square(i)\n"
        "    return total\n"
        "assert 'numba' not in sys.modules\n"
        "assert squares.py_func(5) == squares(5) == 30\n"
        "assert 'numba' in sys.modules\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_who_waits_for_a_compilation_is_told_once() -> None:
    told: list[str] = []
    when_compiling(lambda: told.append("compiling"))
    one, other = njit()(lambda: 1), njit()(lambda: 2)
    assert (one(), other(), one()) == (1, 2, 1)
    assert told == ["compiling"]


def test_a_second_thread_waits_until_all_that_a_kernel_calls_is_ready() -> None:
    code = (
        "import threading, mien.core.compiled as c\n"
        "@c.njit()\n"
        "def square(x):\n    return x * x\n"
        "@c.njit()\n"
        "def squares(n):\n    return square(n) + 1\n"
        "inner, reached, go = square, threading.Event(), threading.Event()\n"
        "whole = inner.compiled\n"
        "def slowly():\n"
        "    reached.set()\n    go.wait(10)\n    return whole()\n"
        "inner.compiled = slowly\n"
        "got = []\n"
        "first = threading.Thread(target=lambda: got.append(squares(3)))\n"
        "outer = squares\n"
        "first.start()\n"
        "assert reached.wait(60)\n"
        "second = threading.Thread(target=lambda: got.append(outer(4)))\n"
        "second.start()\n"
        "second.join(0.5)\n"
        "assert second.is_alive(), got\n"
        "go.set()\n"
        "first.join()\nsecond.join()\n"
        "print(sorted(got))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "[10, 17]", done.stderr


def test_a_module_shows_its_compiled_kernels_all_at_once() -> None:
    """Who takes one of them from the module, and so does not wait, must not meet it before what it calls."""
    code = (
        "import mien.core.compiled as c\n"
        "@c.njit()\n"
        "def outer(x):\n    return middle(x) + 1\n"
        "@c.njit()\n"
        "def middle(x):\n    return inner(x) + 1\n"
        "@c.njit()\n"
        "def inner(x):\n    return x * x\n"
        "names, seen = ('outer', 'middle', 'inner'), set()\n"
        "def look(compiled):\n"
        "    seen.add(sum(isinstance(globals()[name], c.Kernel) for name in names))\n"
        "c._tell_if_new = look\n"
        "print(outer(3), sorted(seen), [isinstance(globals()[name], c.Kernel) for name in names])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "11 [3] [False, False, False]", done.stderr
