"""Videos as phones record them: turned, mirrored, at a rate that wanders, with two sound tracks."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from mien.corpus.readers.video_recordings import steady_frames
from mien.formats.sound_files import read_audio

ONE = 65536
TURNS = {  # a b c d of the track's matrix, and where what was at the top left is seen
    "as it lies": ((1, 0, 0, 1), "top left"),
    "a quarter to the right": ((0, 1, -1, 0), "top right"),
    "upside down": ((-1, 0, 0, -1), "bottom right"),
    "a quarter to the left": ((0, -1, 1, 0), "bottom left"),
    "mirrored": ((-1, 0, 0, 1), "top right"),
    "mirrored upside down": ((1, 0, 0, -1), "bottom left"),
    "mirrored and turned": ((0, 1, 1, 0), "top left"),
}


def write_video(path: Path, times: Sequence[float]) -> Path:
    """Pictures of 64 x 48 with a red corner at the top left and a right edge as bright as the frame's number."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mpeg4", rate=30)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        stream.time_base = stream.codec_context.time_base = Fraction(1, 600)
        for number, time in enumerate(times):
            picture = np.full((48, 64, 3), 40, np.uint8)
            picture[:16, :16], picture[:, 48:] = [250, 0, 0], 15 * number
            frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
            frame.pts, frame.time_base = round(time * 600), Fraction(1, 600)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


def turned(path: Path, matrix: tuple[int, int, int, int]) -> Path:
    """The matrix of the track's header: 36 bytes, 48 after the name of the box."""
    content = bytearray(path.read_bytes())
    a, b, c, d = (ONE * value for value in matrix)
    struct.pack_into(">9i", content, content.index(b"tkhd") + 44, a, b, 0, c, d, 0, 0, 0, 1 << 30)
    path.write_bytes(content)
    return path


@pytest.mark.parametrize("name", TURNS)
def test_a_turned_or_mirrored_picture_is_seen_as_it_was(tmp_path: Path, name: str) -> None:
    matrix, corner = TURNS[name]
    _, _, frames = steady_frames(turned(write_video(tmp_path / "a.mp4", [0, 1 / 30]), matrix))
    picture = next(frames).astype(int)
    red = (picture[..., 0] > 150) & (picture[..., 1] < 100)
    down, across = (np.argwhere(red).mean(axis=0) / red.shape > 0.5).tolist()
    assert f"{'bottom' if down else 'top'} {'right' if across else 'left'}" == corner
    assert (picture.shape[0] > picture.shape[1]) == (matrix[0] == 0)


def test_a_rate_that_wanders_is_made_steady(tmp_path: Path) -> None:
    times = [0, 0.02, 0.05, 0.12, 0.15, 0.2, 0.3, 0.32, 0.5, 0.52, 0.6, 0.9, 1.0]
    rate, _, frames = steady_frames(write_video(tmp_path / "a.mp4", times), 30)
    seen = [round(float(frame[60, 120].mean()) / 15) for frame in frames]
    assert rate.fps == 30
    assert seen == [int(np.argmin([abs(time - frame / 30) for time in times])) for frame in range(31)]


def test_of_two_sound_tracks_the_first_is_taken_and_said(tmp_path: Path) -> None:
    path = tmp_path / "two.mkv"
    with av.open(str(path), "w") as container:
        streams = [container.add_stream("pcm_s16le", rate=16000, layout="mono") for _ in range(2)]
        for stream, level in zip(streams, (0.5, 0.1), strict=True):
            sound = (level * 32767 * np.sin(np.arange(8000) * 0.3)).astype(np.int16)
            frame = av.AudioFrame.from_ndarray(sound[None], format="s16", layout="mono")
            frame.sample_rate = 16000
            container.mux(stream.encode(frame))
            container.mux(stream.encode())
    audio, notes = read_audio(path)
    assert np.abs(audio.samples).max() == pytest.approx(0.5, abs=0.01)
    assert "two.mkv has 2 sound tracks: the first is used" in " ".join(note.message for note in notes)
