from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from mien.core.errors import OutputError
from mien.core.files import check_writable, replace_when_complete


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "line.csv"
    path.write_text("old")

    def fail() -> None:
        with replace_when_complete(path) as unfinished:
            unfinished.write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_success_replaces_and_keeps_the_usual_permissions(tmp_path: Path) -> None:
    path = tmp_path / "line.csv"
    with replace_when_complete(path) as unfinished:
        assert unfinished.suffix == ".csv"
        unfinished.write_text("new")
    plain = tmp_path / "plain"
    plain.write_text("")
    assert path.read_text() == "new"
    assert path.stat().st_mode == plain.stat().st_mode


def test_a_full_disk_is_said_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="the disk is full"), replace_when_complete(tmp_path / "a.csv"):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert list(tmp_path.iterdir()) == []


def test_folders_that_are_missing_are_made_and_go_again_if_it_fails(tmp_path: Path) -> None:
    with replace_when_complete(tmp_path / "new" / "er" / "a.csv") as unfinished:
        unfinished.write_text("done")
    assert (tmp_path / "new" / "er" / "a.csv").read_text() == "done"
    with pytest.raises(OutputError, match="disk is full"), replace_when_complete(tmp_path / "other" / "deep" / "a.csv"):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert [entry.name for entry in tmp_path.iterdir()] == ["new"]


def test_impossible_places_are_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="is a folder"):
        check_writable(tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="is not a folder"):
        check_writable(tmp_path / "file" / "a.csv")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_without_permission_is_refused(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(OutputError, match="permission denied"):
        check_writable(tmp_path / "a.csv")


def test_a_link_stays_and_what_it_points_to_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "real.csv").write_text("old")
    (tmp_path / "link.csv").symlink_to(tmp_path / "real.csv")
    with replace_when_complete(tmp_path / "link.csv") as unfinished:
        unfinished.write_text("new")
    assert (tmp_path / "link.csv").is_symlink()
    assert (tmp_path / "real.csv").read_text() == "new"


def test_names_as_long_as_the_file_system_takes(tmp_path: Path) -> None:
    for name in ("a" * 251 + ".csv", "é" * 125 + ".csv", "x" * 255, "." + "b" * 254, "👄" * 60 + " 'quoted\" .json"):
        with replace_when_complete(tmp_path / name) as unfinished:
            unfinished.write_text("done")
        assert (tmp_path / name).read_text() == "done"


def test_what_a_killed_program_left_is_taken_over(tmp_path: Path) -> None:
    path = tmp_path / "line.csv"
    script = "import os, sys; from mien.core.files import replace_when_complete\n"
    script += "with replace_when_complete(sys.argv[1]) as unfinished:\n"
    script += "    unfinished.write_text('half'); os.kill(os.getpid(), 9)"
    subprocess.run([sys.executable, "-c", script, str(path)], check=False)
    assert len(list(tmp_path.iterdir())) == 1
    with replace_when_complete(path) as unfinished:
        assert unfinished.read_text() == ""
        unfinished.write_text("whole")
    assert [(left, left.read_text()) for left in tmp_path.iterdir()] == [(path, "whole")]


def test_two_writers_of_one_file_do_not_meet(tmp_path: Path) -> None:
    path = tmp_path / "line.csv"
    with replace_when_complete(path) as one, replace_when_complete(path) as two:
        assert one != two
        one.write_text("one")
        two.write_text("two")
    assert path.read_text() == "one"  # the last to be complete
    assert list(tmp_path.iterdir()) == [path]


def test_of_two_commands_that_write_one_file_the_second_is_told(tmp_path: Path) -> None:
    path = tmp_path / "line.csv"
    script = "import sys; from mien.core import files\nheld = files.claimed_outputs()\nheld.__enter__()\n"
    script += "files.check_writable(sys.argv[1])\n"
    first = [sys.executable, "-c", script + "print('claimed', flush=True); input()", str(path)]
    second = [sys.executable, "-c", script + "print('free')", str(path)]
    with subprocess.Popen(first, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as running:
        assert running.stdout is not None
        running.stdout.readline()
        told = subprocess.run(second, capture_output=True, text=True, check=False)
        assert "another mien command is at work on it" in told.stderr
        running.kill()
    assert subprocess.run(second, capture_output=True, text=True, check=False).stdout == "free\n"
    assert list(tmp_path.iterdir()) == []


def test_a_link_in_the_place_of_a_temporary_is_not_followed(tmp_path: Path) -> None:
    precious = tmp_path / "precious"
    precious.write_text("mine")
    with replace_when_complete(tmp_path / "a.csv") as unfinished:
        name = unfinished
    name.symlink_to(precious)
    with replace_when_complete(tmp_path / "a.csv") as unfinished:
        unfinished.write_text("new")
    assert precious.read_text() == "mine"
    name.unlink()
    os.link(precious, name)
    with replace_when_complete(tmp_path / "a.csv") as unfinished:
        unfinished.write_text("newer")
    assert precious.read_text() == "mine"
