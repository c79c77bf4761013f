"""Framing, and the numbers of colours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.face.model import Face
from mien.face.render.camera import Camera
from mien.face.render.colour import KNEE, SRGB_BYTES, SRGB_STEPS, linear_from_srgb, tone
from mien.face.render.lighting import Lighting
from tests.faces import tiny_face


def test_axes_of_a_camera():
    np.testing.assert_allclose(Camera((0, 0, 0), 100, 100).axes(), np.eye(3), atol=1e-12)
    right, up, back = Camera((0, 0, 0), 100, 100, yaw=90).axes()
    np.testing.assert_allclose((right, up, back), ((0, 0, -1), (0, 1, 0), (1, 0, 0)), atol=1e-12)
    above = Camera((1, 2, 3), 100, 100, pitch=30)
    np.testing.assert_allclose(above.place(), (1, 52, 3 + 100 * np.cos(np.pi / 6)), atol=1e-9)
    axes = Camera((0, 0, 0), 100, 100, 35, -20).axes()
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1)


def test_the_field_is_what_is_seen_at_the_target():
    camera = Camera((0, 0, 0), 1000, 250)
    assert camera.focal_pixels(500) * 125 / 1000 == pytest.approx(250)


@pytest.mark.parametrize("aspect", [0.5, 1.0, 16 / 9])
@pytest.mark.parametrize("framing", ["portrait", "head_shot"])
def test_framings_hold_the_head_at_every_aspect(aspect, framing):
    face = tiny_face()
    camera = getattr(Camera, framing)(face, aspect)
    head = np.concatenate([part.vertices[part.head_weight > 0.5] for part in face.parts]) - camera.target
    assert (np.abs(head[:, 1]) < camera.field_mm / 2).all()
    assert (np.abs(head[:, 0]) < camera.field_mm * aspect / 2).all()
    assert Camera.close_up(face, aspect).field_mm < 0.55 * camera.field_mm


def test_impossible_cameras_and_faces_are_refused():
    with pytest.raises(InputError, match="above 0 mm"):
        Camera((0, 0, 0), 0, 100)
    with pytest.raises(InputError, match="pitch"):
        Camera((0, 0, 0), 100, 100, pitch=90)
    face = tiny_face()
    still = tuple(replace(p, head_weight=np.zeros(len(p.vertices), np.float32)) for p in face.parts)
    with pytest.raises(InputError, match="no head to frame"):
        Camera.portrait(Face("stone", still, (), (0, 0, 0), {}, ""))


def test_srgb_and_linear_undo_each_other():
    linear = linear_from_srgb(np.arange(256) / 255)
    steps = np.rint(np.sqrt(linear) * (SRGB_STEPS - 1)).astype(int)
    np.testing.assert_allclose(SRGB_BYTES[steps], np.arange(256), atol=0.15)


def test_the_tone_curve_is_straight_then_bends_and_never_clips():
    light = np.linspace(0, 20, 4001, dtype=np.float32)
    shown = tone(light)
    np.testing.assert_array_equal(shown[light <= KNEE], light[light <= KNEE])
    assert (np.diff(shown) > 0).all()
    assert shown.max() < 1
    slope = np.diff(shown) / np.diff(light)
    assert np.abs(np.diff(slope)).max() < 0.03  # no corner at the knee


def test_lights_are_unit_directions_and_the_dome_is_even():
    lights = Lighting.portrait()
    np.testing.assert_allclose(np.linalg.norm(lights.directions, axis=1), 1, atol=1e-6)
    assert np.linalg.norm(lights.directions[3:].mean(axis=0)) < 0.05
    assert lights.directions.shape == lights.colours.shape
