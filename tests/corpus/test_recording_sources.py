"""Where takes come from: prepared files, and devices as far as a machine without any can tell."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import av
import numpy as np
import pytest

from mien.capture.layouts import load_layout
from mien.core.audio import Audio
from mien.core.errors import InputError, MissingPartError, OutputError
from mien.corpus.importing import import_corpus
from mien.corpus.readers.video_recordings import steady_frames
from mien.corpus.recording import devices
from mien.corpus.recording import devices as module
from mien.corpus.recording.devices import CameraDevice, Devices, MicrophoneDevice, open_devices
from mien.corpus.recording.folder import SessionFolder
from mien.corpus.recording.levels import level_notes, measure_levels
from mien.corpus.recording.scripts import Line
from mien.corpus.recording.session import Plan, Session, SessionReport
from mien.corpus.recording.sources import PreparedFolder
from mien.formats.sound_files import read_audio
from tests.corpus import recordings as made
from tests.corpus.test_recording import Keys, speech

LINES = [Line(1, "Bin ma."), Line(2, "Bin ma ma.")]


def video(path: Path, frames: int = 25, sound: bool = False) -> Path:
    with av.open(str(path), "w") as target:
        stream = target.add_stream("mpeg4", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        track = target.add_stream("aac", rate=16_000) if sound else None
        for number in range(frames):
            picture = av.VideoFrame.from_ndarray(np.full((48, 64, 3), number * 8, np.uint8), "rgb24")
            target.mux(stream.encode(picture))
        target.mux(stream.encode())
        if track is not None:
            frame = av.AudioFrame.from_ndarray(speech().samples[None], "fltp", "mono")
            frame.sample_rate = 16_000
            target.mux(track.encode(frame))
            target.mux(track.encode())
    return path


def prepared(folder: Path, out: Path, lines: list[Line] = LINES) -> SessionReport:
    return Session(Plan(lines, "mine", "anna"), SessionFolder(out), PreparedFolder(folder), Keys()).run()


def test_prepared_files_by_number_or_name(tmp_path: Path) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    video(folder / "001.mp4", sound=True)
    speech().write(folder / "anna-neutral-mine-002.wav")
    report = prepared(folder, tmp_path / "out")
    assert report.recorded == ["anna-neutral-mine-001", "anna-neutral-mine-002"]
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == [
        "anna-neutral-mine-001.mp4",
        "anna-neutral-mine-002.wav",
        "table.csv",
    ]
    assert (tmp_path / "out" / "anna-neutral-mine-001.mp4").read_bytes() == (folder / "001.mp4").read_bytes()
    assert prepared(folder, tmp_path / "out").recorded == []


def test_one_bad_file_never_stops_the_others(tmp_path: Path) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    (folder / "1.mp4").write_bytes(b"this is no video")
    speech().write(folder / "3.wav")
    report = prepared(folder, tmp_path / "out", [*LINES, Line(3, "Ma.")])
    assert report.recorded == ["anna-neutral-mine-003"]
    assert [(line.number, reason) for line, reason in report.failed] == [
        (1, f"{folder}/1.mp4: expected a sound or video file, got something that no decoder knows"),
        (2, f"{folder}: no recording of sentence 2; name it 002.mp4"),
    ]
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["anna-neutral-mine-003.wav", "table.csv"]


def test_prepared_files_that_cannot_be_told_apart_or_used(tmp_path: Path) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    video(folder / "1.mp4")  # without sound
    speech().write(folder / "2.wav")
    speech().write(folder / "02.wav")
    reasons = [reason for _, reason in prepared(folder, tmp_path / "out").failed]
    assert "without a sound track" in reasons[0]
    assert "sentence 2 is in" in reasons[1]
    speech().write(folder / "1.wav")
    (folder / "1.mp4").write_bytes((folder / "1.mp4").read_bytes()[:200])
    assert "1.mp4: expected a video" in prepared(folder, tmp_path / "out").failed[0][1]


def test_a_folder_without_recordings(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"found none"):
        PreparedFolder(tmp_path)
    with pytest.raises(InputError, match=r"expected a folder of recordings named 001\.mp4"):
        PreparedFolder(tmp_path / "nowhere")


def test_a_session_is_imported_as_it_is(tmp_path: Path) -> None:
    folder = tmp_path / "in"
    for name in ("001", "002"):
        made.write_npz(folder, name)
        made.write_speech(folder, name)
    report = prepared(folder, tmp_path / "session")
    assert not report.without_motion
    for name in report.recorded:  # words and phones stand beside, so that nothing has to be aligned
        grid = (folder / f"{name[-3:]}.TextGrid").read_bytes()
        (tmp_path / "session" / f"{name}.TextGrid").write_bytes(grid)
    imported = import_corpus(tmp_path / "session", tmp_path / "corpus", workers=0)
    assert imported.failed == ()
    assert imported.imported == ("anna-neutral-mine-001", "anna-neutral-mine-002")
    take = imported.corpus.take("anna-neutral-mine-002")
    assert (take.speaker, take.emotion, take.sentence) == ("anna", "neutral", "mine-002")


@pytest.mark.data
def test_grid_clips_as_prepared_videos(shared_data: Path, tmp_path: Path) -> None:
    clips = sorted((shared_data / "grid-s1" / "video").glob("*.mpg"))[:2]
    folder = tmp_path / "in"
    folder.mkdir()
    for number, clip in enumerate(clips, start=1):
        (folder / f"{number:03d}.mpg").write_bytes(clip.read_bytes())
    report = prepared(folder, tmp_path / "session")
    assert report.failed == []
    assert len(report.recorded) == 2
    assert not report.without_motion
    from mien.corpus.readers import detect
    from mien.corpus.transcripts import own_table, read_table

    session = tmp_path / "session"
    assert detect(session).name == "video"
    found = detect(session).find(session)
    table = own_table(session)
    assert table is not None
    assert {recording.name for recording in found} == set(read_table(table)[0])


@pytest.mark.data
def test_grid_takes_become_a_session_and_a_corpus(shared_data: Path, tmp_path: Path) -> None:
    """Real sound, really aligned, with the text that the session wrote down."""
    grid, layout, folder = shared_data / "grid-s1", load_layout("mediapipe-218"), tmp_path / "in"
    about = json.loads((grid / "meta.json").read_text(encoding="utf-8"))
    folder.mkdir()
    names = [layout.landmarks[int(number)] for number in about["landmark_ids"]]
    with np.load(grid / "markers.npz") as takes:
        positions = takes["bbaz5s"] / about["position_scale"]
    np.savez(folder / "1.npz", markers=positions, names=np.array(names), fps=25, units="pixels")
    (folder / "1.flac").write_bytes((grid / "audio" / "bbaz5s.flac").read_bytes())
    report = prepared(folder, tmp_path / "session", [Line(1, "Bin blue at Z five soon.")])
    assert (report.failed, report.without_motion, report.notes) == ([], False, [])
    imported = import_corpus(tmp_path / "session", tmp_path / "corpus", workers=0)
    assert imported.failed == ()
    take = imported.corpus.take(report.recorded[0])
    assert [word.label for word in take.words] == ["bin", "blue", "at", "z", "five", "soon"]
    assert take.sentence == "mine-001"


# ---- Levels ---------------------------------------------------------------------------------------------------------


def test_levels_of_known_sounds() -> None:
    assert level_notes(measure_levels(speech())) == ()
    rest, tone = np.zeros(3200), np.sin(np.arange(8000) * 0.2)
    loud = measure_levels(Audio(np.concatenate([rest, 1.5 * tone, rest]), 16_000))
    assert loud.clipped == pytest.approx(8000 * 0.2 / np.pi, rel=0.02)  # both halves of every swing
    assert "too loud" in level_notes(loud)[0].message
    assert "silent" in level_notes(measure_levels(Audio(np.zeros(16_000), 16_000)))[0].message
    cut = level_notes(measure_levels(Audio(0.3 * tone, 16_000)))
    click = np.concatenate([[0.5] * 100, rest, 0.3 * tone, rest])  # at the very start; it is no speech
    assert level_notes(measure_levels(Audio(click, 16_000))) == ()
    assert ["begins with" in cut[0].message, "goes on to the end" in cut[1].message] == [True, True]


# ---- Devices --------------------------------------------------------------------------------------------------------


class FakeMicrophone:
    def __init__(self) -> None:
        self.running = False

    def start(self) -> None:
        self.running = True

    def stop(self) -> tuple[float, Audio]:
        self.running = False
        return 10.0, speech()


class FakeCamera:
    def __init__(self, first: float) -> None:
        self.first, self.running = first, False

    def start(self, path: Path) -> None:
        self.running = True
        video(path)

    def stop(self) -> float:
        self.running = False
        return self.first


@pytest.mark.parametrize("late", [0.125, 0.0, -0.125])
def test_sound_and_pictures_begin_at_the_same_instant(tmp_path: Path, late: float) -> None:
    files = Devices(FakeMicrophone(), FakeCamera(10.0 + late)).take(LINES[0], "a", tmp_path, lambda: None)
    assert [path.name for path in files] == ["a.wav", "a.mp4"]
    samples = read_audio(files[0])[0].samples
    onset = int(np.flatnonzero(samples)[0]) / 16_000
    assert onset == pytest.approx(0.2 - late, abs=2e-4)


def test_sound_that_cannot_be_written_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"cannot write .*a\.wav: .*Is the disk full\?") as caught:
        Devices(FakeMicrophone(), None).take(LINES[0], "a", tmp_path / "gone", lambda: None)
    assert "\n" not in str(caught.value)


def test_interrupted_both_devices_stop(tmp_path: Path) -> None:
    microphone, camera = FakeMicrophone(), FakeCamera(10.0)

    def interrupted() -> None:
        assert microphone.running
        assert camera.running
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        Devices(microphone, camera).take(LINES[0], "a", tmp_path, interrupted)
    assert not microphone.running
    assert not camera.running


def fake_sounddevice(monkeypatch: pytest.MonkeyPatch, problem: Exception | None = None, mute: bool = False) -> None:
    class Stream:
        def __init__(self, samplerate: int, channels: int, callback: Any) -> None:
            self._callback, self.channels, self.samplerate = callback, channels, samplerate

        def start(self) -> None:
            for value in () if mute else (0.25, 0.5):
                self._callback(np.full((480, self.channels), value, np.float32), 480, None, None)

        def stop(self) -> None: ...

        def close(self) -> None: ...

    def check(samplerate: int, channels: int) -> None:
        if problem is not None:
            raise problem

    library = ModuleType("sounddevice")
    vars(library).update(InputStream=Stream, PortAudioError=OSError, check_input_settings=check)
    monkeypatch.setitem(sys.modules, "sounddevice", library)


def test_microphone_joins_its_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    fake_sounddevice(monkeypatch)
    monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: 7.0))
    microphone = MicrophoneDevice()
    for _ in range(2):  # a second take does not hold the first
        microphone.start()
        began, audio = microphone.stop()
        assert began == pytest.approx(6.99)
        assert audio == Audio(np.repeat([0.25, 0.5], 480), 48_000)


def test_no_sound_and_no_microphone(monkeypatch: pytest.MonkeyPatch) -> None:
    fake_sounddevice(monkeypatch, mute=True)
    microphone = MicrophoneDevice()
    microphone.start()
    with pytest.raises(InputError, match="is it muted, or unplugged"):
        microphone.stop()
    fake_sounddevice(monkeypatch, OSError("Error querying device -1"))
    with pytest.raises(MissingPartError, match=r"no microphone .*querying device -1.* --from FOLDER"):
        MicrophoneDevice()
    monkeypatch.setitem(sys.modules, "sounddevice", None)
    with pytest.raises(MissingPartError, match="pip install sounddevice"):
        open_devices(None)


def test_camera_that_is_not_there(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    fake_sounddevice(monkeypatch)
    with pytest.raises(MissingPartError, match=r"nocamera cannot be opened .*--camera, or --no-camera"):
        open_devices(str(tmp_path / "nocamera"))
    assert open_devices(None, wants_camera=False)[1] == ()


def test_camera_writes_pictures_with_their_times(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    played = video(tmp_path / "played.mp4", frames=30)
    camera = CameraDevice(str(played), format=None)
    camera.check()
    ticks = iter(np.arange(1000) * 0.05 + 3.0)  # a camera of 20 frames per second
    monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: float(next(ticks))))
    camera.start(tmp_path / "out.mp4")
    assert camera._thread is not None
    camera._thread.join(60)  # to the end of what is played
    assert camera.stop() == 3.0
    with av.open(str(tmp_path / "out.mp4")) as container:
        times = [float(frame.time or 0.0) for frame in container.decode(video=0)]
    assert np.allclose(times, np.arange(30) * 0.05, atol=1e-3)
    rate, _, frames = steady_frames(tmp_path / "out.mp4")
    assert rate.fps == pytest.approx(20, rel=0.05)
    assert sum(1 for _ in frames) == pytest.approx(30, abs=1)


def test_camera_without_a_picture(tmp_path: Path) -> None:
    speech().write(tmp_path / "sound.wav")
    with pytest.raises(MissingPartError, match="gives no pictures"):
        CameraDevice(str(tmp_path / "sound.wav"), format=None).check()
    with pytest.raises(InputError, match="gave no picture"):
        CameraDevice("never started").stop()


def test_camera_that_breaks_off(tmp_path: Path) -> None:
    played = video(tmp_path / "played.mp4")
    camera = CameraDevice(str(played), format=None)
    camera.start(tmp_path / "nowhere" / "out.mp4")
    with pytest.raises(InputError, match=r"broke off \(.*No such file"):
        camera.stop()


@pytest.mark.parametrize(("system", "name"), [("darwin", "0"), ("win32", "video=0")])
def test_cameras_of_other_systems_are_found_and_named_as_ffmpeg_wants_them(monkeypatch, system, name) -> None:
    import av

    asked = []
    cameras = [SimpleNamespace(name="mic", media_types=["audio"]), SimpleNamespace(name="0", media_types=["video"])]
    monkeypatch.setattr(av, "enumerate_input_devices", lambda kind: asked.append(kind) or cameras)
    monkeypatch.setattr(devices.sys, "platform", system)
    assert devices._first_camera() == name
    assert asked == [{"darwin": "avfoundation", "win32": "dshow"}[system]]
