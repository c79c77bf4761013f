from __future__ import annotations

import shutil
import subprocess

import pytest

from mien.cli import main


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_commands_and_options_are_in_it(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    written = capsys.readouterr().out
    assert "animate" in written
    assert "--emotion" in written or "emotion" in written


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash here")
def test_bash_takes_it(capsys: pytest.CaptureFixture[str]) -> None:
    main(["completion", "bash"])
    script = capsys.readouterr().out + '\nCOMP_WORDS=(mien sa); COMP_CWORD=1; _shtab_mien; echo "${COMPREPLY[@]}"\n'
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["say"]
