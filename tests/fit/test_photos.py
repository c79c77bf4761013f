"""Photographs whose camera and head are known: the points are projected, the picture is painted on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from mien.core.errors import InputError
from mien.face.head_space import head_space
from mien.face.warps import similarity_between
from mien.fit.from_photos import face_from_photos
from mien.fit.head_regions import head_regions
from mien.fit.landmarks import known_landmarks, other_side
from mien.fit.mesh_files import read_picture
from mien.fit.photo_camera import PhotoCamera, find_camera
from mien.fit.photo_marks import named_marks
from mien.fit.photo_paint import PaintSettings
from mien.fit.shape_from_photos import shape_from_photos
from tests.fit.heads import other_shape

WIDTH, HEIGHT = 600, 800


def camera(yaw: float) -> PhotoCamera:
    """A portrait's camera on the person's left by some degrees."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_euler("x", 180, degrees=True) * Rotation.from_euler("y", -yaw, degrees=True)
    return PhotoCamera(WIDTH, HEIGHT, turn.as_rotvec(), turn.apply([0, 20, 40]) + np.array([0, 0, 1100]), 1.9 * HEIGHT)


def names_seen(yaw: float) -> list[str]:
    names = [k for k in known_landmarks() if k not in ("head_back", "throat") or abs(yaw) > 60]
    return [k for k in names if abs(yaw) < 60 or not k.endswith("_right" if yaw > 0 else "_left")]


def photo(shape, yaw: float, colour=(180, 140, 120), **changed):
    places, _ = camera(yaw).seen(shape)
    marks = {k: tuple(places[known_landmarks()[k].vertex]) for k in names_seen(yaw)} | changed
    picture = np.full((HEIGHT, WIDTH, 3), colour, np.uint8)
    return named_marks(f"{yaw:+.0f}.png", picture, marks, "points.csv")


def error(shape, truth, chosen=None):
    outer = head_space().outer() if chosen is None else chosen
    return np.linalg.norm(similarity_between(shape[outer], truth[outer])(shape[outer]) - truth[outer], axis=1).mean()


@pytest.mark.parametrize("yaw", [0.0, 40.0, -90.0])
def test_the_camera_is_found(yaw):
    shape = head_space().rest
    marks = np.array([known_landmarks()[k].vertex for k in names_seen(yaw)])
    places, _ = camera(yaw).seen(shape[marks])
    found, left = find_camera(WIDTH, HEIGHT, shape[marks], places, 1.0)
    assert left < 0.2
    assert abs(found.yaw() - camera(yaw).yaw()) < 1.0


def test_slopes_of_a_camera():
    point, step = np.array([[10.0, -20.0, 30.0]]), 1e-4
    for axis in range(3):
        ahead = camera(40.0).seen(point + step * np.eye(3)[axis])[0] - camera(40.0).seen(point)[0]
        np.testing.assert_allclose(camera(40.0).slopes(point)[0, :, axis], ahead[0] / step, rtol=1e-3, atol=1e-6)


@pytest.mark.parametrize("views", [(0.0, 90.0), (0.0, -90.0), (0.0, 45.0, -45.0)])
def test_shape_is_nearer_than_the_mean_head(views):
    truth = other_shape(11, 40)
    fit = shape_from_photos(head_space(), [photo(truth, yaw) for yaw in views])
    face = head_regions()["mouth"] | head_regions()["eyes"] | head_regions()["nose"]
    assert error(fit.vertices, truth, face) < 0.4 * error(head_space().shape([0.0]), truth, face)
    assert error(fit.vertices, truth) < 0.6 * error(head_space().shape([0.0]), truth)
    assert max(fit.residuals) < 4.0


def test_size_comes_from_the_distance_between_the_eyes():
    truth = other_shape(11, 40)
    photos = [photo(truth, 0.0), photo(truth, 90.0)]
    small, large = (shape_from_photos(head_space(), photos, eye_distance=d).vertices for d in (50.0, 70.0))
    np.testing.assert_allclose(large, small * 1.4, atol=1e-6)


def test_one_photograph_is_enough_and_said():
    fit = shape_from_photos(head_space(), [photo(other_shape(11, 40), 0.0)])
    assert "depth" in fit.notes[0].message


