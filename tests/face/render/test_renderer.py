"""The compiled renderer against plain numpy, and what every picture must show."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from mien.core.channels import ALL
from mien.core.errors import InputError
from mien.face.model import Face, Material, Part
from mien.face.posing import PosedFace, PosedPart, Poser
from mien.face.render.camera import Camera
from mien.face.render.lighting import Lighting
from mien.face.render.plain_renderer import render_reference
from mien.face.render.renderer import Renderer
from tests.faces import ball, tiny_face


def row(**values: float) -> np.ndarray:
    return np.array([values.get(name, 0.0) for name in ALL])


def posed(face: Face, **values: float) -> PosedFace:
    return Poser(face, ALL).pose(row(**values))


def with_lashes(face: Face) -> Face:
    """Two slips of a sheet before the left eye, one facing the camera and one turned away."""
    corners = np.float32([[20, 2, 30], [44, 2, 30], [32, 10, 32], [20, -8, 30], [44, -8, 30], [32, -4, 32]])
    triangles = np.array([[0, 1, 2], [3, 5, 4]], dtype=np.int32)
    ones = np.ones((6, 3), np.float32)
    lashes = Part(
        "lashes", corners, triangles, ones[:, :2], ones, Material("lashes", (0.3, 0.2, 0.1)), np.ones(6, np.float32)
    )
    return replace(face, parts=(*face.parts, lashes))


def with_glasses(face: Face) -> Face:
    """A pane before the face, its left half more solid than its right one; and a veil of the same opacity all over."""
    corners = np.float32([[-50, 20, 60], [50, 20, 60], [50, -30, 60], [-50, -30, 60]])
    uv, ones = np.float32([[0, 0], [1, 0], [1, 1], [0, 1]]), np.ones((4, 3), np.float32)
    picture = np.full((16, 32, 4), (40, 60, 200, 90), np.uint8)
    picture[:, :16, 3] = 200
    triangles = np.array([[0, 2, 1], [0, 3, 2]], dtype=np.int32)
    pane = Part("pane", corners, triangles, uv, ones, Material("pane", texture=picture), ones[:, 0])
    veil = replace(pane, name="veil", vertices=corners + np.float32([0, 40, 5]), material=Material("veil", opacity=0.4))
    return replace(face, parts=(*face.parts, pane, veil))


@pytest.mark.parametrize(
    ("values", "camera"),
    [
        ({"jawOpen": 0.7, "headYaw": 15.0, "headRoll": -6.0}, (0, 0)),
        ({"eyeLookInLeft": 1.0, "browInnerUp": 0.8}, (40, 10)),
        ({"headPitch": -20.0}, (-85, -20)),
    ],
)
def test_the_kernels_agree_with_plain_numpy(values, camera):
    face = with_glasses(with_lashes(tiny_face()))
    renderer = Renderer(face, 90, 70, Camera.portrait(face, 90 / 70).turned(*camera))
    pose = posed(face, **values)
    difference = np.abs(renderer.render(pose).astype(int) - render_reference(renderer, pose))
    # A level either way from rounding; a sample that lies on an edge or a shadow's rim may fall to either side.
    assert (difference > 1).mean() < 0.002
    assert difference.mean() < 0.05


def test_the_relief_of_skin_agrees_with_plain_numpy_and_shows_only_close_up():
    face = tiny_face()
    skin = replace(face.parts[0], material=replace(face.parts[0].material, scatter=0.5))
    face = replace(face, parts=(skin, *face.parts[1:]))
    near = Renderer(face, 60, 60, Camera((15, -20, 60), 900, 7))
    assert near.relief_share == 1
    assert Renderer(face, 60, 60).relief_share == 0
    pose = posed(face)
    difference = np.abs(near.render(pose).astype(int) - render_reference(near, pose))
    assert (difference > 1).mean() < 0.002
    near.relief_share = np.float32(0)
    smooth = near.render(pose).astype(int)
    assert np.abs(smooth - render_reference(near, pose)).mean() < 0.05
    near.relief_share = np.float32(1)
    assert np.abs(smooth - near.render(pose)).mean() > 0.5


def test_the_picture_does_not_depend_on_threads_or_on_pictures_before(monkeypatch):
    face = tiny_face()
    pose, other = posed(face, jawOpen=0.5), posed(face, headYaw=30.0)
    pictures = []
    for threads in ("1", "2", "5"):
        monkeypatch.setenv("NUMBA_NUM_THREADS", threads)
        renderer = Renderer(face, 160, 90)
        renderer.render(other)
        pictures.append(renderer.render(pose).tobytes())
    with ThreadPoolExecutor(3) as pool:
        at_once = [picture.tobytes() for picture in pool.map(renderer.render, [pose, other, pose, other, pose])]
    assert {*pictures, *at_once[::2]} == {pictures[0]}
    assert len(set(at_once)) == 2


def test_what_is_seen_through_shows_as_much_of_what_is_behind_as_its_opacity_says():
    grey, ones = Material("m", (0.5, 0.5, 0.5), specular=0.0), np.ones((4, 3), np.float32)
    corners = np.float32([[-60, -60, 0], [60, -60, 0], [60, 60, 0], [-60, 60, 0]])
    triangles = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
    wall = Part("wall", corners, triangles, ones[:, :2], ones, grey, ones[:, 0])
    dark = Material("dark", (0, 0, 0), specular=0.0)
    black = replace(Lighting.portrait(), background=np.zeros((2, 3), np.float32))
    shown = []
    for opacity in (0.0, 0.1, 0.5, 0.85, 1.0):
        pane = replace(
            wall, name="pane", vertices=corners + np.float32([0, 0, 9]), material=replace(dark, opacity=opacity)
        )
        face = Face("pane", (wall, pane), (), (0, 0, 0), {}, "")
        picture = Renderer(face, 64, 64, Camera((0, 0, 0), 900, 80), black).render(Poser(face, ()).pose([]))
        shown.append((picture[16:48, 16:48].astype(float) ** 2.2).mean())
    np.testing.assert_allclose(1 - np.array(shown) / shown[0], [0.0, 0.1, 0.5, 0.85, 1.0], atol=0.06)


def test_the_face_is_in_the_middle_before_a_gradient():
    face = tiny_face()
    picture = Renderer(face, 320, 180).render(posed(face)).astype(int)
    assert picture.shape == (180, 320, 3)
    empty = Renderer(face, 320, 180, Camera((0, 5000, 0), 1000, 300)).render(posed(face)).astype(int)
    covered = (np.abs(picture - empty) > 12).any(axis=2)
    across, down = np.flatnonzero(covered.any(axis=0)), np.flatnonzero(covered.any(axis=1))
    assert abs((across[0] + across[-1]) / 2 - 160) < 4
    assert 5 < down[0] < 45
    assert down[-1] == 179
    height = empty[:, :, 2].mean(axis=1)
    assert (np.diff(height[::10]) > 0).all()
    assert np.abs(np.diff(height)).max() <= 1.5  # dithered: never a visible step


def test_turning_the_camera_and_turning_the_head_show_the_same_outline():
    """The camera going round to the speaker's left sees what a head turned to its right shows."""
    face = tiny_face()
    face = replace(face, parts=tuple(replace(p, head_weight=np.ones(len(p.vertices), np.float32)) for p in face.parts))
    camera = replace(Camera.portrait(face), target=face.head_pivot)
    black = replace(Lighting.portrait(), background=np.zeros((2, 3), np.float32))
    turned_camera = Renderer(face, 160, 120, camera.turned(25), black).render(posed(face))
    turned_head = Renderer(face, 160, 120, camera, black).render(posed(face, headYaw=-25.0))
    np.testing.assert_array_equal(turned_camera.max(axis=2) > 8, turned_head.max(axis=2) > 8)


