"""Warm light is told by the whites of the eyes, a lamp at one side by the cheeks; lids are not taken for whites."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image, ImageDraw

from mien.face.head_space import head_space
from mien.fit.photo_white import balanced, colour_of_light, lamp_note, light_note
from tests.fit.test_photos import camera


def picture_of(light, white=(0.6, 0.55, 0.51), side=1.0):
    """A flat face with white eyes, in light of some colour, and brighter by a factor on the person's left."""
    space, at = head_space(), camera(0.0)
    colours = np.empty((at.height, at.width, 3))
    colours[:] = (0.4, 0.27, 0.2)
    eyes = Image.new("1", (at.width, at.height))
    for loop in (space.lid_loop_left, space.lid_loop_right):
        ImageDraw.Draw(eyes).polygon([tuple(p) for p in at.seen(space.rest[loop])[0]], fill=1)
    colours[np.asarray(eyes, bool)] = white
    left = at.seen(np.array([[30.0, -30.0, 30.0]]))[0][0, 0] > at.width / 2
    colours[:, slice(at.width // 2, None) if left else slice(0, at.width // 2)] *= side
    value = np.clip(colours * light, 0, 1)
    return np.rint(255 * np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)).astype("u1")


def irises():
    return tuple(np.array([*np.add(eye.centre, (0, 0, 11.0)), 5.0]) for eye in head_space().face.eyes)


@pytest.mark.parametrize("light", [(1.0, 1.0, 1.0), (1.3, 1.0, 0.55), (0.8, 1.0, 1.3)])
def test_the_colour_of_the_light_is_found_and_taken_out(light) -> None:
    space = head_space()
    picture = picture_of(light)
    found = colour_of_light(space, space.rest, picture, camera(0.0), irises())
    assert found is not None
    assert np.abs(np.log(found / np.array(light))).max() < 0.08
    told = light_note("a.png", found)
    assert (told is None) is (light == (1.0, 1.0, 1.0))
    plain = balanced(picture, found)[20, 20].astype(int)
    assert np.ptp(plain / picture_of((1, 1, 1))[20, 20]) < 0.06  # the colour of the skin, up to exposure


def test_lids_are_no_whites() -> None:
    space = head_space()
    picture = picture_of((1.3, 1.0, 0.55), white=(0.4, 0.28, 0.21))
    assert colour_of_light(space, space.rest, picture, camera(0.0), irises()) is None


def test_a_lamp_at_one_side_is_reported() -> None:
    space = head_space()
    assert lamp_note(space, space.rest, picture_of((1, 1, 1)), camera(0.0), "a") is None
    told = lamp_note(space, space.rest, picture_of((0.5, 0.5, 0.5), side=2.0), camera(0.0), "a")
    assert told is not None
    assert "left cheek is 2.0 times" in told.message
