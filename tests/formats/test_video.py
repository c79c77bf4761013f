"""MP4 files, read back with another decoder than wrote them where that matters: times, sound, colours, failures."""

from __future__ import annotations

import resource
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from mien.core.audio import Audio
from mien.core.errors import InputError, OutputError
from mien.core.timeline import FrameRate
from mien.face.render.view import View
from mien.formats.video import check_film, luma_and_chroma, write_frames, write_video
from tests.faces import tiny_animation, tiny_face

SIZE = (64, 48)


def decode(path: Path, **options: str):
    """Times (s) and pictures of the video; the sound, with silence where the file says that it starts later."""
    with av.open(str(path), options=options) as container:
        frames = [(f.time, f.to_ndarray(format="gray")) for f in container.decode(video=0)]
    with av.open(str(path), options=options) as container:
        blocks = [(f.time, f.to_ndarray()[0]) for f in container.decode(audio=0)]
        rate = container.streams.audio[0].rate
    end = max(round(time * rate) + len(block) for time, block in blocks)
    sound = np.zeros(end)
    for time, block in blocks:
        first = round(time * rate)
        sound[max(first, 0) : first + len(block)] = block[max(-first, 0) :]
    return frames, sound, rate


def flash_and_click(fps: Fraction, seconds: float, at: float, rate: int):
    """Black pictures but one, and silence but for a click, both at one time."""
    frames = round(seconds * fps)
    lit = round(at * fps)
    pictures = [np.full((SIZE[1], SIZE[0], 3), 235 if n == lit else 16, np.uint8) for n in range(frames)]
    samples = np.zeros(round(seconds * rate))
    samples[round(at * rate) :][: rate // 100] = 0.8 * np.hanning(rate // 100)
    return pictures, Audio(samples, rate)


@pytest.mark.parametrize("rate", [8000, 22050, 48000, 96000, 11111])
@pytest.mark.parametrize("fps", [Fraction(25), Fraction(30000, 1001)])
def test_a_click_is_heard_when_its_flash_is_seen(tmp_path, rate, fps):
    at = float(30 / fps)
    pictures, sound = flash_and_click(fps, float(60 / fps), at, rate)
    notes = write_frames(iter(pictures), fps, sound, tmp_path / "a.mp4", SIZE)
    frames, heard, heard_rate = decode(tmp_path / "a.mp4")
    assert len(frames) == 60
    brightest = max(frames, key=lambda item: item[1].mean())
    assert brightest[0] == pytest.approx(at, abs=1e-4)
    assert heard_rate == 48000
    assert notes == ()
    middle = float((np.arange(len(heard)) * heard**2).sum() / (heard**2).sum()) / heard_rate
    assert middle == pytest.approx(at + 0.005, abs=0.003)


@pytest.mark.parametrize("fps", ["24", "25", "30000/1001", "30", "50", "60"])
def test_players_that_ignore_edit_lists_are_off_by_the_sound_encoders_block_alone(tmp_path, fps):
    """No picture is out of order, so only AAC's 1024 samples (21 ms at 48 kHz) are left; with the list, nothing."""
    fps = Fraction(fps)
    at = float(30 / fps)
    pictures, sound = flash_and_click(fps, float(60 / fps), at, 24000)
    write_frames(iter(pictures), fps, sound, tmp_path / "a.mp4", SIZE)
    for options, late, allowed in (({}, 0.0, 0.001), ({"ignore_editlist": "1"}, 1024 / 48000, 0.0015)):
        frames, heard, rate = decode(tmp_path / "a.mp4", **options)
        seen = max(frames, key=lambda item: item[1].mean())[0] - frames[0][0]
        middle = float((np.arange(len(heard)) * heard**2).sum() / (heard**2).sum()) / rate
        assert middle - seen == pytest.approx(0.005 + late, abs=allowed), options
        assert frames[0][0] == 0.0
        assert [frame[0] for frame in frames] == sorted(frame[0] for frame in frames)


def test_the_picture_is_as_long_as_the_sound(tmp_path):
    animation = tiny_animation(13, FrameRate.of(25))
    write_video(animation, tiny_face(), tmp_path / "a.mp4", view=View(64, 64))
    with av.open(str(tmp_path / "a.mp4")) as container:
        video, sound = container.streams.video[0], container.streams.audio[0]
        assert float(video.duration * video.time_base) == pytest.approx(13 / 25, abs=1e-3)
        assert float(sound.duration * sound.time_base) == pytest.approx(13 / 25, abs=1 / 25)
        assert container.duration / av.time_base == pytest.approx(13 / 25, abs=1 / 25)
        assert (video.codec_context.name, video.codec_context.pix_fmt) == ("h264", "yuv420p")
        assert video.average_rate == 25
        context = video.codec_context
        assert (context.color_primaries, context.color_trc, context.colorspace, context.color_range) == (1, 1, 1, 1)
    content = (tmp_path / "a.mp4").read_bytes()
    assert content.index(b"moov") < content.index(b"mdat")  # can be played while it loads


def test_colours_are_those_of_bt709(tmp_path):
    red = np.zeros((48, 64, 3), np.uint8)
    red[:] = (255, 0, 0)
    write_frames(iter([red] * 3), Fraction(25), Audio.silence(0.12, 16000), tmp_path / "a.mp4", SIZE)
    with av.open(str(tmp_path / "a.mp4")) as container:
        planes = next(container.decode(video=0)).to_ndarray()
    luma, blue, red_difference = planes[:48].mean(), planes[48:60].mean(), planes[60:].mean()
    assert (luma, blue, red_difference) == pytest.approx((63, 102, 240), abs=2)


def test_the_same_animation_gives_the_same_bytes_and_progress_is_told(tmp_path):
    told = []
    for name in ("a.mp4", "b.mp4"):
        animation = tiny_animation(6)
        notes = write_video(
            animation, tiny_face(), tmp_path / name, view=View(64, 64), progress=lambda *done: told.append(done)
        )
        assert notes == ()
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()
    assert told[:6] == [(number, 6) for number in range(1, 7)]


def test_without_sound_there_is_no_sound_track(tmp_path):
    pictures = [np.zeros((48, 64, 3), np.uint8)] * 2
    write_frames(iter(pictures), Fraction(25), Audio([], 16000), tmp_path / "a.mp4", SIZE)
    with av.open(str(tmp_path / "a.mp4")) as container:
        assert [stream.type for stream in container.streams] == ["video"]


@pytest.mark.parametrize("size", [(65, 64), (64, 63)])
def test_odd_sides_are_refused_with_even_ones_to_take(tmp_path, size):
    with pytest.raises(InputError, match=r"even numbers of pixels, not .*; \d+ x \d+ would do"):
        write_video(tiny_animation(2), tiny_face(), tmp_path / "a.mp4", view=View(*size))
    assert list(tmp_path.iterdir()) == []


def test_nothing_to_show_and_wrong_names_are_refused(tmp_path):
    animation = tiny_animation(2)
    empty = replace(animation, channels=type(animation.channels)(("jawOpen",), np.zeros((0, 1)), animation.rate))
    with pytest.raises(InputError, match="no frames"):
        write_video(empty, tiny_face(), tmp_path / "a.mp4")
    with pytest.raises(OutputError, match=r"written as .mp4, .webm, .mov, not '\.avi'"):
        write_video(animation, tiny_face(), tmp_path / "a.avi")


@pytest.mark.parametrize("failure", [KeyboardInterrupt, MemoryError])
def test_an_interruption_leaves_what_was_there_and_nothing_else(tmp_path, failure):
    (tmp_path / "a.mp4").write_text("an older file")

    def stop(done: int, _: int) -> None:
        if done == 3:
            raise failure

    with pytest.raises(failure):
        write_video(tiny_animation(8), tiny_face(), tmp_path / "a.mp4", view=View(64, 64), progress=stop)
    assert [p.name for p in tmp_path.iterdir()] == ["a.mp4"]
    assert (tmp_path / "a.mp4").read_text() == "an older file"


def test_a_failing_encoder_stops_the_drawing(tmp_path):
    drawn = []

    def pictures():
        for number in range(500):
            drawn.append(number)
            yield np.zeros((48, 64, 5 if number > 2 else 3), np.uint8)  # five colours are one too many

    with pytest.raises(ValueError, match=r"shape|dimension|channel"):
        write_frames(pictures(), Fraction(25), Audio.silence(20, 8000), tmp_path / "a.mp4", SIZE)
    assert len(drawn) < 100
    assert list(tmp_path.iterdir()) == []


FULL_DISK = """
import resource, signal, sys
import numpy as np
from fractions import Fraction
from mien.core.audio import Audio
from mien.core.errors import OutputError
from mien.face.render.view import View
from mien.formats.video import write_frames
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (40_000, 40_000))
noise = np.random.default_rng(0).integers(0, 255, (40, 48, 64, 3), dtype=np.uint8)
try:
    write_frames(iter(noise), Fraction(25), Audio.silence(1.6, 16000), sys.argv[1], (64, 48))
except OutputError as problem:
    print(problem)
"""


@pytest.mark.skipif(not hasattr(resource, "RLIMIT_FSIZE"), reason="no limits on this system")
def test_a_file_that_cannot_grow_is_one_line_and_no_file(tmp_path):
    path = tmp_path / "a.mp4"
    result = subprocess.run([sys.executable, "-c", FULL_DISK, str(path)], capture_output=True, text=True, check=True)
    assert result.stdout.startswith(f"cannot write {path}: ")
    assert len(result.stdout.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("at", ["the last flush", "the first picture"])
def test_a_fault_of_the_encoder_is_raised_and_nothing_waits_for_ever(at: str) -> None:
    from threading import Thread

    from mien.formats import video as module

    class Full:
        """A stream whose encoder fails at one point, and the container that takes what comes before."""

        pix_fmt = "yuv420p"

        def encode(self, frame: object) -> list[object]:
            if (frame is None) == (at == "the last flush"):
                raise OSError("disk full")
            return []

        def mux(self, packets: object) -> None:
            pass

    raised: list[BaseException] = []

    def encode() -> None:
        pictures = iter([np.zeros((16, 16, 3), np.uint8)] * 40)
        try:
            module._encode(Full(), Full(), None, pictures, Fraction(25), Audio(np.zeros(0), 48_000))
        except OSError as problem:
            raised.append(problem)

    thread = Thread(target=encode, daemon=True)
    thread.start()
    thread.join(60)
    assert not thread.is_alive()
    assert [str(problem) for problem in raised] == ["disk full"]


@pytest.mark.parametrize(("suffix", "codec", "voice"), [(".webm", "vp9", "opus"), (".mov", "prores", "pcm_s24le")])
def test_other_kinds_hold_pictures_and_sound_in_step_and_the_same_bytes(tmp_path, suffix, codec, voice):
    pictures, sound = flash_and_click(Fraction(25), 2.4, 1.2, 22050)
    for name in ("a", "b"):
        notes = write_frames(iter(pictures), Fraction(25), sound, tmp_path / f"{name}{suffix}", SIZE)
    assert notes == ()
    with av.open(str(tmp_path / f"a{suffix}")) as container:
        assert [stream.codec.canonical_name for stream in container.streams] == [codec, voice]
        shown = [(frame.time, frame.to_ndarray(format="gray").mean()) for frame in container.decode(video=0)]
    assert len(shown) == 60
    assert max(shown, key=lambda item: item[1])[0] == pytest.approx(1.2, abs=1e-3)
    with av.open(str(tmp_path / f"a{suffix}")) as container:
        blocks = [(frame.time, frame.to_ndarray().astype(float)[0]) for frame in container.decode(audio=0)]
        rate = container.streams.audio[0].rate
    times = np.concatenate([time + np.arange(len(block)) / rate for time, block in blocks])
    heard = np.concatenate([block for _, block in blocks]) ** 2
    assert float((times * heard).sum() / heard.sum()) == pytest.approx(1.205, abs=0.008)
    assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


@pytest.mark.parametrize("suffix", [".webm", ".mov"])
def test_transparency_survives(tmp_path, suffix):
    picture = np.zeros((48, 64, 4), np.uint8)
    picture[:, 32:] = (200, 60, 40, 255)
    write_frames(iter([picture] * 3), Fraction(25), Audio([], 16000), tmp_path / f"a{suffix}", SIZE, transparent=True)
    with av.open(str(tmp_path / f"a{suffix}")) as container:
        stream = container.streams.video[0]
        if suffix == ".webm":  # FFmpeg's own decoder leaves the opacity out
            assert stream.metadata["alpha_mode"] == "1"
            decoder = av.CodecContext.create("libvpx-vp9", "r")
            frames = [frame for packet in container.demux(stream) for frame in decoder.decode(packet)]
        else:
            frames = list(container.decode(video=0))
    shown = frames[1].to_ndarray(format="rgba")
    assert shown[:, :28, 3].max() < 8
    assert shown[:, 36:, 3].min() > 247
    assert np.abs(shown[:, 40:, :3].astype(int) - (200, 60, 40)).max() < 12


def test_what_a_kind_cannot_hold_is_one_line():
    with pytest.raises(InputError, match=r"a\.mp4: \.mp4 holds no transparency; give \.webm"):
        check_film("a.mp4", View(background="transparent"))
    with pytest.raises(InputError, match="64 x 63; 64 x 64 would do"):
        check_film("a.webm", View(64, 63))
    check_film("a.mov", View(64, 63, background="transparent"))


def test_colours_become_luma_and_chroma_as_ffmpeg_makes_them():
    rng = np.random.default_rng(1)
    picture = np.repeat(np.repeat(rng.integers(0, 256, (3, 4, 3), np.uint8), 16, axis=0), 16, axis=1)
    planes = np.empty((72, 64), np.uint8)
    luma_and_chroma(picture, planes)
    other = av.VideoFrame.from_ndarray(picture, format="rgb24").reformat(
        format="yuv420p", dst_colorspace="ITU709", src_color_range="JPEG", dst_color_range="MPEG"
    )
    difference = np.abs(other.to_ndarray().astype(int) - planes)
    assert difference[:48].max() <= 1
    assert np.median(difference[48:]) <= 1  # its chroma is smoothed over more than four pixels


@pytest.mark.parametrize("suffix", [".mp4", ".webm"])
def test_compressed_sound_is_not_cut_off(tmp_path, suffix):
    at = np.arange(16000) / 16000
    loud = sum(np.cos(2 * np.pi * k * (110 + 20 * at) * at + k) / k for k in range(1, 40)) * np.sin(9 * at)
    loud *= 0.99 / np.abs(loud).max()
    write_frames(
        iter([np.zeros((48, 64, 3), np.uint8)] * 25),
        Fraction(25),
        Audio(loud, 16000),
        tmp_path / f"a{suffix}",
        (64, 48),
    )
    with av.open(str(tmp_path / f"a{suffix}")) as container:
        heard = np.concatenate([block.to_ndarray().ravel() for block in container.decode(audio=0)])
    assert 0.5 < np.abs(heard).max() < 0.94
