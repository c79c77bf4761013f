from __future__ import annotations

import numpy as np
import pytest

from mien.api.stimuli.framing import CROPS, background_colour, framing
from mien.core.errors import InputError
from mien.face.library import load_face
from mien.face.posing import Poser


def picture(crop: str, background: str = "#808080") -> np.ndarray:
    face = load_face("default")
    poser = Poser(face, ("jawOpen",))
    return framing(face, crop, background, 96, 96).render(poser.pose(np.zeros(1, dtype=np.float32)))


@pytest.mark.parametrize("crop", ["portrait", "head", "oval"])
@pytest.mark.parametrize("colour", ["#808080", "#000000", "#0b57d0"])
def test_a_background_comes_out_in_the_colour_that_was_asked_for(crop: str, colour: str) -> None:
    assert tuple(picture(crop, colour)[0, 0]) == background_colour(colour)


def test_every_crop_shows_something_else() -> None:
    pictures = {crop: picture(crop) for crop in CROPS}
    covered = {crop: float((shown != 128).any(axis=2).mean()) for crop, shown in pictures.items()}
    assert covered["portrait"] < covered["head"]
    assert covered["mouth"] > 0.7
    assert covered["eyes"] > 0.7
    assert not np.array_equal(pictures["mouth"], pictures["eyes"])


def test_an_oval_hides_all_that_lies_outside_it() -> None:
    shown = (picture("oval") != 128).any(axis=2)
    assert not shown[[0, -1]].any()
    assert not shown[:, [0, -1]].any()
    down, across = np.nonzero(shown)
    assert 1.2 < np.ptp(down) / np.ptp(across) < 1.6
    # Upright and even: as wide to either side of its middle.
    assert abs(across.mean() - 47.5) < 1.5


def test_names_that_are_not_known() -> None:
    with pytest.raises(InputError, match="did you mean 'mouth'"):
        framing(load_face("default"), "mouht", "", 96, 96)
    with pytest.raises(InputError, match="background is a colour"):
        background_colour("grayish")
