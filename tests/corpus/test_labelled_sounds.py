from __future__ import annotations

from pathlib import Path

import pytest

from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.corpus.labelled_sounds import read_labelled_sounds


def make(folder: Path, *names: str) -> Path:
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        Audio([0.1, -0.1] * 400, 8000).write(folder / name)
    return folder


@pytest.mark.parametrize(
    ("name", "emotion", "speaker"),
    [
        ("03a01Wb.wav", "angry", "03"),
        ("03a01L.wav", "neutral", "03"),
        ("Actor_12/03-01-06-02-01-01-12.wav", "afraid", "12"),
        ("1001_DFA_ANG_XX.wav", "angry", "1001"),
        ("DC_sa01.wav", "sad", "DC"),
        ("OAF_back_ps.wav", "surprised", "OAF"),
        ("gio-f2-l3.wav", "happy", "f2"),
        ("happy/x.wav", "happy", ""),
        ("anna/Fearful/take 1.wav", "afraid", "anna"),
    ],
)
def test_names_tell_emotion_and_speaker(tmp_path: Path, name: str, emotion: str, speaker: str) -> None:
    (sound,) = read_labelled_sounds(make(tmp_path, name)).sounds
    assert (sound.emotion, sound.speaker) == (emotion, speaker)


def test_a_table_tells_them_too(tmp_path: Path) -> None:
    make(tmp_path, "a.wav", "b.wav")
    table = tmp_path / "list.csv"
    table.write_text("file,emotion,speaker\na.wav,Joy,eva\nb.wav,sad,tom\n")
    corpus = read_labelled_sounds(table)
    assert [(s.path.name, s.emotion, s.speaker) for s in corpus.sounds] == [
        ("a.wav", "happy", "eva"),
        ("b.wav", "sad", "tom"),
    ]
    assert corpus.speakers == ("eva", "tom")


def test_an_unknown_label_is_named_with_its_line(tmp_path: Path) -> None:
    make(tmp_path, "a.wav")
    table = tmp_path / "list.csv"
    table.write_text("file,emotion\na.wav,angri\n")
    with pytest.raises(InputError, match=r"list\.csv, line 2: unknown emotion 'angri': did you mean 'angr"):
        read_labelled_sounds(table)


@pytest.mark.parametrize("content", ["name,mood\na.wav,sad\n", "file,emotion\nnone.wav,sad\n", "file,emotion\n"])
def test_a_table_that_does_not_fit_is_refused(tmp_path: Path, content: str) -> None:
    table = tmp_path / "list.csv"
    table.write_text(content)
    with pytest.raises(InputError, match=r"list\.csv"):
        read_labelled_sounds(table)


def test_links_are_followed_and_a_circle_ends(tmp_path: Path) -> None:
    elsewhere = make(tmp_path / "elsewhere", "x.wav", "y.wav")
    folder = make(tmp_path / "corpus", "sad/z.wav")
    (folder / "happy").symlink_to(elsewhere)
    (folder / "sad" / "up").symlink_to(folder)
    found = read_labelled_sounds(folder)
    assert [(sound.path.name, sound.emotion) for sound in found.sounds] == [
        ("x.wav", "happy"),
        ("y.wav", "happy"),
        ("z.wav", "sad"),
    ]
    (tmp_path / "link").symlink_to(folder)
    assert len(read_labelled_sounds(tmp_path / "link").sounds) == 3


def test_what_is_left_out_is_said(tmp_path: Path) -> None:
    corpus = read_labelled_sounds(make(tmp_path, "sad/a.wav", "angry/b.wav", "notes.wav"))
    assert len(corpus.sounds) == 2
    assert "1 recordings are left out" in corpus.notes[0].message


@pytest.mark.parametrize("names", [(), ("one.wav", "two.wav")])
def test_a_folder_without_emotions_is_refused(tmp_path: Path, names: tuple[str, ...]) -> None:
    with pytest.raises(InputError):
        read_labelled_sounds(make(tmp_path, *names))
