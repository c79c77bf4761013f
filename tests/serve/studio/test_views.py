import numpy as np
import pytest

from mien.face.library import load_face
from mien.face.posing import Poser
from mien.face.render.lighting import Lighting
from mien.serve.studio.requests import FieldError
from mien.serve.studio.views import CAMERAS, LIGHTS, Shown


def test_every_camera_and_light_gives_a_picture_of_its_own():
    face = load_face("default")
    posed = Poser(face, ("jawOpen",)).pose([0.3])
    shown = [Shown(camera=camera) for camera in CAMERAS] + [Shown(light=light) for light in LIGHTS[1:]]
    pictures = [one.view().of_size(64, 48).renderer(face).render(posed) for one in shown]
    assert all(picture.std() > 5 for picture in pictures)
    for number, one in enumerate(pictures):
        assert all((one != other).any() for other in pictures[:number])


def test_lights_are_complete():
    for name in LIGHTS:
        light = Lighting.named(name)
        assert np.allclose(np.linalg.norm(light.directions, axis=1), 1)


def test_others_are_refused():
    assert Shown.of({"camera": None}) == Shown()
    for asked in ({"camera": "above"}, {"light": ["soft"]}, {"light": "../portrait"}):
        with pytest.raises(FieldError) as caught:
            Shown.of(asked)
        assert caught.value.field == next(iter(asked))
