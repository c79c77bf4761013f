"""The main job end to end: a line of text, or a recording, becomes a talking face."""

from __future__ import annotations

import struct
from pathlib import Path

import av
import numpy as np
import pytest

import mien
from mien.animation.animation import Animation
from mien.cli import main
from mien.core import channels
from mien.face.library import load_face
from mien.face.model import Face
from mien.face.posing import Poser
from mien.formats.native import read_native

LINE = "Papa may buy five very good mauve vans, Bob."
PAIRS = ["", *(f"_{side}{step}" for side in "lr" for step in (1, 2))]


@pytest.fixture(scope="module")
def spoken() -> Animation:
    return mien.say(LINE, fps=50)


@pytest.fixture(scope="module")
def face() -> Face:
    return load_face("default")


def inner_lip_gap(face: Face, poser: Poser, row: np.ndarray) -> float:
    """The widest vertical gap between the inner lips over five places across the mouth, mm."""
    posed = dict(zip((part.name for part in face.parts), poser.pose(row).parts, strict=True))

    def height(name: str) -> float:
        part, vertex = face.sites[name]
        return float(posed[part].vertices[vertex, 1])

    return max(height(f"lip_upper_inner{p}") - height(f"lip_lower_inner{p}") for p in PAIRS)


def frames_in(animation: Animation, *phones: str) -> list[int]:
    """The frame nearest to the middle of every such phone."""
    rate = animation.rate
    return [rate.nearest_frame(p.middle) for p in animation.utterance.phones if p.label in phones]


def without_head(animation: Animation) -> np.ndarray:
    values = animation.channels.values.copy()
    values[:, [animation.channels.names.index(name) for name in channels.HEAD]] = 0
    return values


@pytest.mark.parametrize("emotion", [None, "happy", "angry", "sad", "surprised", "afraid", "disgusted"])
def test_the_lips_are_shut_on_every_bilabial_whatever_the_emotion(emotion: str | None, face: Face) -> None:
    animation = mien.say(LINE, fps=50, emotion=emotion)
    values, poser = without_head(animation), Poser(face, channels.ALL)
    bilabials = frames_in(animation, "P", "B", "M")
    assert len(bilabials) >= 6
    gaps = [inner_lip_gap(face, poser, values[frame]) for frame in bilabials]
    assert max(gaps) <= 0.6


def test_the_mouth_opens_on_open_vowels(spoken: Animation, face: Face) -> None:
    values, poser = without_head(spoken), Poser(face, channels.ALL)
    gaps = [inner_lip_gap(face, poser, values[frame]) for frame in frames_in(spoken, "AA", "AY")]
    assert np.median(gaps) > 5


def test_the_command_writes_every_format(tmp_path: Path) -> None:
    outputs = [tmp_path / f"line{suffix}" for suffix in (".mp4", ".glb", ".csv", ".TextGrid", ".json", ".png", ".wav")]
    also = [argument for path in outputs[1:] for argument in ("--also", str(path))]
    assert main(["say", "My pie.", "-o", str(outputs[0]), *also, "--fps", "25", "--quiet"]) == 0
    assert all(path.stat().st_size > 500 for path in outputs)
    animation = read_native(tmp_path / "line.json")
    assert animation.rate.fps == 25
    with av.open(str(tmp_path / "line.mp4")) as video:
        picture, sound = video.streams.video[0], video.streams.audio[0]
        assert (picture.codec_context.name, sound.codec_context.name) == ("h264", "aac")
        shown = picture.frames / 25
    assert abs(shown - animation.utterance.duration) <= 1 / 25
    assert (tmp_path / "line.csv").read_text().count("\n") == len(animation.channels) + 1
    magic, version, length = struct.unpack("<4sII", (tmp_path / "line.glb").read_bytes()[:12])
    assert (magic, version, length) == (b"glTF", 2, (tmp_path / "line.glb").stat().st_size)


def test_the_same_seed_says_the_same_bits() -> None:
    one, again = (mien.say("My pie.", emotion="sad", seed=3) for _ in range(2))
    assert one == again


@pytest.mark.data
def test_a_recording_with_its_text_moves_the_mouth_at_the_right_time(shared_data: Path, face: Face) -> None:
    sound = next(iter(sorted((shared_data / "timit-sample").glob("*/sx276.flac"))))
    text = " ".join(sound.with_suffix(".txt").read_text().split()[2:])
    animation = mien.animate(sound, text=text, fps=50)
    assert animation.utterance.timing == "aligned"
    labels = [line.split() for line in sound.with_suffix(".phn").read_text().splitlines()]
    closures = [(int(start) + int(end)) / 2 / 16000 for start, end, label in labels if label in ("m", "bcl", "pcl")]
    assert closures
    poser, values = Poser(face, channels.ALL), without_head(animation)
    for moment in closures:
        middle = animation.rate.nearest_frame(moment)
        frames = range(max(0, middle - 3), min(middle + 4, len(values)))
        assert min(inner_lip_gap(face, poser, values[frame]) for frame in frames) < 1.0


@pytest.mark.data
def test_a_video_without_text_is_recognised_and_says_that_it_is_approximate(shared_data: Path) -> None:
    video = sorted((shared_data / "grid-s1" / "video").glob("*.mpg"))[0]
    animation = mien.animate(video)
    assert animation.utterance.timing == "recognised"
    assert any("approximate" in note.message for note in animation.notes)
    assert animation.channels.channel("jawOpen").max() > 0.1


def test_silence_gives_a_living_face_and_a_warning() -> None:
    animation = mien.animate(mien.Audio.silence(6.0, 16000))
    assert any(note.kind == "warning" for note in animation.notes)
    assert animation.channels.channel("eyeBlinkLeft").max() > 0.9
    assert animation.channels.channel("jawOpen").max() < 0.01  # nobody sees a hundredth
