from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from mien.core.channels import MOUTH
from mien.core.errors import InputError
from mien.face import retargeting
from mien.face.library import load_face
from mien.face.model import Face
from mien.face.retargeting import Retargeter, basis_at

CHANNELS = tuple(n for n in MOUTH if not n.startswith(("tongue", "cheek", "mouthClose")))


@pytest.fixture(scope="module")
def face() -> Face:
    return load_face("default")


@pytest.fixture(scope="module")
def sites(face: Face) -> list[tuple[str, int]]:
    """Some sixty vertices round the mouth."""
    skin = face.part("skin")
    name, corner = face.sites["lip_corner_left"]
    assert name == "skin"
    mouth = skin.vertices[face.sites["lip_upper_outer"][1]]
    near = np.flatnonzero(np.linalg.norm(skin.vertices - mouth, axis=1) < 45)
    random = np.random.default_rng(3)
    return [("skin", int(vertex)) for vertex in [corner, *random.choice(near, 60, replace=False)]]


def test_a_frame_agrees_with_a_bounded_solver_of_scipy(face: Face, sites: list[tuple[str, int]]) -> None:
    retargeter = Retargeter(face, sites, CHANNELS, ridge=1e-2, steadiness=0.0)
    asked = np.random.default_rng(1).normal(0, 3, (3, len(sites), 3))
    flat = retargeter.basis.reshape(len(CHANNELS), -1)
    ridge = 1e-2 * (flat**2).sum(axis=1).mean()
    stacked = np.vstack([flat.T, np.sqrt(ridge) * np.eye(len(CHANNELS))])
    got = retargeter.solve(asked).weights
    for frame in range(3):
        goal = np.concatenate([asked[frame].ravel(), np.zeros(len(CHANNELS))])
        expected = lsq_linear(stacked, goal, bounds=(0, 1), tol=1e-12).x
        assert got[frame] == pytest.approx(expected, abs=2e-3)


@pytest.mark.parametrize("name", ["jawOpen", "mouthPucker", "mouthSmileLeft", "mouthLowerDownRight"])
def test_a_single_shape_comes_back(face: Face, sites: list[tuple[str, int]], name: str) -> None:
    weights = np.zeros((5, len(CHANNELS)))
    weights[:, CHANNELS.index(name)] = 0.6
    asked = np.einsum("tk,kmd->tmd", weights, basis_at(face, sites, CHANNELS))
    back = Retargeter(face, sites, CHANNELS, ridge=1e-5).solve(asked)
    assert np.abs(back.weights - weights).max() < 0.01
    assert back.residual.max() < 0.05


def test_weights_stay_in_bounds_and_steady(face: Face, sites: list[tuple[str, int]]) -> None:
    random = np.random.default_rng(1)
    asked = random.normal(0, 8, (40, len(sites), 3))
    shaky = Retargeter(face, sites, CHANNELS, steadiness=0.0).solve(asked).weights
    steady = Retargeter(face, sites, CHANNELS, steadiness=1.0).solve(asked).weights
    assert shaky.min() >= 0
    assert shaky.max() <= 1
    assert np.abs(np.diff(steady, axis=0)).mean() < 0.5 * np.abs(np.diff(shaky, axis=0)).mean()


def test_what_does_not_fit_is_refused(face: Face, sites: list[tuple[str, int]]) -> None:
    retargeter = Retargeter(face, sites, CHANNELS)
    with pytest.raises(InputError, match="61 markers"):
        retargeter.solve(np.zeros((2, 5, 3)))
    asked = np.zeros((2, 61, 3))
    asked[1, 4] = np.nan
    with pytest.raises(InputError, match="frame 1, marker 4"):
        retargeter.solve(asked)
    with pytest.raises(InputError, match="no vertex"):
        Retargeter(face, [("skin", 10**7)], CHANNELS)
    with pytest.raises(InputError, match="tongueBackUp move none"):
        Retargeter(face, sites, ("jawOpen", "tongueBackUp"))


@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_windows_give_what_the_whole_line_gives(
    face: Face, sites: list[tuple[str, int]], fps: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    random = np.random.default_rng(4)
    weights = np.clip(random.normal(0.2, 0.3, (round(5 * fps) + 7, len(CHANNELS))), 0, 1)
    asked = np.einsum("tk,kmd->tmd", weights, basis_at(face, sites, CHANNELS))
    retargeter = Retargeter(face, sites, CHANNELS)
    whole = retargeter.solve(asked, fps).weights
    monkeypatch.setattr(retargeting, "_WINDOW", 1.5)
    windows = retargeter.solve(asked, fps).weights
    assert not np.array_equal(whole, windows)
    assert np.abs(whole - windows).max() < 5e-3
