"""Moving pictures and numbered ones: times, transparency, names."""

from __future__ import annotations

import errno
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from mien.core.errors import InputError, OutputError
from mien.core.timeline import FrameRate
from mien.face.render.view import View
from mien.formats.picture_files import _in_256_colours, frame_files
from mien.formats.registry import check_output, save
from tests.faces import tiny_animation, tiny_face

SMALL = View(48, 32)


def frames_of(path) -> list[tuple[np.ndarray, int]]:
    """Each picture as RGBA, and the milliseconds that it stays."""
    found = []
    with Image.open(path) as moving:
        for number in range(moving.n_frames):
            moving.seek(number)
            found.append((np.asarray(moving.convert("RGBA")), moving.info["duration"]))
    return found


@pytest.mark.parametrize("fps", [25, 30])
def test_a_gif_lasts_as_long_as_the_animation(tmp_path, fps):
    animation = tiny_animation(fps, FrameRate.of(fps))
    assert save(animation, tmp_path / "a.gif", face=tiny_face(), view=SMALL) == ()
    frames = frames_of(tmp_path / "a.gif")
    assert sum(stays for _, stays in frames) == 1000
    assert {stays for _, stays in frames} <= ({40, 80} if fps == 25 else {30, 40, 60, 70, 100})


def test_a_gif_of_many_frames_a_second_leaves_some_out_and_says_so(tmp_path):
    (note,) = save(tiny_animation(120, FrameRate.of(120)), tmp_path / "a.gif", face=tiny_face(), view=SMALL)
    assert "every 3 frames one" in note.message
    assert sum(stays for _, stays in frames_of(tmp_path / "a.gif")) == 1000


def test_few_pixels_keep_their_colour_in_a_gif():
    down, right = np.mgrid[0:600, 0:600] / 600
    picture = np.stack([200 + 40 * right, 150 + 50 * down, 130 + 40 * right * down], axis=2)  # many shades of skin
    picture[:200] = np.stack([90 + 60 * right, 100 + 60 * right, 110 + 60 * down], axis=2)[:200]  # and of the ground
    lips = np.stack([140 + 800 * right, 40 + 600 * right, 50 + 800 * down], axis=2)[:6, :30]
    picture[300:306, 300:330] = lips
    shown = np.asarray(_in_256_colours(picture.astype(np.uint8)).convert("RGB")).astype(int)
    assert np.abs(shown[300:306, 300:330] - lips).mean() < 8
    assert np.abs(shown - picture).mean() < 3


def test_a_transparent_gif_shows_nothing_behind_the_face_in_any_frame(tmp_path):
    save(tiny_animation(4), tmp_path / "a.gif", face=tiny_face(), view=replace(SMALL, background="transparent"))
    for picture, _ in frames_of(tmp_path / "a.gif"):
        assert picture[0, 0, 3] == 0
        assert picture[16, 24, 3] == 255


def test_frames_are_numbered_from_0_and_older_ones_are_mentioned(tmp_path):
    (tmp_path / "line003.png").write_bytes(b"older")
    view = replace(SMALL, background="transparent")
    (note,) = save(tiny_animation(3), tmp_path / "line%03d.png", face=tiny_face(), view=view)
    assert "line003.png and what may follow it are of an earlier run" in note.message
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"line00{n}.png" for n in range(4)]
    with Image.open(tmp_path / "line002.png") as picture:
        assert (picture.mode, picture.size) == ("RGBA", (48, 32))


def test_a_stopped_run_leaves_no_frames(tmp_path):
    def stop(done: int, _: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        save(tiny_animation(4), tmp_path / "a%05d.png", face=tiny_face(), view=SMALL, progress=stop)
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_is_one_line_and_leaves_no_frames(tmp_path, monkeypatch):
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Image.Image, "save", full)
    with pytest.raises(OutputError, match=r"a%05d\.png: the disk is full"):
        save(tiny_animation(3), tmp_path / "a%05d.png", face=tiny_face(), view=SMALL)
    assert list(tmp_path.iterdir()) == []


def test_names_that_stand_for_no_frames_are_refused_before_work(tmp_path):
    for name in ("a%05d-%02d.png", "a%012d.png"):
        with pytest.raises(InputError, match="number"):
            check_output(tmp_path / name, View())
    assert check_output(tmp_path / "100%s.png", View())  # a name like any other
    with pytest.raises(InputError, match="lies on paper"):
        check_output(tmp_path / "a.png", View(background="transparent"))
    assert [path.name for path in frame_files("a%d.png", 11)][9:] == ["a9.png", "a10.png"]
