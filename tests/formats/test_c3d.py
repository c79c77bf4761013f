"""C3D: what ezc3d reads is where the face's markers are; the project's own reader takes it back with its sound."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import ezc3d
import numpy as np
import pytest

from mien.animation.animation import Animation
from mien.capture.layouts import find_layout
from mien.core.channels import ALL
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.corpus.readers import reader_named
from mien.corpus.recipes import load_recipe
from mien.face.library import load_face
from mien.face.marker_sites import load_marker_places, place_markers
from mien.face.posing import Poser
from mien.formats.c3d import face_markers, write_c3d
from tests.faces import tiny_animation, tiny_face


@pytest.fixture(scope="module")
def animation() -> Animation:
    return tiny_animation(7)


def test_what_ezc3d_reads_is_where_the_markers_are(animation: Animation, tmp_path: Path) -> None:
    face = load_face()
    assert write_c3d(animation, face, tmp_path / "ä.c3d") == ()
    read = ezc3d.c3d(str(tmp_path / "ä.c3d"))
    point = read["parameters"]["POINT"]
    placed = place_markers(face, load_marker_places("mediapipe-218"))
    assert tuple(point["LABELS"]["value"]) == placed.names
    assert (point["UNITS"]["value"], point["RATE"]["value"][0]) == (["mm"], animation.rate.fps)
    assert read["parameters"]["MIEN"]["SOUND_START"]["value"][0] == 0.0
    positions = read["data"]["points"][:3].transpose(2, 1, 0)
    poser, number = Poser(face, ALL), {part.name: k for k, part in enumerate(face.parts)}
    for frame, row in enumerate(animation.channels.select(ALL).values):
        posed = poser.pose(row)
        by_hand = [posed.parts[number[part]].vertices[vertex] for part, vertex in placed.sites]
        np.testing.assert_allclose(positions[frame], by_hand, atol=1e-4)


def test_the_reader_takes_it_back_with_its_sound(animation: Animation, tmp_path: Path) -> None:
    face = load_face()
    write_c3d(animation, face, tmp_path / "a.c3d")
    reader = reader_named("c3d")
    raw = reader.read(reader.find(tmp_path / "a.c3d")[0], load_recipe("c3d"))
    written = face_markers(animation, face)
    assert raw.units == "mm"
    assert raw.markers.names == written.names
    assert raw.markers.rate == written.rate
    np.testing.assert_allclose(raw.markers.positions, written.positions, atol=1e-4)
    assert find_layout(raw.markers.names).name == "mediapipe-218"
    assert raw.audio is not None
    sound = animation.utterance.audio
    seconds = min(raw.audio.duration, sound.duration)
    again = raw.audio.resampled(sound.rate).samples[: int(seconds * sound.rate) - 50]
    assert np.corrcoef(again, sound.samples[: len(again)])[0, 1] > 0.999


def test_another_reader_takes_markers_and_sound(animation: Animation, tmp_path: Path) -> None:
    c3d = pytest.importorskip("c3d", reason="a reader by somebody else, of the extra 'dev'")
    write_c3d(animation, load_face(), tmp_path / "a.c3d")
    with (tmp_path / "a.c3d").open("rb") as file:
        frames = list(c3d.Reader(file).read_frames())
    markers = np.array([points[:, :3] for _, points, _ in frames])
    np.testing.assert_allclose(markers, face_markers(animation, load_face()).positions, atol=1e-4)
    sound = np.concatenate([analog[0] for _, _, analog in frames])
    read = ezc3d.c3d(str(tmp_path / "a.c3d"))["data"]["analogs"][0, 0]
    np.testing.assert_allclose(sound, read, atol=1e-6)
    assert np.abs(sound).max() > 0.1


@pytest.mark.parametrize("fps", ["24", "30000/1001", "59.94", "60"])
def test_another_reader_takes_every_frame_rate(animation: Animation, fps: str, tmp_path: Path) -> None:
    c3d = pytest.importorskip("c3d", reason="a reader by somebody else, of the extra 'dev'")
    rate = FrameRate.of(fps)
    channels = replace(animation.channels, rate=rate)
    write_c3d(replace(animation, channels=channels), load_face(), tmp_path / "a.c3d")
    with (tmp_path / "a.c3d").open("rb") as file:
        reader = c3d.Reader(file)
        assert len(list(reader.read_frames())) == len(channels)
    assert reader.point_rate == pytest.approx(rate.fps, abs=1e-3)


def test_another_layout_and_no_sound(animation: Animation, tmp_path: Path) -> None:
    write_c3d(animation, load_face(), tmp_path / "a.c3d", layout="mpeg4-32", sound=False)
    read = ezc3d.c3d(str(tmp_path / "a.c3d"))
    assert read["data"]["points"].shape[1:] == (32, 7)
    assert read["data"]["analogs"].size == 0


def test_a_face_without_any_hold_is_replaced_and_that_is_said(animation: Animation, tmp_path: Path) -> None:
    (note,) = write_c3d(animation, tiny_face(), tmp_path / "a.c3d")
    assert note.kind == "warning"
    assert "the markers are those of the default face" in note.message
    write_c3d(animation, load_face(), tmp_path / "b.c3d")
    assert (tmp_path / "a.c3d").read_bytes() == (tmp_path / "b.c3d").read_bytes()


def test_an_animation_without_frames_is_refused(animation: Animation, tmp_path: Path) -> None:
    none = ChannelTrack(animation.channels.names, animation.channels.values[:0], animation.rate)
    empty = replace(animation, channels=none)
    with pytest.raises(InputError, match="has no frames"):
        write_c3d(empty, load_face(), tmp_path / "a.c3d")
    assert list(tmp_path.iterdir()) == []
