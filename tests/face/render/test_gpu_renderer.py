"""The painter on a graphics card (in CI Mesa's software) beside the processor's, and what is said without one."""

from __future__ import annotations

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec

import numpy as np
import pytest

from mien.core.channels import ALL
from mien.core.errors import InputError, MissingPartError
from mien.face.deformers import poser_for
from mien.face.library import load_face
from mien.face.render import graphics_card as card
from mien.face.render.camera import Camera
from mien.face.render.gpu_renderer import GpuRenderer
from mien.face.render.renderer import Renderer
from mien.face.render.view import View, with_options

NEUTRAL: dict[str, float] = {}
LAUGH = {"jawOpen": 0.6, "mouthSmileLeft": 0.8, "mouthSmileRight": 0.8, "cheekSquintLeft": 0.6, "browInnerUp": 0.7}


def _missing() -> str:
    if find_spec("moderngl") is None:
        return "moderngl is not installed: pip install 'mien[gpu]'"
    try:
        card.graphics_card()
    except MissingPartError as problem:
        return str(problem)
    return ""


@pytest.fixture(scope="module")
def gpu() -> None:
    if missing := _missing():
        assert not os.environ.get("CI"), missing  # there it is installed
        pytest.skip(missing)


def difference(face, values, **options) -> np.ndarray:
    """Between the two painters, shares of the range; shape as the picture's."""
    view = View(240, 180, **options)
    pose = poser_for(face, ALL).pose(np.array([values.get(name, 0.0) for name in ALL]))
    one, other = (with_options(view, {"painter": name}).renderer(face).render(pose) for name in ("processor", "gpu"))
    assert one.shape == other.shape
    assert one.std() > 10
    return np.abs(one.astype(int) - other) / 255


@pytest.mark.usefixtures("gpu")
@pytest.mark.parametrize("name", ["default", "priya", "yusuf"])  # of the cast: long hair, a full beard
def test_both_painters_show_the_same_picture(name):
    face = load_face(name)
    for camera, values in (("head", NEUTRAL), ("three-quarter", LAUGH)):
        apart = difference(face, values, camera=camera)
        assert apart.mean() < 0.005
        assert np.percentile(apart, 99) < 0.08


@pytest.mark.usefixtures("gpu")
@pytest.mark.parametrize("options", [{"background": "transparent"}, {"background": "#406080", "crop": "oval"}])
def test_both_painters_know_what_a_view_asks_for(options):
    assert difference(load_face("default"), LAUGH, quality="draft", **options).mean() < 0.005


@pytest.mark.usefixtures("gpu")
def test_the_relief_of_skin_is_drawn_close_up():
    face = load_face("default")
    pose = poser_for(face, ALL).pose(np.zeros(len(ALL)))
    one, other = (kind(face, 160, 120, Camera((30, -30, 60), 900, 15)) for kind in (Renderer, GpuRenderer))
    assert one.relief_share == 1
    expected, found = one.render(pose).astype(int), other.render(pose).astype(int)
    one.relief_share = np.float32(0)
    assert np.abs(found - expected).mean() < 0.2 * np.abs(found - one.render(pose)).mean()


@pytest.mark.usefixtures("gpu")
def test_threads_may_draw_at_once():
    face = load_face("default")
    renderer, poser = View(160, 120, painter="gpu").renderer(face), poser_for(face, ALL)
    poses = [poser.pose(np.array([share * LAUGH.get(name, 0.0) for name in ALL])) for share in (0.0, 0.5, 1.0)]
    alone = [renderer.render(pose) for pose in poses]
    with ThreadPoolExecutor(3) as pool:
        for one, other in zip(alone, pool.map(renderer.render, poses), strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.usefixtures("gpu")
def test_a_card_without_what_is_needed_is_one_line(monkeypatch):
    monkeypatch.setattr(card, "_LEAST_GL", 990)
    monkeypatch.setattr(card, "_card", card._card.__wrapped__)
    with pytest.raises(MissingPartError, match="--painter processor") as problem:
        View(painter="gpu")
    assert "\n" not in str(problem.value)


def test_without_the_package_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "moderngl", None)
    monkeypatch.setattr(card, "_card", card._card.__wrapped__)
    with pytest.raises(MissingPartError, match=r"pip install 'mien\[gpu\]'"):
        with_options(View(), {"painter": "gpu"})
    with pytest.raises(InputError, match="unknown painter"):
        View(painter="brush")
