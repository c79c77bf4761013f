"""Markers find their places on the default face, on one of the same mesh, and on any other that channels move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.capture.layouts import known_layouts, load_layout
from mien.core.errors import InputError
from mien.face.library import load_face
from mien.face.marker_sites import GIVEN, Placed, load_marker_places, place_markers
from mien.face.model import Face
from mien.face.retargeting import basis_at
from tests.another_face import another_face, bend
from tests.faces import tiny_face

PLACES = load_marker_places("mediapipe-218")
MOUTH = load_layout("mediapipe-218").groups["mouth"]


@pytest.fixture(scope="module")
def default() -> Placed:
    return place_markers(load_face(), PLACES)


@pytest.fixture(scope="module")
def another() -> Face:
    return another_face(load_face())[0]


def test_each_lips_markers_sit_on_that_lip(default: Placed) -> None:
    """The lower lip goes with the jaw, the upper one does not: markers of landmarks 191 and 415 used to sit below."""
    landmarks = load_layout("mediapipe-218").landmarks
    upper = [landmarks[n] for n in (13, 82, 312, 81, 311, 80, 310, 191, 415, 0, 37, 267)]
    lower = [landmarks[n] for n in (14, 87, 317, 178, 402, 88, 318, 95, 324, 17, 84, 314)]
    sites = dict(zip(default.names, default.sites, strict=True))
    channels = ["jawOpen", "mouthUpperUpLeft", "mouthUpperUpRight"]
    moved = basis_at(load_face(), [sites[name] for name in (*upper, *lower)], channels)
    dropped, lifted = moved[0, :, 1], moved[1:, :, 1].sum(axis=0)
    assert dropped[: len(upper)].min() > -10
    assert dropped[len(upper) :].max() < -14
    assert lifted[: len(upper)].min() > 2.5
    assert lifted[len(upper) :].max() < 0.3 * lifted[: len(upper)].max()  # the corner is dragged along


def test_irises_sit_on_the_eyeballs(default: Placed) -> None:
    sites = dict(zip(default.names, default.sites, strict=True))
    assert (sites["3.5"][0], sites["3.6"][0]) == ("eye_left", "eye_right")


@pytest.mark.parametrize("layout", known_layouts())
def test_a_likeness_of_the_same_mesh_has_them_on_the_same_vertices(layout: str) -> None:
    face, _ = another_face(load_face(), shuffle=False)
    places = load_marker_places(layout)
    found, here = place_markers(face, places), place_markers(load_face(), places)
    assert found.how == "same mesh"
    assert found.sites == here.sites


@pytest.mark.parametrize(("sites", "mean", "mouth"), [(True, 1.2, 0.2), (False, 2.0, 1.2)])
def test_another_mesh_gets_them_by_what_its_channels_move(
    default: Placed, sites: bool, mean: float, mouth: float
) -> None:
    face, _ = another_face(load_face(), sites)
    found = place_markers(face, PLACES)
    plain = load_face()
    truth = bend(np.array([plain.part(part).vertices[vertex] for part, vertex in default.sites]))
    away = np.linalg.norm(np.array([face.part(p).vertices[v] for p, v in found.sites]) - truth, axis=1)
    assert found.how == "transferred"
    assert away.mean() < mean
    assert away.max() < 8.0
    lips = [k for k, name in enumerate(found.names) if name in MOUTH and name.startswith(("8.", "2.2", "2.3"))]
    assert away[lips].mean() < mouth
    untouched = np.linalg.norm(PLACES.places - truth, axis=1)
    assert untouched.mean() > 3 * away.mean()


def test_the_skin_need_not_be_called_skin(another: Face) -> None:
    renamed = replace(
        another, parts=tuple(replace(p, name="head" if p.name == "skin" else p.name) for p in another.parts)
    )
    found = place_markers(renamed, PLACES, ["8.3", "8.4"])
    assert {part for part, _ in found.sites} == {"head"}


def test_sites_that_a_face_gives_are_believed(another: Face) -> None:
    given = replace(another, sites={GIVEN + "8.3": ("skin", 7), GIVEN + "8.4": ("skin", 9)})
    assert place_markers(given, PLACES, ["8.4", "8.3"]).sites == (("skin", 9), ("skin", 7))
    assert place_markers(given, PLACES, ["8.4", "8.3"]).how == "given"
    assert place_markers(given, PLACES, ["8.4", "2.2"]).sites[0] == ("skin", 9)


def test_a_face_twice_as_large_keeps_its_markers(another: Face) -> None:
    parts = []
    for part in another.parts:
        targets = {n: replace(t, offsets=2 * t.offsets) for n, t in part.targets.items()}
        parts.append(replace(part, vertices=2 * part.vertices, targets=targets))
    eyes = tuple(replace(eye, centre=tuple(2 * c for c in eye.centre)) for eye in another.eyes)
    large = place_markers(replace(another, parts=tuple(parts), eyes=eyes), PLACES)
    small = place_markers(another, PLACES)
    assert large.scale == pytest.approx(2 * small.scale, rel=0.02)
    same = sum(one == other for one, other in zip(large.sites, small.sites, strict=True))
    assert same > 0.9 * len(small.sites)


def test_faces_without_a_hold_are_refused_in_one_line() -> None:
    face = tiny_face()
    bare = replace(face, eyes=(), sites={}, parts=tuple(replace(part, targets={}) for part in face.parts))
    with pytest.raises(InputError, match=r"face 'tiny': 0 points are known on it .* give sites 'marker:NAME'"):
        place_markers(bare, PLACES)
    with pytest.raises(InputError, match="what its channels move lies elsewhere than on a face"):
        place_markers(face, PLACES)
    nameless = replace(bare, parts=tuple(replace(part, name=f"p{k}") for k, part in enumerate(bare.parts)))
    with pytest.raises(InputError, match="no part 'skin' and no morph targets"):
        place_markers(nameless, PLACES)
