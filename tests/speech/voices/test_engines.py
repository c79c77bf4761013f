"""What goes wrong with engines is one line that tells what to do."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from mien.core.errors import MissingPartError
from mien.core.external_program import run_program
from mien.speech.voices import catalogue
from mien.speech.voices.onnx_voice import open_network, open_parts, read_model
from mien.text.normalisation import spoken_words


@pytest.mark.parametrize("model", [b"", b"junk", b":\x06b\x04\n\x02/a"])
def test_a_damaged_network(model: bytes) -> None:
    with pytest.raises(MissingPartError, match=r"the network of the voice test does not open.*reinstall"):
        open_network(model, "test")


def test_a_missing_part(tmp_path: Path) -> None:
    (tmp_path / "1").write_bytes(b"one")
    assert read_model([tmp_path / "1", tmp_path / "1"], "test") == b"oneone"
    with pytest.raises(MissingPartError, match="the network of the voice test is not there"):
        read_model([tmp_path / "1", tmp_path / "2"], "test")


@pytest.mark.parametrize("content", [b"", b"junk", b":\x06b\x04\n\x02/a"])
def test_parts_that_are_missing_or_damaged(tmp_path: Path, content: bytes) -> None:
    with pytest.raises(MissingPartError, match=r"the network of the voice test is not there.*reinstall"):
        open_parts([tmp_path / "1"], "test", "/a")
    (tmp_path / "1").write_bytes(content)
    with pytest.raises(MissingPartError, match=r"the network of the voice test does not open.*reinstall"):
        open_parts([tmp_path / "1"], "test", "/a")


def test_what_a_program_prints_comes_back() -> None:
    echo = "import sys; sys.stdout.write(sys.stdin.read()[::-1])"
    assert run_program([sys.executable, "-c", echo], "test", b"abc") == b"cba"


@pytest.mark.parametrize(
    ("code", "reason"),
    [
        ("import sys; sys.exit('no such voice')", "failed with code 1 .no such voice."),
        ("import os; os.abort()", "failed with code -6"),
        ("import time; time.sleep(60)", "did not answer in 0.5 s"),
    ],
)
def test_a_program_that_fails(code: str, reason: str) -> None:
    with pytest.raises(MissingPartError, match=reason):
        run_program([sys.executable, "-c", code], "test", seconds=0.5 if "sleep" in code else 60)


def test_a_program_that_is_not_there() -> None:
    with pytest.raises(MissingPartError, match="cannot start no-such-program"):
        run_program(["no-such-program"], "test")


def test_espeak_s_library_stays_out_of_this_process() -> None:
    espeak = next(voice for voice in catalogue() if voice.name == "espeak")
    if not espeak.availability().installed:
        pytest.skip(f"eSpeak NG is not installed; {espeak.availability().hint}")
    espeak.speak(spoken_words("hello"))
    maps = Path("/proc/self/maps")
    if not maps.exists():
        pytest.skip("this system does not list loaded libraries in /proc")
    assert "libespeak" not in maps.read_text(encoding="utf-8")


def test_espeak_phones_that_the_table_lacks_leave_the_times_to_alignment(monkeypatch: pytest.MonkeyPatch) -> None:
    espeak = next(voice for voice in catalogue() if voice.name == "espeak")
    if not espeak.availability().installed:
        pytest.skip(f"eSpeak NG is not installed; {espeak.availability().hint}")
    from mien.speech.voices.espeak import _settings

    known = dict(_settings()["phones"])
    del known["h"]
    monkeypatch.setitem(_settings(), "phones", known)
    speech = espeak.speak(spoken_words("hello. no."))
    assert speech.phones is None
    assert speech.words is None
    assert len(speech.breaks) == 1
