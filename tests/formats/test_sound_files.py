from __future__ import annotations

import struct
from pathlib import Path

import av
import numpy as np
import pytest
import soundfile
from PIL import Image

from mien.core.errors import InputError
from mien.formats.sound_files import read_audio


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
    assert "1.2 of full scale" in notes[0].message
    assert np.abs(audio.samples - tone()[:, 0] * 3 / 1.2).max() < 1e-3


def test_gsm_in_wav_is_read(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "a.wav", tone(rate=8000), 8000, subtype="GSM610")
    audio, _ = read_audio(tmp_path / "a.wav")
    assert audio.duration == pytest.approx(1.0, abs=0.05)
    assert np.sqrt((audio.samples.astype(float) ** 2).mean()) == pytest.approx(0.4 / np.sqrt(2), rel=0.1)


@pytest.mark.parametrize("subtype", ["ULAW", "ALAW", "IMA_ADPCM", "MS_ADPCM", "G721_32"])
def test_other_codecs_in_wav_are_read(tmp_path: Path, subtype: str) -> None:
    rate = 8000
    soundfile.write(tmp_path / "a.wav", tone(rate=rate), rate, subtype=subtype)
    audio, _ = read_audio(tmp_path / "a.wav")
    assert audio.duration == pytest.approx(1.0, abs=0.1)
    assert np.sqrt((audio.samples.astype(float) ** 2).mean()) == pytest.approx(0.4 / np.sqrt(2), rel=0.1)


def test_channels_that_cancel_are_not_averaged(tmp_path: Path) -> None:
    sound = tone(channels=2)
    sound[:, 1] *= -0.9
    soundfile.write(tmp_path / "a.wav", sound, 16000)
    audio, notes = read_audio(tmp_path / "a.wav")
    assert [note.kind for note in notes] == ["warning"]
    assert "cancel" in notes[0].message
    assert np.abs(audio.samples - tone()[:, 0]).max() < 1e-3


def test_unrelated_channels_are_averaged(tmp_path: Path) -> None:
    noise = np.random.default_rng(0).uniform(-0.5, 0.5, (16000, 4))
    soundfile.write(tmp_path / "a.wav", noise, 16000)
    audio, notes = read_audio(tmp_path / "a.wav")
    assert "average" in notes[0].message
    assert np.abs(audio.samples - noise.mean(axis=1)).max() < 1e-3


def test_a_constant_offset_is_taken_out(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "a.wav", tone() + 0.3, 16000)
    audio, notes = read_audio(tmp_path / "a.wav")
    assert "offset of +0.3 " in notes[0].message
    assert np.abs(audio.samples - tone()[:, 0]).max() < 1e-3


def test_clipping_is_noted(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "a.wav", np.clip(4 * tone(), -1, 1), 16000)
    _, notes = read_audio(tmp_path / "a.wav")
    assert [note.kind for note in notes] == ["warning"]
    assert "clipped" in notes[0].message


def riff(*chunks: tuple[bytes, bytes, int]) -> bytes:
    """A WAV file of chunks: name, content, and by how much its length is misstated; without padding bytes."""
    body = b"".join(name + struct.pack("<I", len(content) + wrong) + content for name, content, wrong in chunks)
    return b"RIFF" + struct.pack("<I", 4 + len(body)) + b"WAVE" + body


FORMAT = (b"fmt ", struct.pack("<HHIIHH", 1, 1, 16000, 32000, 2, 16), 0)


@pytest.mark.parametrize("wrong", [-32000, 0, 8, 300])
def test_wav_headers_that_are_a_little_wrong(tmp_path: Path, wrong: int) -> None:
    samples = (tone()[:, 0] * 32767).astype("<i2").tobytes()
    (tmp_path / "a.wav").write_bytes(riff(FORMAT, (b"LIST", b"abc", 0), (b"data", samples, wrong)))
    audio, notes = read_audio(tmp_path / "a.wav")
    assert audio.duration == pytest.approx(1.0, abs=0.01)
    assert ("bytes more" in "".join(note.message for note in notes)) == (wrong > 0)


def test_a_list_of_other_files_is_not_followed(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "secret.wav", tone(), 16000)
    lists = {
        "a.ffconcat": "ffconcat version 1.0\nfile secret.wav\n",
        "a.wav": "ffconcat version 1.0\nfile secret.wav\n",
        "a.m3u8": "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nsecret.wav\n#EXT-X-ENDLIST\n",
        "a.sdp": "v=0\no=- 0 0 IN IP4 127.0.0.1\ns=x\nc=IN IP4 127.0.0.1\nt=0 0\nm=audio 5004 RTP/AVP 0\n",
    }
    for name, content in lists.items():
        (tmp_path / name).write_text(content)
        with pytest.raises(InputError):
            read_audio(tmp_path / name)