def test_edges_are_smooth():
    vertices, triangles, uv = ball((0, 0, 0), (60, 60, 60), 40, 60)
    white = Part("ball", vertices, triangles, uv, np.ones_like(vertices), Material("m"), np.ones(len(uv), np.float32))
    face = Face("ball", (white,), (), (0, 0, 0), {}, "CC0")
    black = replace(Lighting.portrait(), background=np.zeros((2, 3), np.float32))
    picture = Renderer(face, 100, 100, Camera((0, 0, 0), 1000, 150), black).render(Poser(face, ()).pose([]))
    assert len(np.unique(picture[:, 60].max(axis=1))) > 20
    edge = picture[50].max(axis=1).astype(int)
    assert edge[5] == 0
    assert edge[50] > 100


def pixel(renderer: Renderer, point) -> tuple[int, int]:
    """Row and column in which a point of space is seen."""
    camera = renderer.camera
    across, up, back = camera.axes() @ (np.asarray(point) - camera.place())
    scale = camera.focal_pixels(renderer.height) / -back
    return round(0.5 * renderer.height - scale * up), round(0.5 * renderer.width + scale * across)


def plain_part(name, vertices, triangles, material=None) -> Part:
    ones = np.ones((len(vertices), 3), np.float32)
    return Part(
        name,
        vertices,
        triangles,
        ones[:, :2],
        ones,
        material or Material(name, (0.5, 0.5, 0.5), specular=0.0),
        ones[:, 0],
    )


