"""Words in time as other tools keep them."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest

from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.core.timeline import Interval, Tier
from mien.core.utterance import PAUSE, Utterance
from mien.formats.spoken_times import CUE_LETTERS, TIME_FORMATS, write_times
from mien.formats.textgrid import read_textgrid


@pytest.fixture
def utterance() -> Utterance:
    said = ["it", "costs", "five", "dollars", "a", "and", "b"]
    starts = [0.1, 0.3, 0.6, 0.9, 2.0, 2.2, 2.4]
    words = Tier("words", tuple(Interval(s, round(s + 0.2, 3), w) for s, w in zip(starts, said, strict=True)))
    phones = Tier("phones", (Interval(0.0, 0.1, PAUSE), Interval(0.1, 0.3, "IH"), Interval(0.3, 3.0, PAUSE)))
    return Utterance("It costs $5. A & b", Audio(np.zeros(48_000), 16_000), words, phones, "en", "aligned")


@pytest.mark.parametrize("suffix", TIME_FORMATS)
def test_every_format_is_written_alike_twice(utterance: Utterance, tmp_path: Path, suffix: str) -> None:
    for name in ("a", "b"):
        assert write_times(utterance, tmp_path / f"{name}{suffix}") == ()
    first, second = (tmp_path / f"{name}{suffix}" for name in ("a", "b"))
    assert first.read_text().replace("a 1", "b 1") == second.read_text()


def test_times_come_back(utterance: Utterance, tmp_path: Path) -> None:
    for suffix in TIME_FORMATS:
        write_times(utterance, tmp_path / f"x{suffix}")
    assert read_textgrid(tmp_path / "x.TextGrid")[0] == utterance.words
    stored = json.loads((tmp_path / "x.json").read_text())
    assert [word["label"] for word in stored["words"]] == [word.label for word in utterance.words]
    rows = list(csv.DictReader((tmp_path / "x.csv").open()))
    assert [row["label"] for row in rows if row["tier"] == "phones"] == [PAUSE, "IH", PAUSE]
    assert (tmp_path / "x.lab").read_text().splitlines()[1] == "1000000 3000000 IH"
    assert (tmp_path / "x.ctm").read_text().splitlines()[0] == "x 1 0.100 0.200 it"


def test_subtitles_show_the_text_as_written_and_break_at_pauses(utterance: Utterance, tmp_path: Path) -> None:
    write_times(utterance, tmp_path / "x.srt")
    assert (tmp_path / "x.srt").read_text() == (
        "1\n00:00:00,100 --> 00:00:01,100\nIt costs $5.\n\n2\n00:00:02,000 --> 00:00:02,600\nA & b\n"
    )
    write_times(utterance, tmp_path / "x.vtt")
    assert "A &amp; b" in (tmp_path / "x.vtt").read_text()


def test_long_speech_is_cut_into_short_cues(tmp_path: Path) -> None:
    words = Tier("words", tuple(Interval(i * 0.3, i * 0.3 + 0.3, "word") for i in range(60)))
    sound, none = Audio(np.zeros(16_000 * 20), 16_000), Tier("phones", (Interval(0.0, 20.0, PAUSE),))
    write_times(Utterance(" ".join(["word"] * 60), sound, words, none, "en", "given"), tmp_path / "x.srt")
    cues = re.findall(r"\n((?:word ?)+)\n", (tmp_path / "x.srt").read_text())
    assert sum(len(cue.split()) for cue in cues) == 60
    assert max(map(len, cues)) <= CUE_LETTERS + len(" word")


def test_other_suffixes_are_refused(utterance: Utterance, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"did you mean '\.srt'"):
        write_times(utterance, tmp_path / "x.str")