@pytest.mark.parametrize("name", ["a.png", "a.jpg", "a.bmp"])
def test_a_picture_is_called_one(tmp_path: Path, name: str) -> None:
    Image.new("RGB", (8, 8)).save(tmp_path / name)
    for content in ((tmp_path / name).read_bytes(), (tmp_path / name).read_bytes()[:8] + b"damaged"):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match="expected a sound or video file, got a picture"):
            read_audio(tmp_path / name)


def test_hours_and_channels_have_limits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    soundfile.write(tmp_path / "a.flac", tone(4.0), 16000)
    monkeypatch.setenv("MIEN_MOST_HOURS", "0.001")
    with pytest.raises(InputError, match="MIEN_MOST_HOURS"):
        read_audio(tmp_path / "a.flac")
    soundfile.write(tmp_path / "a.wav", np.zeros((1600, 65)), 16000)
    with pytest.raises(InputError, match="MIEN_MOST_CHANNELS"):
        read_audio(tmp_path / "a.wav")


def test_long_sound_is_read_in_blocks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mien.formats.sound_files._BLOCK", 1000)
    monkeypatch.setattr("mien.formats.sound_files._LONG", 0.5)
    soundfile.write(tmp_path / "a.wav", tone(), 16000)
    audio, _ = read_audio(tmp_path / "a.wav")
    assert len(audio) == 16000
    assert np.abs(audio.samples - tone()[:, 0]).max() < 1e-3


def test_channels_that_cancel_at_times_or_under_an_offset_are_not_averaged(tmp_path: Path) -> None:
    one = tone()[:, 0]
    offset = np.stack([one + 0.2, 0.2 - one], axis=1)
    half = np.concatenate([np.stack([one, one], axis=1), np.stack([one, -one], axis=1)])
    for sound in (offset, half):
        soundfile.write(tmp_path / "a.wav", sound, 16000)
        audio, notes = read_audio(tmp_path / "a.wav")
        assert "cancel" in notes[0].message
        assert np.abs(audio.samples[-16000:]).max() == pytest.approx(0.4, abs=0.01)


def test_clipping_is_seen_at_any_level_and_under_an_offset(tmp_path: Path) -> None:
    speech = np.cumsum(np.random.default_rng(3).normal(size=16000))
    speech = np.clip(speech / speech.std(), -0.7, 0.7)
    for sound, clipped in (
        (speech, True),
        (speech * 0.9 + 0.2, True),
        (tone()[:, 0], False),
        (np.ones(16000) / 2, False),
    ):
        soundfile.write(tmp_path / "a.wav", sound, 16000)
        assert any("clipped" in note.message for note in read_audio(tmp_path / "a.wav")[1]) == clipped


def test_a_sample_beyond_all_measure_is_damage(tmp_path: Path) -> None:
    sound = tone()[:, 0]
    sound[100] = 1e300
    soundfile.write(tmp_path / "a.wav", sound, 16000, subtype="DOUBLE")
    with pytest.raises(InputError, match=r"1e\+300 times full scale"):
        read_audio(tmp_path / "a.wav")


def test_a_header_may_be_wrong_by_a_tenth_not_by_half(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "a.wav", tone(3.0, 8000), 8000, subtype="GSM610")
    content = (tmp_path / "a.wav").read_bytes()
    at = content.index(b"data") + 4
    held = len(content) - at - 4
    for promised in (held + held // 12, 0x7FFFF024, 0x80000005):
        (tmp_path / "b.wav").write_bytes(content[:at] + struct.pack("<I", promised) + content[at + 4 :])
        assert read_audio(tmp_path / "b.wav")[0].duration == pytest.approx(3.0, abs=0.1)
    (tmp_path / "b.wav").write_bytes(content[: at + held // 2])
    with pytest.raises(InputError, match="cut short"):
        read_audio(tmp_path / "b.wav")


def test_no_library_writes_to_the_terminal(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    for name, content in (("a.mp3", b"\x01" * 100_000), ("a.wav", b"ID3\x04" + b"\x01" * 100_000)):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError):
            read_audio(tmp_path / name)
    assert capfd.readouterr().err == ""
