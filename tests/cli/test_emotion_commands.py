from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import mien
from mien.cli import main
from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.emotion.emotion_over_time import emotion_spans


@pytest.fixture(scope="module")
def angry(shared_data: Path) -> Path:
    return shared_data / "emodb" / "audio" / "08a01Wa.flac"


@pytest.mark.data
def test_a_reading_as_json(angry: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["emotion", "--json", str(angry), str(angry)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2
    told = json.loads(lines[0])
    assert told["emotion"] == "angry"
    assert sum(told["probabilities"].values()) == pytest.approx(1, abs=1e-3)


@pytest.mark.data
def test_a_table_stretches_and_together(angry: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["emotion", str(angry)]) == 0
    assert main(["emotion", "--over-time", str(angry)]) == 0
    assert main(["emotion", "--together", str(angry), str(angry.with_name("03a01Nc.flac"))]) == 0
    assert capsys.readouterr().out.count("angry") >= 3


@pytest.mark.data
def test_files_of_one_speaker_are_judged_beside_one_another(angry: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = ("03a01Wa", "03a01Nc", "03a02Ta", "08a01Na", "08a01Wa")
    files = [str(angry.with_name(f"{name}.flac")) for name in names]

    def told(*options: str) -> dict[str, dict[str, float]]:
        assert main(["emotion", "--json", *options, *files]) == 0
        lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
        assert [line["file"] for line in lines] == files
        return {line["file"]: line["probabilities"] for line in lines}

    usual, apart, together = told(), told("--apart"), told("--together")
    assert usual != apart
    assert usual != together  # two speakers, as their names tell
    assert main(["emotion", "--json", *files[:3]]) == 0
    alone = [json.loads(line)["probabilities"] for line in capsys.readouterr().out.splitlines()]
    assert alone == [usual[file] for file in files[:3]]


@pytest.mark.data
def test_a_neutral_baseline(angry: Path, capsys: pytest.CaptureFixture[str]) -> None:
    neutral = str(angry.with_name("08a01Na.flac"))
    assert main(["emotion", "--json", str(angry), "--baseline", neutral]) == 0
    told = capsys.readouterr()
    assert json.loads(told.out)["emotion"] == "angry"
    assert main(["emotion", "--json", str(angry)]) == 0
    assert json.loads(capsys.readouterr().out)["probabilities"] != json.loads(told.out)["probabilities"]


def test_whose_files_they_are_is_said_where_names_do_not_tell(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("a", "b"):
        Audio.silence(0.5, 16_000).write(tmp_path / f"{name}.wav")
    assert main(["emotion", str(tmp_path / "a.wav"), str(tmp_path / "b.wav")]) == 0
    assert "taken for one speaker's" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments",
    [
        ["emotion", "no-such-file.wav"],
        ["emotion", "x.wav", "--over-time", "--together"],
        ["emotion", "x.wav", "--apart", "--together"],
        ["emotion", "x.wav", "--together", "--baseline", "y.wav"],
        ["emotion", "x.wav", "--baseline", "no-such-file.wav"],
        ["emotion", "x.wav", "--classifier", "none.npz"],
        ["emotion-train", "nowhere", "-o", "x.npz"],
        ["emotion-train", "nowhere", "-o", "x.pkl"],
        ["emotion-table", "nowhere"],
    ],
)
def test_slips_are_told_in_one_line(
    arguments: list[str], capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    told = capsys.readouterr().err
    assert told.startswith("mien: error: ")
    assert told.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.data
def test_train_and_table_on_a_small_corpus(
    shared_data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "small"
    folder.mkdir()
    for path in sorted((shared_data / "emodb" / "audio").glob("0[389]*[WNT]?.flac"))[::4]:
        (folder / path.name).symlink_to(path)
    classifier = tmp_path / "own.npz"
    assert main(["emotion-train", str(folder), "-o", str(classifier), "--variations", "0", "--workers", "0"]) == 0
    assert main(["emotion", "--classifier", str(classifier), str(next(folder.iterdir()))]) == 0
    assert main(["emotion-table", str(folder), "--report", str(tmp_path / "t.md"), "--workers", "2"]) == 0
    text = (tmp_path / "t.md").read_text()
    assert "Table I" in text
    assert "speakers held out" in text
    assert "nan" not in text


@pytest.mark.data
def test_auto_puts_what_is_read_into_the_score(angry: Path) -> None:
    made = mien.animate(angry, emotion=["auto", "sad:0.2"])
    assert [span.name for span in made.score.emotions] == ["sad", "angry"]
    assert any("read from the voice: angry" in note.message for note in made.notes)
    assert np.allclose(
        made.score.emotions[1].intensity_at(np.array([1.0])),
        emotion_spans(mien.animate(angry).utterance.audio)[0].intensity_at(np.array([1.0])),
    )


def test_auto_on_a_sound_without_speech_is_neutral() -> None:
    made = mien.animate(Audio.silence(1.0, 16_000), emotion="auto")
    assert made.score.emotions == ()


def test_a_synthetic_voice_has_nothing_to_read() -> None:
    with pytest.raises(InputError, match="a synthetic one has what it is given"):
        mien.say("Hello.", emotion="auto")
