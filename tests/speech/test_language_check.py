from __future__ import annotations

from pathlib import Path

import pytest

from mien.cli import main
from mien.core.errors import InputError
from mien.speech.language_check import check_language


def test_a_language_is_spoken_aligned_and_measured() -> None:
    done = check_language("it", ["La pizza è nella scatola blu."])
    assert done.sentences == 1
    assert dict(done.phones)["ʎ" if "ʎ" in dict(done.phones) else "p"]
    assert len(done.errors) > 0.6 * done.boundaries
    assert sorted(done.errors)[len(done.errors) // 2] < 0.035
    assert "within 20 ms" in str(done)


def test_a_phone_in_no_table_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = tmp_path / "xx.toml"
    table.write_text('tag = "xx"\nname = "Kana"\nreader = "espeak"\nespeak = "ja"\nsample = ["みずを"]\n')
    assert main(["language", "check", str(table)]) == 2
    assert "in none of its tables: add it to [phones]" in capsys.readouterr().err


@pytest.mark.parametrize(("asked", "said"), [("en", "has no table"), ("qq", "unknown language")])
def test_what_cannot_be_checked_is_said(asked: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        check_language(asked)