def test_a_ball_shades_the_floor_where_the_key_light_cannot_reach_it_and_dims_it_beneath():
    ring, floor_triangles, _ = ball((0, 0, 0), (30, 30, 30), 24, 32)
    grid = np.stack(np.meshgrid(np.linspace(-90, 90, 61), np.linspace(-90, 90, 61)), axis=-1).reshape(-1, 2)
    floor = np.c_[grid[:, 0], np.zeros(len(grid)), grid[:, 1]].astype(np.float32)
    cells = np.array(
        [(r * 61 + c, r * 61 + c + 1, r * 61 + c + 62, r * 61 + c + 61) for r in range(60) for c in range(60)]
    )
    triangles = np.concatenate([cells[:, [0, 2, 1]], cells[:, [0, 3, 2]]]).astype(np.int32)
    overhead = plain_part("ball", ring + np.float32([0, 30, 0]), floor_triangles)
    face = Face("ball over a floor", (overhead, plain_part("floor", floor, triangles)), (), (0, 0, 0), {}, "")
    renderer = Renderer(face, 128, 128, Camera((0, 0, 0), 900, 220, pitch=60))
    picture = renderer.render(Poser(face, ()).pose([])).astype(int)
    towards = Lighting.portrait().directions[0]
    in_shadow = np.array([0, 30, 0]) - towards * 30 / towards[1]
    dark, beneath, bright = (picture[pixel(renderer, at)].sum() for at in (in_shadow, (10, 0, 16), (-60, 0, 60)))
    assert dark < 0.75 * bright
    assert beneath < 0.93 * bright


def test_textures_are_read_the_right_way_up_and_averaged_when_small():
    square = np.float32([[-50, -50, 0], [50, -50, 0], [50, 50, 0], [-50, 50, 0]])
    uv = np.float32([[0, 1], [1, 1], [1, 0], [0, 0]])
    triangles = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
    texture = np.zeros((64, 64, 3), np.uint8)
    texture[:32, :32] = (255, 0, 0)  # the upper left quarter
    texture[32:] = np.where((np.indices((32, 64)).sum(axis=0) % 2)[..., None], 255, 0)  # a fine chequerboard
    material = Material("m", texture=texture, specular=0.0)
    part = replace(plain_part("square", square, triangles, material), uv=uv)
    face = Face("square", (part,), (), (0, 0, 0), {}, "")
    picture = Renderer(face, 40, 40, Camera((0, 0, 0), 900, 130)).render(Poser(face, ()).pose([])).astype(int)
    assert picture[12, 12, 0] > 150
    assert picture[12, 12, 1] < 30
    assert picture[12, 27].max() < 30
    chequers = picture[24:32, 8:32].mean(axis=2)
    assert chequers.std() < 12  # evenly grey: read from a level where squares are smaller than pixels


def test_wrong_poses_and_sizes_are_refused():
    face = tiny_face()
    with pytest.raises(InputError, match="between 16 and 8192 pixels, not 8 x 720"):
        Renderer(face, 8, 720)
    none = np.zeros((3, 3), np.float32)
    with pytest.raises(InputError, match=r"parts of \[3\] vertices, face 'tiny'"):
        Renderer(face, 64, 64).render(PosedFace((PosedPart(none, none),)))
