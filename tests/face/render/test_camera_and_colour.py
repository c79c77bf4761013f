"""Framing, and the numbers of colours."""

from __future__ import annotations

import re
from dataclasses import replace
from importlib import resources

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.face.model import Face, Material, Part
from mien.face.posing import Poser
from mien.face.render.camera import Camera, known_cameras
from mien.face.render.colour import KNEE, SRGB_BYTES, SRGB_STEPS, linear_from_srgb, tone
from mien.face.render.lighting import Lighting, known_lightings
from mien.face.render.view import View
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
    nothing = replace(tiny_face(), parts=())
    with pytest.raises(InputError, match="nothing to frame"):
        Camera.portrait(nothing)


@pytest.mark.parametrize("side", [0.2, 100.0, 9000.0])
@pytest.mark.parametrize("name", known_cameras())
def test_a_mesh_of_any_size_is_framed_by_every_camera(side, name):
    """A box without eyes, off its origin: whole pictures hold it, close-ups show it."""
    corners = np.array(np.meshgrid(*[[-1, 1]] * 3, indexing="ij"), np.float32).reshape(3, -1).T
    vertices, ones = np.float32(side / 2) * (corners + np.float32([3, 2, -1])), np.ones((8, 3), np.float32)
    quads = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int32)
    box = Part("box", vertices, triangles, ones[:, :2], ones, Material("box"), ones[:, 0])
    face = Face("box", (box,), (), (0, 0, 0), {}, "")
    view = View(96, 64, camera=name, background="transparent")
    shown = view.renderer(face).render(Poser(face, ()).pose([]))[..., 3] > 0
    assert shown.mean() > 0.1
    if name not in ("mouth", "eyes", "oval"):
        assert not shown[[0, -1]].any()
        assert not shown[:, [0, -1]].any()


def test_a_table_of_ones_own_is_a_camera_and_a_light(tmp_path):
    folder = resources.files("mien") / "assets" / "render"
    text = (folder / "cameras" / "portrait.toml").read_text()
    (tmp_path / "low.toml").write_text(text.replace("pitch = 0", "pitch = -20"))
    assert Camera.named(str(tmp_path / "low.toml"), tiny_face()).pitch == -20
    (tmp_path / "dim.toml").write_text((folder / "lights" / "soft.toml").read_text().replace("= 1.0", "= 0.25", 1))
    assert Lighting.named(str(tmp_path / "dim.toml")).exposure == 0.25


def test_a_new_table_in_the_folder_is_a_new_name(tmp_path, monkeypatch):
    for kind in ("cameras", "lights"):
        (tmp_path / "render" / kind).mkdir(parents=True)
        given = resources.files("mien") / "assets" / "render" / kind / "portrait.toml"
        (tmp_path / "render" / kind / "mine.toml").write_text(given.read_text())
    monkeypatch.setenv("MIEN_TABLES", str(tmp_path))
    assert "mine" in known_cameras()
    assert "mine" in known_lightings()
    view = View(64, 64, camera="mine", light="mine")
    assert view.renderer(tiny_face()).camera == Camera.portrait(tiny_face(), 1.0)


@pytest.mark.parametrize(
    ("kind", "change", "said"),
    [
        ("cameras", ("yaw = 0", ""), "x.toml: the field 'yaw' is missing"),
        ("cameras", ("yaw = 0", "yaw = 0\nzoom = 2"), "unknown field 'zoom'"),
        ("cameras", ("pitch = 0", "pitch = 90"), "pitch lies between -90 and 90"),
        ("cameras", ("height = 2.75", "height = -1"), "height lies between"),
        ("cameras", ("height = 2.75", 'height = "tall"'), "height is a number, not 'tall'"),
        ("cameras", ("centre =", "centre = ="), "x.toml"),
        ("lights", ("exposure = 1.0", "exposure = inf"), "exposure is a number, not inf"),
        ("lights", ("lights = 8", "lights = 1e9"), "a dome has 1 to 64 lights"),
        ("lights", ("colour = [1.32, 1.23, 1.13]", "colour = [1.32, 1.23]"), "key colour is 3 numbers"),
        ("lights", ("direction = [0.52, 0.50, 0.80]", "direction = [0, 0, 0]"), "points nowhere"),
    ],
)
def test_tables_that_cannot_be_used_are_one_line(kind, change, said, tmp_path):
    text = (resources.files("mien") / "assets" / "render" / kind / "portrait.toml").read_text()
    assert change[0] in text
    (tmp_path / "x.toml").write_text(text.replace(*change, 1))
    with pytest.raises(InputError, match=re.escape(said)) as problem:
        View(**{kind.removesuffix("s"): str(tmp_path / "x.toml")})
    assert "\n" not in str(problem.value)


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


def test_hair_that_stands_up_is_framed_where_the_head_is_and_nowhere_else():
    bare = tiny_face()
    skin = next(part for part in bare.parts if part.name == "skin")
    top = skin.vertices[:, 1].max()
    strand = replace(skin, name="hair", vertices=skin.vertices * np.float32([1, 1.7, 1]), targets={})
    haired = replace(bare, parts=(*bare.parts, strand))
    camera = Camera.named("head", haired, 1.0)
    assert camera.target[1] + camera.field_mm / 2 > 1.7 * top
    plain, close = Camera.named("head", bare, 1.0), Camera.named("mouth", haired, 1.0)
    low = camera.target[1] - camera.field_mm / 2
    assert low <= plain.target[1] - plain.field_mm / 2 + 1e-6
    assert close.target[1] + close.field_mm / 2 < top