def test_a_landmark_far_off_is_left_out():
    truth = other_shape(11, 40)
    x, y = (float(c) for c in camera(0.0).seen(truth)[0][known_landmarks()["brow_inner_left"].vertex])
    fit = shape_from_photos(head_space(), [photo(truth, 0.0, brow_inner_left=(x + 24, y)), photo(truth, 90.0)])
    assert any("brow_inner_left" in note.message and "left out" in note.message for note in fit.notes)


@pytest.mark.parametrize(
    ("photos", "told"),
    [
        (lambda t: [photo(t, 90.0), photo(t, 0.0)], "has to be from the front"),
        (lambda t: [swapped(photo(t, 0.0))], "left and right are swapped"),
        (lambda t: [photo(t, 0.0, chin=(20.0, 20.0), nose_tip=(500.0, 700.0))], "pixels"),
    ],
)
def test_photographs_that_cannot_be_are_refused(photos, told):
    with pytest.raises(InputError, match=told):
        shape_from_photos(head_space(), photos(other_shape(11, 40)))


def swapped(shot):
    names = tuple(other_side(name) for name in shot.names)
    return replace(shot, names=names, vertices=np.array([known_landmarks()[k].vertex for k in names]))


def test_points_outside_the_picture_are_refused():
    with pytest.raises(InputError, match=r"points.csv: chin at 900, 900 lies outside"):
        photo(head_space().rest, 0.0, chin=(900.0, 900.0))


def test_a_face_takes_the_photographs_colour():
    """Photographs of one colour make a skin near that colour, seen or not, and the face still moves."""
    truth = other_shape(11, 40)
    photos = [photo(truth, 0.0), photo(truth, 90.0)]
    done = face_from_photos(photos, "me", paint=PaintSettings(size=256, even_light=0.0))
    skin = done.face.part("skin")
    place = np.clip((skin.uv * 256).astype(int), 0, 255)
    colours = skin.material.texture[place[:, 1], place[:, 0]]
    front = head_regions()["cheeks and jaw"]
    np.testing.assert_allclose(np.median(colours[front], axis=0), (180, 140, 120), atol=6)
    assert set(head_space().skin.targets) == set(skin.targets)
    assert "brows" not in [part.name for part in done.face.parts]
    centres = np.array([eye.centre for eye in done.face.eyes])
    np.testing.assert_allclose(centres.mean(0), 0, atol=1e-4)


def test_pictures_are_turned_upright(tmp_path):
    picture = Image.fromarray(np.zeros((40, 80, 3), np.uint8))
    exif = Image.Exif()
    exif[0x0112] = 6  # turned by a quarter
    picture.save(tmp_path / "turned.jpg", exif=exif)
    assert read_picture(tmp_path / "turned.jpg").shape == (80, 40, 3)


def test_no_picture(tmp_path):
    (tmp_path / "a.png").write_text("no")
    with pytest.raises(InputError, match="cannot be read as a picture"):
        read_picture(tmp_path / "a.png")


def test_open_eyes_are_not_painted_on_lids():
    """The eyes of a picture are bright green: none of it comes onto the skin."""
    from PIL import ImageDraw

    space = head_space()
    given = photo(space.rest, 0.0)
    picture = Image.fromarray(given.picture)
    for loop in (space.lid_loop_left, space.lid_loop_right):
        outline = camera(0.0).seen(space.rest[loop])[0]
        middle = outline.mean(axis=0)
        ImageDraw.Draw(picture).polygon([tuple(middle + 1.05 * (p - middle)) for p in outline], fill=(0, 255, 0))
    done = face_from_photos([replace(given, picture=np.asarray(picture))], "a", paint=PaintSettings(size=256))
    texture = done.face.part("skin").material.texture.astype(int)
    assert (texture[:, :, 1] - texture[:, :, 0]).max() < 40
    assert done.painted.seen.mean() > 0.1


def test_a_smile_is_taken_out():
    from mien.face.contact import dense_targets

    moves = dense_targets(head_space())
    rest = head_space().shape([0.0])
    smiling = rest + 0.7 * (moves["mouthSmileLeft"] + moves["mouthSmileRight"])
    fit = shape_from_photos(head_space(), [photo(smiling, 0.0), photo(smiling, 45.0)])
    assert any("shows an expression (smile 0." in note.message for note in fit.notes)
    mouth = head_regions()["mouth"]
    assert error(fit.vertices, rest, mouth) < 0.5 * error(fit.posed, rest, mouth)
    still = shape_from_photos(head_space(), [photo(rest, 0.0), photo(rest, 45.0)])
    assert not any("expression" in note.message for note in still.notes)
