from __future__ import annotations

from pathlib import Path

import av
import numpy as np
import pytest
import soundfile

from mien.audio_files import read_audio
from mien.errors import InputError


def tone(seconds: float = 1.0, rate: int = 16000, channels: int = 1) -> np.ndarray:
    wave = 0.4 * np.sin(2 * np.pi * 300 * np.arange(int(seconds * rate)) / rate)
    return np.repeat(wave[:, None], channels, axis=1)


@pytest.mark.parametrize("subtype", ["PCM_16", "PCM_24", "PCM_32", "FLOAT", "DOUBLE", "PCM_U8"])
def test_every_wav_depth_is_read(tmp_path: Path, subtype: str) -> None:
    soundfile.write(tmp_path / "a.wav", tone(), 16000, subtype=subtype)
    audio, notes = read_audio(tmp_path / "a.wav")
    assert notes == ()
    assert np.abs(audio.samples - tone()[:, 0]).max() < 0.01


def test_eight_channels_are_averaged_with_one_note(tmp_path: Path) -> None:
    sound = tone(channels=8)
    sound[:, 3:] = 0
    soundfile.write(tmp_path / "a.wav", sound, 16000)
    audio, notes = read_audio(tmp_path / "a.wav")
    assert [note.kind for note in notes] == ["note"]
    assert "8 channels" in notes[0].message
    assert np.abs(audio.samples - tone()[:, 0] * 3 / 8).max() < 1e-3


@pytest.mark.parametrize(("rate", "kept"), [(8000, 8000), (44100, 44100), (192_000, 48_000)])
def test_odd_rates_are_read_with_at_most_one_note(tmp_path: Path, rate: int, kept: int) -> None:
    soundfile.write(tmp_path / "a.wav", tone(rate=rate), rate)
    audio, notes = read_audio(tmp_path / "a.wav")
    assert audio.rate == kept
    assert len(notes) == (rate != 44100)
    assert audio.duration == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("suffix", [".mp3", ".m4a", ".mp4", ".mkv", ".ogg", ".flac"])
def test_other_containers_are_read(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    codec = {".mp3": "libmp3lame", ".ogg": "libopus", ".flac": "flac"}.get(suffix, "aac")
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=48000, layout="mono")
        samples = tone(rate=48000)[:, 0].astype(np.float32)[None, :]
        frame = av.AudioFrame.from_ndarray(samples, format="fltp", layout="mono")
        frame.sample_rate = 48000
        resampler = av.AudioResampler(stream.format, stream.layout, stream.rate, frame_size=stream.frame_size or None)
        for piece in [*resampler.resample(frame), *resampler.resample(None)]:
            container.mux(stream.encode(piece))
        container.mux(stream.encode(None))
    audio, _ = read_audio(path)
    assert audio.duration == pytest.approx(1.0, abs=0.08)
    assert np.sqrt((audio.samples.astype(float) ** 2).mean()) == pytest.approx(0.4 / np.sqrt(2), rel=0.1)


def bad_files(folder: Path) -> dict[str, Path]:
    good = folder / "good.wav"
    soundfile.write(good, tone(), 16000)
    flac = folder / "good.flac"
    soundfile.write(flac, np.random.default_rng(1).uniform(-0.5, 0.5, 16000), 16000)
    contents = {
        "empty": b"",
        "random": np.random.default_rng(1).bytes(5000),
        "cut": good.read_bytes()[:9000],
        "header": good.read_bytes()[:36],
        "text": b"I never said that.\n",
    }
    paths = {}
    for name, content in contents.items():
        paths[name] = folder / f"{name}.wav"
        paths[name].write_bytes(content)
    paths["cutflac"] = folder / "cut.flac"
    paths["cutflac"].write_bytes(flac.read_bytes()[:9000])
    paths["folder"] = folder
    paths["missing"] = folder / "missing.wav"
    return paths


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("empty", "is empty"),
        ("random", "no decoder knows"),
        ("cut", "cut short"),
        ("header", "cut short"),
        ("text", "no decoder knows"),
        ("cutflac", "cut short"),
        ("folder", "got a folder"),
        ("missing", "no such file"),
    ],
)
def test_bad_files_are_refused_in_one_line(tmp_path: Path, name: str, words: str) -> None:
    path = bad_files(tmp_path)[name]
    with pytest.raises(InputError, match=words) as caught:
        read_audio(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


def test_too_short_a_sound_is_refused(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "a.wav", tone(0.01), 16000)
    with pytest.raises(InputError, match=r"at least 0\.02 s"):
        read_audio(tmp_path / "a.wav")


def test_a_wav_from_a_pipe_with_unknown_length_is_read(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "a.wav", tone(), 16000)
    content = bytearray((tmp_path / "a.wav").read_bytes())
    content[4:8] = content[40:44] = b"\xff\xff\xff\xff"
    (tmp_path / "a.wav").write_bytes(bytes(content))
    audio, _ = read_audio(tmp_path / "a.wav")
    assert audio.duration == pytest.approx(1.0, abs=0.01)


def test_float_sound_above_full_scale_is_turned_down_with_a_note(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "a.wav", 3 * tone(), 16000, subtype="FLOAT")
    audio, notes = read_audio(tmp_path / "a.wav")
    assert "1.20 of full scale" in notes[0].message
    assert np.abs(audio.samples - tone()[:, 0] * 3 / 1.2).max() < 1e-3
