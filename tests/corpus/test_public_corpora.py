"""Recipes for public corpora, on made copies of how their files lie: names, speakers, emotions, texts and sounds."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import soundfile

from mien.core.errors import InputError
from mien.corpus.file_layout import located
from mien.corpus.import_plan import facts_of, named
from mien.corpus.readers import reader_named
from mien.corpus.recipes import load_recipe

CASES = {
    "ravdess": (
        ("Actor_01/01-01-05-02-01-02-01.mp4", "Actor_12/01-01-01-01-02-01-12.mp4", "Actor_01/02-01-05-02-01-02-01.mp4"),
        {
            "01-01-05-02-01-02-01": ("angry", "01", "Kids are talking by the door."),
            "01-01-01-01-02-01-12": ("neutral", "12", "Dogs are sitting by the door."),
        },
    ),
    "cremad": (
        ("VideoFlash/1001_DFA_ANG_XX.flv", "VideoFlash/1002_IEO_HAP_HI.flv"),
        {
            "1001_DFA_ANG_XX": ("angry", "1001", "Don't forget a jacket."),
            "1002_IEO_HAP_HI": ("happy", "1002", "It's eleven o'clock."),
        },
    ),
    "savee": (
        ("AudioVisualClip/DC/a01.avi", "AudioVisualClip/KL/su12.avi"),
        {"DC-a-01": ("angry", "DC", ""), "KL-su-12": ("surprised", "KL", "")},
    ),
    "mead": (
        (
            "M003/video/front/angry/level_1/001.mp4",
            "M003/video/left_30/angry/level_1/001.mp4",
            "M003/video/front/fear/level_3/001.mp4",
            "M003/audio/angry/level_1/001.m4a",
            "M003/audio/fear/level_3/001.m4a",
        ),
        {
            "M003-angry-level_1-001": ("angry", "M003", ""),
            "M003-fear-level_3-001": ("afraid", "M003", ""),
        },
    ),
    "tcd-timit": (
        (
            "volunteers/01M/Clips/straightcam/sa1.mp4",
            "volunteers/01M/Clips/straightcam/sa1.txt",
            "volunteers/02F/Clips/straightcam/sa1.mp4",
            "volunteers/02F/Clips/straightcam/sa1.txt",
            "volunteers/01M/Clips/30degcam/sa1.mp4",
        ),
        {"01M-sa1": ("neutral", "01M", ""), "02F-sa1": ("neutral", "02F", "")},
    ),
    "grid-speakers": (
        ("s1/bbaf2n.mpg", "s2/video/mpg_6000/bbaf2n.mpg", "s1/lwizza.mpg"),
        {
            "s1-bbaf2n": ("neutral", "s1", "bin blue at f two now"),
            "s2-bbaf2n": ("neutral", "s2", "bin blue at f two now"),
            "s1-lwizza": ("neutral", "s1", "lay white in z zero again"),
        },
    ),
    "lombard-grid": (
        ("front/s2_l_bbim3a.mov", "front/s2_p_bbim3a.mov", "audio/s2_l_bbim3a.wav", "audio/s2_p_bbim3a.wav"),
        {
            "s2-l-bbim3a": ("neutral", "s2", "bin blue in m three again"),
            "s2-p-bbim3a": ("neutral", "s2", "bin blue in m three again"),
        },
    ),
}


def plan(name: str, folder: Path):
    recipe = load_recipe(name)
    found, notes = located(reader_named(recipe.reader).find(folder), folder, recipe)
    takes, _, failed = named(found, folder)
    facts, strangers = facts_of(takes, recipe, {})
    assert failed == []
    assert strangers == []
    return takes, facts, notes


@pytest.mark.parametrize("name", CASES)
def test_files_as_they_are_unpacked_are_understood(name: str, tmp_path: Path) -> None:
    files, expected = CASES[name]
    for file in files:
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).write_bytes(b"")
    takes, facts, notes = plan(name, tmp_path)
    assert {key: (f["emotion"], f["speaker"], f["text"]) for key, f in facts.items()} == expected
    assert bool(notes) == (len([f for f in files if f.endswith((".mp4", ".mov", ".avi", ".flv", ".mpg"))]) > len(takes))
    recipe = load_recipe(name)
    assert recipe.licence
    assert recipe.citation


def test_sound_and_text_are_those_of_the_take(tmp_path: Path) -> None:
    test_files_as_they_are_unpacked_are_understood("mead", tmp_path)
    takes, _, _ = plan("mead", tmp_path)
    for name, level in (("M003-angry-level_1-001", "angry/level_1"), ("M003-fear-level_3-001", "fear/level_3")):
        assert takes[name].sound == tmp_path / f"M003/audio/{level}/001.m4a"
    other = tmp_path / "other"
    test_files_as_they_are_unpacked_are_understood("tcd-timit", other)
    takes, _, _ = plan("tcd-timit", other)
    assert takes["02F-sa1"].transcript == other / "volunteers/02F/Clips/straightcam/sa1.txt"


def test_a_folder_of_something_else_says_what_was_expected(tmp_path: Path) -> None:
    (tmp_path / "holiday.mp4").write_bytes(b"")
    with pytest.raises(InputError, match="expected paths such as 'M003/video/front/angry/level_1/001'"):
        plan("mead", tmp_path)


def beat(folder: Path, frames: int = 30, names: tuple[str, ...] = ("browDownLeft", "jawOpen", "tongueOut")) -> Path:
    weights = np.linspace(0, 1, frames)[:, None] * np.array([0.5, 1.0, 0.0])
    content = {
        "names": list(names),
        "frames": [{"weights": row.tolist(), "time": k / 60, "rotation": []} for k, row in enumerate(weights)],
    }
    path = folder / "2_scott_0_1_1.json"
    path.write_text(json.dumps(content))
    soundfile.write(folder / "2_scott_0_1_1.wav", np.zeros(16000 * frames // 60), 16000)
    (folder / "2_scott_0_1_1.txt").write_text("Hello there.")
    return path


def test_beat_is_read_as_channels(tmp_path: Path) -> None:
    beat(tmp_path)
    takes, facts, _ = plan("beat", tmp_path)
    assert facts["2_scott_0_1_1"]["speaker"] == "2_scott"
    raw = reader_named("beat").read(takes["2_scott_0_1_1"], load_recipe("beat"))
    assert raw.channels is not None
    assert raw.channels.rate.fps == 60
    np.testing.assert_allclose(raw.channels.channel("jawOpen"), np.linspace(0, 1, 30), atol=1e-9)
    assert raw.markers.positions.shape[0] == 30


@pytest.mark.parametrize(
    "text", ['{"names": ["browDownLeft"], "frames": []}', '{"names": ["browDownLeft"], "frames": [{}, {}]}']
)
def test_damaged_beat_files_are_one_line(text: str, tmp_path: Path) -> None:
    path = beat(tmp_path)
    path.write_text(text)
    takes, _, _ = plan("beat", tmp_path)
    with pytest.raises(InputError, match="2_scott"):
        reader_named("beat").read(takes["2_scott_0_1_1"], load_recipe("beat"))
