import numpy as np

from mien.face.cast.eyes import iris_picture, wet_line
from mien.face.cast.made_person import person_named
from mien.face.head_space import head_space


def test_an_iris_takes_the_persons_colour_and_leaves_the_pupil() -> None:
    face = head_space().face
    own = face.part("eye_left").material.texture
    blue = iris_picture(own, person_named("ingrid")).astype(int)
    brown = iris_picture(own, person_named("mei")).astype(int)
    middle, size = len(blue) // 2, len(blue)
    at = middle + int(0.11 * size)
    assert blue[middle, at, 2] > blue[middle, at, 0]
    assert brown[middle, at, 2] < brown[middle, at, 0]
    assert blue[middle, middle].max() < 20


def test_the_wet_line_lies_on_the_lower_lid_and_goes_with_it() -> None:
    space = head_space()
    line = wet_line(space, space.face, person_named("ingrid"))
    margin = space.rest[np.r_[space.lid_loop_left, space.lid_loop_right]]
    away = np.linalg.norm(line.vertices[:, None] - margin[None], axis=2).min(axis=1)
    assert away.max() < 2.5  # at the inner corner it lies in front of the caruncle
    assert {"eyeSquintLeft", "eyeSquintRight"} <= set(line.targets)
