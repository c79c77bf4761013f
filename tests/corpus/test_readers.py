"""One contract for every reader, then what is special to each."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mien.capture.cleaning.normalise import apply
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.corpus.readers import detect, reader_named
from mien.corpus.recipes import load_recipe
from tests.corpus import recordings as made

Writer = Callable[[Path, str], Path]
KINDS: dict[str, Writer] = {
    "c3d": made.write_c3d,
    "tracks": made.write_csv,
    "livelink": made.write_livelink,
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_source_is_recognised_found_and_read(tmp_path: Path, kind: str) -> None:
    for name in ("b", "a"):
        KINDS[kind](tmp_path / "deep", name)
        made.write_speech(tmp_path, name)
    reader = detect(tmp_path)
    assert reader.name == kind
    found = reader.find(tmp_path)
    assert [recording.name for recording in found] == ["a", "b"]
    assert all(r.sound is not None and r.transcript is not None for r in found)
    raw = reader.read(found[0], load_recipe(kind))
    assert len(raw.markers) == len(made.opening())
    assert raw.markers.rate == made.RATE
    assert raw.audio is not None
    assert raw.audio.duration == pytest.approx(made.SECONDS)
    assert [r.name for r in reader.find(found[0].motion)] == ["a"]


@pytest.mark.parametrize("kind", ["c3d", "tracks"])
def test_marker_positions_come_back(tmp_path: Path, kind: str) -> None:
    path = KINDS[kind](tmp_path, "a")
    raw = reader_named(kind).read(reader_named(kind).find(path)[0], load_recipe(kind))
    order = [raw.markers.names.index(name) for name in made.LAYOUT.markers]
    assert np.allclose(raw.markers.positions[:, order], made.moving(), atol=1e-3)


def test_nothing_that_is_known_is_said_so(tmp_path: Path) -> None:
    (tmp_path / "a.doc").write_text("x")
    with pytest.raises(InputError, match="no recording found that mien knows; expected"):
        detect(tmp_path)
    with pytest.raises(InputError, match="nothing of that name"):
        detect(tmp_path / "none")


# ---- C3D ---------------------------------------------------------------------------------------------------------


def read_c3d(path: Path) -> object:
    reader = reader_named("c3d")
    return reader.read(reader.find(path)[0], load_recipe("c3d"))


def test_sound_in_an_analog_channel(tmp_path: Path) -> None:
    path = made.write_c3d(tmp_path, "a", analog=made.sound().resampled(12_000))
    raw = reader_named("c3d").read(reader_named("c3d").find(path)[0], load_recipe("c3d"))
    assert raw.audio is not None
    assert (raw.audio.rate, round(raw.audio.duration, 2)) == (12_000, 2.0)
    assert float(np.abs(raw.audio.samples).max()) == pytest.approx(0.3, abs=0.01)


def test_points_not_seen_are_nan(tmp_path: Path) -> None:
    positions = made.moving()
    positions[5, 3] = np.nan
    positions[6, 4] = 0.0
    raw = reader_named("c3d").read(
        reader_named("c3d").find(made.write_c3d(tmp_path, "a", positions))[0], load_recipe("c3d")
    )
    assert np.argwhere(np.isnan(raw.markers.positions).any(axis=2)).tolist() == [[5, 3], [6, 4]]


@pytest.mark.parametrize("share", [0.01, 0.3, 0.9])
def test_a_c3d_that_is_cut_short_is_refused_with_its_name(tmp_path: Path, share: float) -> None:
    path = made.write_c3d(tmp_path, "a")
    path.write_bytes(path.read_bytes()[: int(path.stat().st_size * share)])
    with pytest.raises(InputError, match=r"a\.c3d: .*cut short"):
        read_c3d(path)


def test_a_rate_of_zero_and_a_file_of_another_kind_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a\.c3d: its frame rate \(POINT:RATE\) is 0"):
        read_c3d(made.write_c3d(tmp_path, "a", fps=0.0))
    other = tmp_path / "b.c3d"
    other.write_bytes(bytes(range(256)) * 20)
    with pytest.raises(InputError, match=r"b\.c3d: cannot be read as C3D"):
        read_c3d(other)


# ---- CSV and NPZ -------------------------------------------------------------------------------------------------


def read_tracks(path: Path) -> object:
    reader = reader_named("tracks")
    return reader.read(reader.find(path)[0], load_recipe("tracks"))


def test_npz_tracks_and_the_motion_of_a_corpus(tmp_path: Path) -> None:
    path = made.write_npz(tmp_path, "a")
    raw = reader_named("tracks").read(reader_named("tracks").find(path)[0], load_recipe("tracks"))
    assert np.array_equal(raw.markers.positions, made.moving())
    np.savez(path, markers=made.moving(), names=np.array(made.LAYOUT.markers), rate=np.array([30000, 1001]))
    raw = reader_named("tracks").read(reader_named("tracks").find(path)[0], load_recipe("tracks"))
    assert raw.markers.rate == FrameRate.of("30000/1001")


def test_faults_of_tables_name_file_line_and_frame(tmp_path: Path) -> None:
    path = made.write_csv(tmp_path, "a")
    lines = path.read_text().splitlines()
    (tmp_path / "b.csv").write_text("\n".join([*lines[:5], lines[5].replace(".", "?", 3), *lines[6:]]))
    with pytest.raises(InputError, match=r"b\.csv, line 6 \(frame 4\): expected a number"):
        read_tracks(tmp_path / "b.csv")
    (tmp_path / "c.csv").write_text("\n".join(lines[:7]) + lines[7][:40])
    with pytest.raises(InputError, match=r"c\.csv, line 7: .* columns.*cut short"):
        read_tracks(tmp_path / "c.csv")
    (tmp_path / "d.csv").write_text("\n".join([*lines[:9], *lines[12:]]))
    with pytest.raises(InputError, match=r"d\.csv, line 10 \(frame 8\): 0\.06667 s after .* frames are missing"):
        read_tracks(tmp_path / "d.csv")
    with pytest.raises(InputError, match=r"e\.csv: column 'time' does not run forward"):
        read_tracks(made.write_csv(tmp_path, "e", times=np.zeros(len(made.opening()))))
    with pytest.raises(InputError, match=r"f\.npz: its frame rate is 0"):
        read_tracks(made.write_npz(tmp_path, "f", fps=0.0))
    half = made.write_npz(tmp_path, "g")
    half.write_bytes(half.read_bytes()[:-200])
    assert reader_named("tracks").find(half) == []


# ---- Live Link ---------------------------------------------------------------------------------------------------


def test_weights_move_the_markers_of_the_default_face(tmp_path: Path) -> None:
    path = made.write_livelink(tmp_path, "a")
    raw = reader_named("livelink").read(reader_named("livelink").find(path)[0], load_recipe("livelink"))
    names = raw.markers.names
    lips = np.linalg.norm(
        raw.markers.positions[:, names.index("8.1")] - raw.markers.positions[:, names.index("8.2")], axis=1
    )
    assert np.corrcoef(lips, made.opening())[0, 1] > 0.99
    assert raw.channels is not None
    assert np.allclose(raw.channels.channel("jawOpen"), made.opening() / 20, atol=1e-6)
    assert raw.head is not None
    nose = raw.markers.positions[:1, [names.index("9.3")]]
    turned = apply(raw.head[:1], nose)
    assert turned[0, 0, 0] > nose[0, 0, 0]  # HeadYaw > 0 turns to the speaker's left


# ---- GRID and video ----------------------------------------------------------------------------------------------


def test_grid_arrays(tmp_path: Path) -> None:
    made.write_grid(tmp_path, ("bbaf2n", "bbaf3s"))
    (tmp_path / "words").mkdir()
    (tmp_path / "words" / "bbaf2n.align").write_text("0 10 bin\n")
    reader = detect(tmp_path)
    assert reader.name == "grid"
    found = reader.find(tmp_path)
    assert [(r.name, r.transcript is not None) for r in found] == [("bbaf2n", True), ("bbaf3s", False)]
    raw = reader.read(found[0], load_recipe("grid"))
    assert (len(raw.markers), raw.units, raw.markers.rate) == (50, "pixels", FrameRate.of(25))
    assert raw.channels is None  # a tracker's own weights are none that were recorded


FAKE_TRACKER = """
import struct, sys
out, inn = sys.stdout.buffer, sys.stdin.buffer
out.write(b"R"); out.flush()
while True:
    width, height = struct.unpack("<II", inn.read(8) or bytes(8))
    if not width:
        break
    pixels = inn.read(3 * width * height)
    if pixels[0] > 200:
        sys.exit("too bright for me")
    found = pixels[0] > 40
    values = [v for i in range(478) for v in (i, pixels[0], -i)]
    out.write(bytes([found]) + struct.pack("<1434f", *values)); out.flush()
