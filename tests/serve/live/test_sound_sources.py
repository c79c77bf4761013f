"""Pipes, growing files and microphones: what was written is heard, and what cannot be heard is told in one line."""

from __future__ import annotations

import os
import sys
import threading
import time
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from mien.core.audio import Audio
from mien.core.errors import InputError, MissingPartError
from mien.serve.live.sound_sources import MicrophoneSource, SampleSource, StreamSource, microphones, open_source
from mien.serve.live.sound_stream import PcmForm
from mien.speech.streaming_features import RATE

WAVE = (0.3 * np.sin(2 * np.pi * 200 * np.arange(RATE) / RATE)).astype(np.float32)
DATA = np.round(WAVE * 2**15).astype("<i2").tobytes()
PATIENCE = 20.0


def all_of(source: Any) -> np.ndarray:
    """Everything that a source gives until its end."""
    source.start()
    found, end = [], time.monotonic() + PATIENCE
    while not source.inbox.over and time.monotonic() < end:
        found.append(source.inbox.take())
        time.sleep(0.002)
    source.stop()
    return np.concatenate(found)


def piped(data: bytes, **options: Any) -> StreamSource:
    reader, writer = os.pipe()

    def write() -> None:
        with os.fdopen(writer, "wb") as file:
            file.write(data)

    threading.Thread(target=write, daemon=True).start()
    return StreamSource(lambda: reader, "pipe", options.pop("raw", PcmForm()), **options)


def test_what_goes_into_a_pipe_is_heard() -> None:
    source = piped(DATA)
    np.testing.assert_allclose(all_of(source), WAVE, atol=1e-4)
    assert source.stored  # it came at once: nobody speaks so fast


def test_a_long_sound_that_comes_at_once_is_stored_and_one_that_waited_in_the_pipe_is_not() -> None:
    source = piped(DATA * 12)
    assert len(all_of(source)) == 12 * len(WAVE)
    assert source.stored
    reader, writer = os.pipe()
    os.write(writer, DATA)  # a second of sound that waited while the program started
    waiting = StreamSource(lambda: reader, "pipe", PcmForm())
    waiting.start()
    end = time.monotonic() + PATIENCE
    while not waiting.inbox.arrived and time.monotonic() < end:
        time.sleep(0.01)
    assert not waiting.stored
    os.close(writer)
    waiting.stop()


def test_a_file_that_grows_is_followed(tmp_path: Path) -> None:
    path = tmp_path / "growing.raw"
    path.write_bytes(DATA[:8000])
    source = open_source(str(path), PcmForm(), follow=True)
    source.start()
    heard, end = 0, time.monotonic() + PATIENCE
    while heard < 4000 and time.monotonic() < end:
        heard += len(source.inbox.take())
    with path.open("ab") as file:
        file.write(DATA[8000:])
    while heard < RATE and time.monotonic() < end:
        heard += len(source.inbox.take())
        time.sleep(0.002)
    assert heard == RATE
    assert not source.inbox.over
    source.stop()
    assert source.inbox.over


def test_a_named_pipe(tmp_path: Path) -> None:
    path = tmp_path / "pipe"
    os.mkfifo(path)
    threading.Thread(target=lambda: path.write_bytes(DATA), daemon=True).start()
    np.testing.assert_allclose(all_of(open_source(str(path), PcmForm())), WAVE, atol=1e-4)


def test_a_sound_file_is_shown_whole_whatever_its_form(tmp_path: Path) -> None:
    path = tmp_path / "sound.flac"
    Audio(WAVE, RATE).write(path)
    source = open_source(str(path), PcmForm())
    assert isinstance(source, SampleSource)
    np.testing.assert_allclose(all_of(source), WAVE, atol=1e-4)


def test_what_is_no_sound_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file or pipe"):
        open_source(str(tmp_path / "none.wav"), PcmForm())
    with pytest.raises(InputError, match="got a folder"):
        open_source(str(tmp_path), PcmForm())
    with pytest.raises(InputError, match="pipe: no sound came"):
        all_of(piped(b""))
    with pytest.raises(InputError, match="pipe: the stream begins like Ogg"):
        all_of(piped(b"OggS" + bytes(100)))

    def fails() -> int:
        raise PermissionError(13, "Permission denied")

    with pytest.raises(InputError, match="shut cannot be read: Permission denied"):
        all_of(StreamSource(fails, "shut", PcmForm()))


class FakeStream:
    """PortAudio's stream: calls back when told to."""

    opened: FakeStream

    def __init__(self, callback: Any, **settings: Any) -> None:
        self.callback, self.settings, self.closed = callback, settings, False
        FakeStream.opened = self

    def start(self) -> None:
        for block in np.split(np.tile(WAVE, 3)[: 100 * 480], 100):
            self.callback(block[:, None], len(block), None, SimpleNamespace(input_overflow=False))

    def close(self) -> None:
        self.closed = True


def fake_sounddevice(monkeypatch: pytest.MonkeyPatch, **changes: Any) -> None:
    class PortAudioError(Exception):
        pass

    def query(device: Any = None, kind: Any = None) -> Any:
        known = [{"name": "Built-in", "max_input_channels": 2, "default_samplerate": 48000.0},
                 {"name": "Speaker", "max_input_channels": 0, "default_samplerate": 48000.0}]  # fmt: skip
        if kind is None:
            return known
        if device not in (None, 0, "Built-in"):
            raise ValueError(f"No input device matching {device!r}")
        return known[0]

    module = ModuleType("sounddevice")
    facts = {"PortAudioError": PortAudioError, "query_devices": query, "InputStream": FakeStream} | changes
    for name, value in facts.items():
        setattr(module, name, value)
    monkeypatch.setitem(sys.modules, "sounddevice", module)


def test_a_microphone_gives_its_sound_at_16_khz(monkeypatch: pytest.MonkeyPatch) -> None:
    fake_sounddevice(monkeypatch)
    source = MicrophoneSource()
    assert (source.name, source.stored) == ("Built-in", False)
    source.start()
    heard = source.inbox.take()
    assert len(heard) == pytest.approx(RATE, abs=60)  # a second at 48 kHz
    assert np.abs(heard).max() == pytest.approx(0.3, abs=0.02)
    source.stop()
    assert FakeStream.opened.closed
    assert microphones() == ["0: Built-in"]


def test_without_a_microphone_it_is_told_what_else_there_is(monkeypatch: pytest.MonkeyPatch) -> None:
    fake_sounddevice(monkeypatch)
    with pytest.raises(MissingPartError, match=r"there is no microphone 'webcam'.*--list-devices"):
        MicrophoneSource("webcam")
    monkeypatch.setitem(sys.modules, "sounddevice", None)
    with pytest.raises(MissingPartError, match=r"pip install 'mien\[live\]'"):
        MicrophoneSource()


def test_a_microphone_that_is_in_use_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    class Busy(FakeStream):
        def start(self) -> None:
            raise sys.modules["sounddevice"].PortAudioError("Device unavailable")

    fake_sounddevice(monkeypatch, InputStream=Busy)
    with pytest.raises(MissingPartError, match="'Built-in' cannot be opened: Device unavailable"):
        MicrophoneSource().start()
