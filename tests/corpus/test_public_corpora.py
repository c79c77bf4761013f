"""Recipes for public corpora, on made copies of how their files lie: names, speakers, emotions, texts and sounds."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import soundfile

from mien.capture.layouts import load_layout
from mien.core.errors import InputError
from mien.corpus.file_layout import located
from mien.corpus.import_plan import facts_of, named
from mien.corpus.readers import detect, reader_named
from mien.corpus.readers.mesh_recordings import mesh_with_faces
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


MESHES = {
    "vocaset": (
        "unposedcleaneddata/FaceTalk_170725_00137_TA/sentence01/sentence01.{:06d}.ply",
        "audio/FaceTalk_170725_00137_TA/sentence01.wav",
        ("FaceTalk_170725_00137_TA-sentence01", "FaceTalk_170725_00137_TA", ""),
    ),
    "biwi": ("faces/F1/01/frame_{:03d}.vl", "audio/F1/01.wav", ("F1-01", "F1", "")),
    "multiface": (
        "m--20180227--0000--6795937--GHS/tracked_mesh/SEN_a_good_morrow/{:06d}.bin",
        "m--20180227--0000--6795937--GHS/audio/SEN_a_good_morrow.wav",
        ("m--20180227--0000--6795937--GHS-SEN_a_good_morrow", "6795937", "a good morrow"),
    ),
}


def write_mesh(path: Path, places: np.ndarray) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    raw = places.astype("<f4").tobytes()
    if path.suffix == ".ply":
        fields = "".join(f"property float {axis}\n" for axis in "xyz")
        head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(places)}\n{fields}end_header\n"
        raw = head.encode() + raw
    elif path.suffix == ".vl":
        raw = len(places).to_bytes(4, "little") + raw
    path.write_bytes(raw)


@pytest.mark.parametrize("name", MESHES)
def test_meshes_are_read_as_markers(name: str, tmp_path: Path) -> None:
    frame, sound, (take, speaker, text) = MESHES[name]
    recipe = load_recipe(name)
    markers = load_layout(recipe.layout).markers
    recipe = recipe.with_changes(vertices={marker: number + 1 for number, marker in enumerate(markers)})
    places = np.random.default_rng(1).normal(size=(4, len(markers) + 2, 3)).astype(np.float32)
    for number in (0, 1, 3):  # one frame is missing
        write_mesh(tmp_path / frame.format(number + 7), places[number])
    (tmp_path / sound).parent.mkdir(parents=True, exist_ok=True)
    soundfile.write(tmp_path / sound, np.zeros(1600), 16000)
    takes, facts, _ = plan(name, tmp_path)
    assert (facts[take]["speaker"], facts[take]["text"]) == (speaker, text)
    assert takes[take].sound == tmp_path / sound
    raw = reader_named("meshes").read(takes[take], recipe)
    np.testing.assert_allclose(raw.markers.positions[[0, 1, 3]], places[[0, 1, 3], 1:-1], rtol=1e-6)
    assert np.isnan(raw.markers.positions[2]).all()
    assert raw.markers.rate.fps == recipe.fps
    assert raw.audio is not None
    assert detect(tmp_path).name == "meshes"


def test_faces_come_from_a_mesh_of_as_many_vertices(tmp_path: Path) -> None:
    first = tmp_path / "faces/F1/01/frame_001.vl"
    write_mesh(first, np.zeros((3, 3)))
    with pytest.raises(InputError, match=r"expected an \.obj or \.ply of 3 vertices"):
        mesh_with_faces(tmp_path, first)
    for name, count in (("other", 4), ("F1", 3)):
        (tmp_path / f"{name}.obj").write_text("v 0 0 0\n" * count + "f 1 2 3\n")
    assert mesh_with_faces(tmp_path, first).name == "F1.obj"
    first.write_bytes(b"\x03\x00\x00\x00" + bytes(20))
    with pytest.raises(InputError, match=r"damaged \.vl file"):
        mesh_with_faces(tmp_path, first)


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
