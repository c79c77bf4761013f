"""Markers over the face in blended regions: the interpolation by hand, and that lips and lids part."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core.channels import ALL
from mien.core.errors import InputError
from mien.face.deformers import deformed_by, poser_for
from mien.face.library import load_face
from mien.face.marker_regions import SOFTNESS, RegionDeformer, interpolation_matrix
from mien.face.posing import Poser
from tests.faces import tiny_face


def test_two_centres_by_hand() -> None:
    """phi = -sqrt(r^2 + c^2); coefficients are opposite, so the middle takes the mean and far away it levels off.

    With centres at x = 0 and x = 6 and c = 8: phi(0) = -8, phi(6) = -10. Values 0 and 1 ask for coefficients -k and k
    with 2 k (phi(0) - phi(6)) = 1, so k = 1/4, and a constant of 1/2.
    """
    centres = np.array([[0.0, 0, 0], [6, 0, 0]])
    points = np.array([[3.0, 0, 0], [0, 0, 0], [-15, 0, 0]])
    found = interpolation_matrix(centres, points, softness=8.0) @ [0.0, 1.0]
    by_hand = 0.5 + 0.25 * (-np.sqrt(21**2 + 64) + np.sqrt(15**2 + 64))
    np.testing.assert_allclose(found, [0.5, 0.0, by_hand], atol=1e-12)


def test_a_shift_of_all_markers_is_a_shift_everywhere() -> None:
    rng = np.random.default_rng(0)
    rows = interpolation_matrix(rng.normal(0, 30, (12, 3)), rng.normal(0, 60, (40, 3)), SOFTNESS)
    np.testing.assert_allclose(rows.sum(axis=1), 1, atol=1e-9)


@pytest.fixture(scope="module")
def deformer() -> RegionDeformer:
    return RegionDeformer(load_face())


def test_shares_sum_to_one_near_the_markers_and_fade_away_from_them(deformer: RegionDeformer) -> None:
    total = deformer.shares["skin"].sum(axis=0)
    assert ((total > -1e-9) & (total < 1 + 1e-9)).all()
    np.testing.assert_allclose(total[deformer.sites.vertices], 1, atol=1e-9)
    skin = load_face().part("skin")
    assert total[skin.vertices[:, 2] < -150].max() == 0  # the back of the head


def test_markers_go_where_they_are_asked_to(deformer: RegionDeformer) -> None:
    """All that a region hears of its own markers is exact; at its border the neighbour has a say."""
    face, sites = load_face(), deformer.sites
    targets = face.part("skin").targets
    for name in ("jawOpen", "mouthSmileLeft", "browDownRight"):
        dense = np.zeros((len(face.part("skin").vertices), 3))
        dense[targets[name].vertices] = targets[name].offsets
        asked = dense[sites.vertices]
        got = deformer.offsets(asked)["skin"][sites.vertices]
        assert np.sqrt(((got - asked) ** 2).sum(1).mean()) < 0.12 * np.linalg.norm(asked, axis=1).max()


def test_a_lip_moves_alone(deformer: RegionDeformer) -> None:
    """Five millimetres down of the lower lip open the mouth and leave the upper lip within half a millimetre."""
    face, sites = load_face(), deformer.sites
    lower = set(sites.regions["lower_jaw"]) - set(sites.regions["upper_jaw"])
    asked = np.zeros((len(sites.names), 3))
    asked[sorted(lower), 1] = -5.0
    moved = deformer.offsets(asked)["skin"][:, 1]
    assert moved[face.sites["lip_lower_inner"][1]] < -4.0
    assert abs(moved[face.sites["lip_upper_inner"][1]]) < 0.5
    assert abs(moved[face.sites["brow_inner_left"][1]]) < 0.2


def test_a_lid_moves_alone(deformer: RegionDeformer) -> None:
    face, sites = load_face(), deformer.sites
    asked = np.zeros((len(sites.names), 3))
    asked[sorted(set(sites.regions["upper_lid_left"]) - set(sites.regions["lower_lid_left"])), 1] = -6.0
    moved = deformer.offsets(asked)["skin"][:, 1]
    assert moved[face.sites["lid_upper_left"][1]] < -4.5
    assert abs(moved[face.sites["lid_lower_left"][1]]) < 0.5
    assert abs(moved[face.sites["brow_middle_left"][1]]) < 1.0
    assert abs(moved[face.sites["lid_upper_right"][1]]) < 0.1


def test_a_face_by_regions_follows_the_channels() -> None:
    face = load_face()
    by_regions = deformed_by(face, "regions")
    assert by_regions.tree is None
    plain, moved = Poser(face, ALL), poser_for(by_regions, ALL)
    row = np.zeros(len(ALL))
    row[ALL.index("jawOpen")] = 0.6
    one, other = plain.pose(row).parts[0].vertices, moved.pose(row).parts[0].vertices
    front = (face.part("skin").vertices[:, 2] > 0) & (face.part("skin").vertices[:, 1] > -100)
    assert np.sqrt(((one - other) ** 2).sum(1)[front].mean()) < 1.5
    teeth = [part.name for part in face.parts].index("teeth_lower")
    np.testing.assert_array_equal(plain.pose(row).parts[teeth].vertices, moved.pose(row).parts[teeth].vertices)


def test_faces_without_sites_and_wrong_numbers_of_markers_are_refused(deformer: RegionDeformer) -> None:
    with pytest.raises(InputError, match="lies elsewhere than on a face"):
        RegionDeformer(tiny_face())
    with pytest.raises(InputError, match=r"expected \(208 markers, 3 coordinates\), got \(3, 3\)"):
        deformer.offsets(np.zeros((3, 3)))
