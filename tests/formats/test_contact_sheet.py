"""Contact sheets: which frames, laid out how."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from mien.core.errors import InputError, OutputError
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.formats.contact_sheet import contact_sheet, key_frames, write_contact_sheet
from tests.faces import tiny_animation, tiny_face
from tests.utterances import utterance


def animation(*phones: tuple[str, float]):
    speech = utterance(*phones)
    rate = FrameRate.of(25)
    track = ChannelTrack(("jawOpen",), np.zeros((rate.frames_covering(speech.duration), 1)), rate)
    return replace(tiny_animation(2), utterance=speech, channels=track)


def test_each_phone_is_shown_at_its_middle():
    frames = key_frames(animation(("SIL", 0.4), ("M", 0.16), ("AA", 0.24), ("SIL", 0.4), ("P", 0.08)))
    assert frames == [(5, "SIL"), (12, "M"), (17, "AA"), (31, "P")]


def test_a_long_line_is_thinned_evenly_and_silence_is_shown_through_time():
    long = key_frames(animation(*[("AA", 0.1), ("M", 0.1)] * 50))
    assert len(long) == 24
    gaps = np.diff([frame for frame, _ in long])
    assert gaps.max() - gaps.min() <= 3
    silent = key_frames(animation(("SIL", 4.0)), most=5)
    assert [frame for frame, _ in silent] == [0, 25, 50, 74, 99]
    assert key_frames(animation(("SIL", 0.02))) == [(0, "")]


def test_pictures_lie_in_rows_with_labels_below():
    colours = [(200, 0, 0), (0, 200, 0), (0, 0, 200)]
    images = [np.full((40, 60, 3), colour, np.uint8) for colour in colours]
    sheet = contact_sheet(images, ["first", "", "third"], columns=2)
    for colour, (x, y) in zip(colours, ((36, 26), (102, 26), (36, 92)), strict=True):
        assert tuple(sheet[y, x]) == colour
    labels = [sheet[46:72, 0:66], sheet[46:72, 72:132], sheet[112:, 0:66]]
    dark = [bool((label.sum(axis=2) < 300).any()) for label in labels]
    assert dark == [True, False, True]


def test_what_cannot_be_laid_out_is_refused():
    picture = np.zeros((4, 4, 3), np.uint8)
    for images, labels, columns in (([], [], 1), ([picture], [], 1), ([picture], ["a"], 0)):
        with pytest.raises(InputError, match="needs pictures"):
            contact_sheet(images, labels, columns)
    with pytest.raises(InputError, match="share one size"):
        contact_sheet([picture, picture[:2]], ["a", "b"], 2)


def test_a_sheet_is_written_whole(tmp_path):
    assert write_contact_sheet(tiny_animation(20), tiny_face(), tmp_path / "a.png") == ()
    with Image.open(tmp_path / "a.png") as sheet:
        assert sheet.mode == "RGB"
        assert sheet.width > 3 * 320
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]


def test_wrong_names_and_empty_animations_are_refused(tmp_path):
    with pytest.raises(OutputError, match=r"written as \.png"):
        write_contact_sheet(tiny_animation(3), tiny_face(), tmp_path / "a.jpg")
    empty = replace(tiny_animation(3), channels=ChannelTrack(("jawOpen",), np.zeros((0, 1)), FrameRate.of(25)))
    with pytest.raises(InputError, match="no frames"):
        write_contact_sheet(empty, tiny_face(), tmp_path / "a.png")