"""


@pytest.fixture
def fake_tracker(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A tracker whose landmarks tell the brightness of the picture; it loses the face in dark ones, dies in bright."""
    from mien.capture import tracker, tracker_worker

    script = tmp_path / "fake_tracker.py"
    script.write_text(FAKE_TRACKER)
    monkeypatch.setattr(tracker_worker, "__file__", str(script))
    monkeypatch.setattr(tracker, "tracker_python", lambda: Path(sys.executable))
    monkeypatch.setattr(tracker, "_kept", {})


def write_video(path: Path, brightness: list[int]) -> None:
    """A lossless grey video at 25 fps with a tone."""
    import av

    with av.open(str(path), "w") as container:
        stream = container.add_stream("ffv1", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "gray"
        sound = container.add_stream("pcm_s16le", rate=16_000, layout="mono")
        for value in brightness:
            picture = av.VideoFrame.from_ndarray(np.full((48, 64), value, np.uint8), format="gray")
            container.mux(stream.encode(picture))
        container.mux(stream.encode())
        tone = (8000 * np.sin(np.arange(640 * len(brightness)) / 9)).astype(np.int16)
        chunk = av.AudioFrame.from_ndarray(tone[None], format="s16", layout="mono")
        chunk.sample_rate = 16_000
        container.mux(sound.encode(chunk))
        container.mux(sound.encode())


@pytest.mark.usefixtures("fake_tracker")
def test_video_is_tracked_frame_by_frame(tmp_path: Path) -> None:
    path = tmp_path / "a.mkv"
    write_video(path, [60, 80, 20, 120])
    reader = detect(path)
    assert reader.name == "video"
    raw = reader.read(reader.find(path)[0], load_recipe("video"))
    assert len(raw.markers) == 4
    first = raw.markers.positions[:, 0]
    assert np.isnan(first[2]).all()
    assert first[[0, 1, 3], 1] * 2 == pytest.approx([60, 80, 120], abs=3)  # the picture was enlarged twice
    assert raw.audio is not None
    assert raw.audio.duration == pytest.approx(0.16, abs=0.01)


@pytest.mark.usefixtures("fake_tracker")
def test_a_tracker_that_ends_is_told_and_started_anew(tmp_path: Path) -> None:
    write_video(tmp_path / "a.mkv", [60, 250, 60])
    write_video(tmp_path / "b.mkv", [60, 60])
    reader, recipe = reader_named("video"), load_recipe("video")
    a, b = reader.find(tmp_path)
    with pytest.raises(InputError, match=r"a\.mkv: the face tracker ended in frame 1: too bright for me"):
        reader.read(a, recipe)
    assert len(reader.read(b, recipe).markers) == 2


@pytest.mark.usefixtures("fake_tracker")
def test_a_video_without_a_face_or_without_pictures_is_refused(tmp_path: Path) -> None:
    write_video(tmp_path / "a.mkv", [20, 20, 20, 20])
    reader, recipe = reader_named("video"), load_recipe("video")
    with pytest.raises(InputError, match=r"a\.mkv: no face found in any of 4 frames"):
        reader.read(reader.find(tmp_path)[0], recipe)
    (tmp_path / "b.mp4").write_bytes(b"no video at all")
    with pytest.raises(InputError, match=r"b\.mp4: expected a video"):
        reader.read(reader.find(tmp_path / "b.mp4")[0], recipe)


def test_the_tracker_worker_runs_without_mien() -> None:
    from mien.capture import tracker_worker

    text = Path(tracker_worker.__file__).read_text(encoding="utf-8")
    assert "mien." not in text.replace("without mien.", "")
    done = subprocess.run([sys.executable, "-m", "py_compile", tracker_worker.__file__], check=False)
    assert done.returncode == 0


def test_the_subject_in_front_of_c3d_labels_is_left_out(tmp_path: Path) -> None:
    import ezc3d

    path = made.write_c3d(tmp_path, "a")
    plain = reader_named("c3d").read(reader_named("c3d").find(path)[0], load_recipe("c3d"))
    file = ezc3d.c3d(str(path))
    labels = file["parameters"]["POINT"]["LABELS"]["value"]
    file["parameters"]["POINT"]["LABELS"]["value"] = [f"Subject:{label}" for label in labels]
    file.write(str(path))
    raw = reader_named("c3d").read(reader_named("c3d").find(path)[0], load_recipe("c3d"))
    assert raw.markers.names == plain.markers.names
    assert "begin with a subject" in " ".join(note.message for note in raw.notes)


def test_points_without_a_name_computed_ones_and_more_than_255(tmp_path: Path) -> None:
    import ezc3d

    path = made.write_c3d(tmp_path, "a")
    plain = read_c3d(path)
    file = ezc3d.c3d(str(path))
    point, markers = file["parameters"]["POINT"], list(plain.markers.names)
    odd = ["*110", "Anna:*3", "U_1", "Unlabeled 1001", "uname*4", "LHipAngles", *(f"extra{n}" for n in range(240))]
    points = np.ones((4, len(markers) + len(odd), len(plain.markers)))
    points[:, : len(markers)] = file["data"]["points"]
    new = ezc3d.c3d()
    for name in ("RATE", "UNITS"):
        new["parameters"]["POINT"][name]["value"] = point[name]["value"]
    new["parameters"]["POINT"]["LABELS"]["value"] = [*markers, *odd]
    new.add_parameter("POINT", "ANGLES", ["LHipAngles", ""])
    new["data"]["points"] = points
    new.write(str(path))
    raw = read_c3d(path)
    assert raw.markers.names == (*markers, *(f"extra{n}" for n in range(240)))
    np.testing.assert_allclose(raw.markers.positions[:, : len(markers)], plain.markers.positions, atol=1e-4)
    told = " ".join(note.message for note in raw.notes)
    assert "5 points without a name are left out" in told
    assert "1 angles, forces and the like are left out" in told


def test_a_c3d_file_of_another_kind_of_computer_is_told(tmp_path: Path) -> None:
    path = made.write_c3d(tmp_path, "a")
    content = bytearray(path.read_bytes())
    content[(content[0] - 1) * 512 + 3] = 86
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"MIPS .* computers: save it"):
        read_c3d(path)


def test_a_c3d_file_that_crashes_the_library_is_one_line(tmp_path: Path) -> None:
    path = made.write_c3d(tmp_path, "a")
    whole = path.read_bytes()
    start = (whole[0] - 1) * 512
    rng = np.random.default_rng(0)
    refused = 0
    for _ in range(12):
        damaged = bytearray(whole)
        for place in rng.integers(4, 900, 20):
            damaged[start + int(place)] = int(rng.integers(256))
        path.write_bytes(damaged)
        try:
            reader_named("c3d").read(reader_named("c3d").find(path)[0], load_recipe("c3d"))
        except InputError:
            refused += 1
    assert refused > 6
