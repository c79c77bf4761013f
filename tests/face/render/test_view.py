"""What pictures show: every option, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from mien.core.errors import InputError
from mien.face.model import Face
from mien.face.posing import Poser
from mien.face.render.view import View, background_colour, parse_size, with_options
from tests.faces import tiny_face

FACE = tiny_face()


def picture(face: Face = FACE, **options) -> np.ndarray:
    view = View(**{"width": 96, "height": 96, **options})
    shown = view.renderer(face).render(Poser(face, ("jawOpen",)).pose([0.0]))
    assert shown.shape[1::-1] == view.size
    return shown


@pytest.mark.parametrize("crop", ["", "oval", "0,0,48x48"])
@pytest.mark.parametrize("colour", ["#808080", "black", "#0b57d0"])
def test_a_background_comes_out_in_the_colour_that_was_asked_for(crop, colour):
    assert tuple(picture(crop=crop, background=colour)[0, 0]) == background_colour(colour)


def test_a_picture_behind_the_face_fills_the_frame(tmp_path):
    beach = np.zeros((40, 80, 3), np.uint8)
    beach[:, :40], beach[:, 40:] = (200, 30, 40), (20, 90, 220)
    Image.fromarray(beach).save(tmp_path / "beach.png")
    shown, plain = picture(background=str(tmp_path / "beach.png")), picture()
    assert tuple(shown[2, 2]) == (200, 30, 40)
    assert tuple(shown[2, 93]) == (20, 90, 220)
    assert np.abs(shown[48, 48].astype(int) - plain[48, 48]).max() <= 1


def test_a_transparent_picture_over_a_colour_is_the_picture_before_that_colour():
    clear, before = picture(background="transparent").astype(float), picture(background="#406080")
    assert clear.shape == (96, 96, 4)
    assert clear[0, 0].tolist() == [0, 0, 0, 0]
    share = clear[..., 3:] / 255
    linear = share * (clear[..., :3] / 255) ** 2.2 + (1 - share) * (np.array([0x40, 0x60, 0x80]) / 255) ** 2.2
    assert np.abs(255 * linear ** (1 / 2.2) - before).max() < 4


def test_an_oval_hides_all_that_lies_outside_it():
    shown = (picture(crop="oval", background="#808080") != 128).any(axis=2)
    assert not shown[[0, -1]].any()
    down, across = np.nonzero(shown)
    assert 1.2 < np.ptp(down) / np.ptp(across) < 1.6
    assert abs(across.mean() - 47.5) < 1.5  # upright and even
    clear = picture(crop="oval", background="transparent")
    np.testing.assert_array_equal((clear[..., 3] > 0)[30:60, 30:60], shown[30:60, 30:60])


def test_a_crop_is_a_piece_of_the_picture_and_qualities_show_the_same():
    whole = picture()
    np.testing.assert_array_equal(picture(crop="10,20,40x30"), whole[20:50, 10:50])
    best, draft = (picture(quality=name).astype(int) for name in ("best", "draft"))
    assert np.abs(best - whole).mean() < 3 < 12 > np.abs(draft - whole).mean()
    assert not np.array_equal(best, whole)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"size": "0x100"}, "at least one pixel"),
        ({"size": "100000x100000"}, "between 16 and 8192 pixels, not 100000 x 100000"),
        ({"size": "8x8"}, "between 16 and 8192"),
        ({"size": "-4x8"}, "WIDTHxHEIGHT"),
        ({"size": "big"}, "WIDTHxHEIGHT"),
        ({"size": "8192x8192", "quality": "best"}, "up to 4096"),
        ({"camera": "mouht"}, "did you mean 'mouth'"),
        ({"camera": "none.toml"}, "none.toml"),
        ({"light": "sofd"}, "did you mean 'soft'"),
        ({"background": "grayish"}, "there is no such colour, and no such file"),
        ({"background": __file__}, "test_view.py"),
        ({"crop": "round"}, "LEFT,TOP,WIDTHxHEIGHT"),
        ({"crop": "1200,0,640x720"}, "does not fit"),
        ({"quality": "fine"}, "unknown quality"),
    ],
)
def test_what_cannot_be_is_one_line(options, said):
    with pytest.raises(InputError, match=said) as problem:
        with_options(View(), options)
    assert "\n" not in str(problem.value)


def test_sizes_as_they_are_written():
    assert parse_size("1080x1920") == parse_size(" 1080 X 1920 ") == (1080, 1920)
    assert with_options(View(), {"size": "64x48", "camera": None}).size == (64, 48)
