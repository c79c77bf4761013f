"""Sound in pieces, in any form: the same samples come out, and what is no sound is refused in one line."""

from __future__ import annotations

import io
import struct
import threading

import numpy as np
import pytest
import soundfile
import soxr
from hypothesis import given
from hypothesis import strategies as st

from mien.core.errors import InputError
from mien.serve.live.resampling import StreamResampler
from mien.serve.live.sound_stream import FORMATS, Inbox, PcmDecoder, PcmForm, StreamedSound

WAVE = 0.5 * np.sin(2 * np.pi * 300 * np.arange(1600) / 16000)


def cut(data: bytes, sizes: list[int]) -> list[bytes]:
    pieces, place = [], 0
    for size in sizes:
        pieces.append(data[place : place + size])
        place += size
    return [*pieces, data[place:]]


@given(st.lists(st.integers(0, 700), max_size=12), st.sampled_from(["PCM_U8", "PCM_16", "PCM_24", "PCM_32", "FLOAT"]))
def test_a_wav_stream_cut_anywhere_gives_its_samples(sizes: list[int], kind: str) -> None:
    file = io.BytesIO()
    soundfile.write(file, WAVE, 16000, format="WAV", subtype=kind)
    stream = StreamedSound(PcmForm())
    found = np.concatenate([stream.push(piece) for piece in cut(file.getvalue(), sizes)])
    np.testing.assert_allclose(found[: len(WAVE)], WAVE, atol=0.01 if kind == "PCM_U8" else 1e-4)


def test_the_length_in_a_header_is_not_believed() -> None:
    file = io.BytesIO()
    soundfile.write(file, WAVE, 16000, format="WAV", subtype="PCM_16")
    data = bytearray(file.getvalue())
    data[4:8] = data[40:44] = b"\xff\xff\xff\xff"
    assert len(StreamedSound(PcmForm()).push(bytes(data))) == len(WAVE)


@pytest.mark.parametrize("form", sorted(FORMATS))
def test_raw_samples_of_every_form(form: str) -> None:
    whole = {"u8": (WAVE * 128 + 128).astype("u1"), "s16le": (WAVE * 2**15).astype("<i2"),
             "s32le": (WAVE * 2**31).astype("<i4"), "f32le": WAVE.astype("<f4"), "f64le": WAVE}  # fmt: skip
    data = b"".join(struct.pack("<i", int(v * 2**23))[:3] for v in WAVE) if form == "s24le" else whole[form].tobytes()
    np.testing.assert_allclose(PcmDecoder(PcmForm(16000, 1, form)).push(data), WAVE, atol=0.02)


def test_numbers_that_are_none_and_far_too_large_ones_do_no_harm() -> None:
    data = np.array([np.nan, np.inf, -np.inf, 1e30, 0.5], "<f4").tobytes()
    assert PcmDecoder(PcmForm(16000, 1, "f32le")).push(data).tolist() == [0.0, 1.0, -1.0, 1.0, 0.5]


@given(st.binary(min_size=4, max_size=400))
def test_any_bytes_are_sound_or_refused(data: bytes) -> None:
    stream = StreamedSound(PcmForm())
    try:
        found = stream.push(b"RIFF" + data)
    except InputError:
        return
    assert np.isfinite(found).all()


@pytest.mark.parametrize(
    ("head", "told"),
    [(b"OggS" + bytes(20), "begins like Ogg"), (bytes(4) + b"ftypisom", "MP4"), (b"RIFF" + bytes(20), "WAVE"),
     (b"ID3\x03", "ffmpeg -i IN -f wav")],
)  # fmt: skip
def test_compressed_sound_is_refused_with_what_to_do(head: bytes, told: str) -> None:
    with pytest.raises(InputError, match=told):
        StreamedSound(PcmForm()).push(head)


def test_forms_out_of_range() -> None:
    with pytest.raises(InputError, match="did you mean 's16le'"):
        PcmForm(format="s16")
    with pytest.raises(InputError, match="sample rate"):
        PcmForm(rate=10)
    with pytest.raises(InputError, match="channels"):
        PcmForm(channels=0)


@pytest.mark.parametrize("rate", [8000, 11025, 44100, 48000, 96000])
def test_resampling_in_pieces_agrees_with_soxr_on_the_whole(rate: int) -> None:
    random = np.random.default_rng(2)
    sound = soxr.resample(random.normal(0, 0.1, 8000), 6000, rate)  # nothing above 3 kHz
    resampler = StreamResampler(rate, 16000)
    places = np.sort(random.integers(0, len(sound), 40))
    found = np.concatenate([resampler.push(piece) for piece in np.split(sound, places)])
    wanted = soxr.resample(sound, rate, 16000)[: len(found)]
    assert len(found) >= len(sound) / rate * 16000 - 0.0025 * 16000
    inside = slice(100, -100)
    assert np.abs(found[inside] - wanted[inside]).max() < 2e-3


def test_an_inbox_never_holds_more_than_its_room() -> None:
    inbox = Inbox(seconds=0.1)
    for number in range(100):
        inbox.put(np.full(160, number, np.float32))
    assert len(inbox) == 1600
    assert inbox.dropped == 100 * 160 - 1600
    taken = inbox.take()
    assert (taken[0], taken[-1], len(inbox)) == (90, 99, 0)


def test_what_is_taken_in_part_leaves_the_rest_and_a_writer_waits_for_room() -> None:
    inbox = Inbox(seconds=0.1)
    written: list[int] = []

    def write() -> None:
        for number in range(20):
            inbox.put_when_room(np.full(400, number, np.float32))
            written.append(number)
        inbox.end()

    thread = threading.Thread(target=write)
    thread.start()
    found = []
    while not inbox.over:
        found.append(inbox.take(300))
        assert len(inbox) <= 1600
    thread.join()
    np.testing.assert_array_equal(np.concatenate(found), np.repeat(np.arange(20), 400))


def test_a_problem_of_the_reader_is_raised_after_the_sound_before_it() -> None:
    inbox = Inbox()
    inbox.put(np.ones(10, np.float32))
    inbox.end(InputError("gone"))
    assert len(inbox.take()) == 10
    assert not inbox.over
    inbox.put(np.ones(3, np.float32))
    assert len(inbox.take(0)) == 0  # there is something left before it
    assert len(inbox.take()) == 3
    with pytest.raises(InputError, match="gone"):
        inbox.take()
    assert inbox.over
