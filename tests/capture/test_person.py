"""Whom a recording shows: neutral face, head, noise."""

from __future__ import annotations

import numpy as np
import pytest

from mien.capture.capture import capture_take
from mien.capture.layouts import load_layout
from mien.capture.person import fit_person, neutral_markers
from mien.capture.person_file import arrays_of, person_from, stamp_of
from mien.core.channels import WEIGHTS
from mien.core.errors import InputError
from mien.core.tracks import MarkerTrack
from mien.face.head_reshaping import reshaped_face
from mien.face.head_space import head_space
from mien.face.library import load_face
from mien.face.marker_sites import place_markers
from mien.face.retargeting import basis_at
from tests.capture.performed import RATE, markers_of, weights_of

LAYOUT = load_layout("mediapipe-218")


def test_the_neutral_face_has_shut_lips_and_open_eyes() -> None:
    track = markers_of(weights_of(jawOpen=0.5, eyeBlinkLeft=1.0, browInnerUp=0.3), noise=0.1)
    assert np.abs(neutral_markers(track.positions, track.names, LAYOUT) - LAYOUT.places).max() < 0.3


def test_a_head_of_the_space_is_found_again_and_its_channels_with_it() -> None:
    space = head_space()
    true = reshaped_face(space, space.shape(np.random.default_rng(3).normal(size=20)), "made").face
    placed = place_markers(true, LAYOUT)
    moves = basis_at(true, placed.sites, WEIGHTS)
    motion = np.einsum("tk,kmc->tmc", weights_of(jawOpen=0.5), moves) * [1.0, 1.0, 0.1]
    person = fit_person([MarkerTrack(LAYOUT.markers, 1.1 * (placed.places + motion), RATE)], LAYOUT)
    size = np.cbrt(np.linalg.det(person.turn)) * 1.1
    columns = [LAYOUT.markers.index(name) for name in person.markers]
    for name in ("eyeBlinkLeft", "browInnerUp", "browDownRight"):
        found = person.basis[person.channels.index(name)][:, 1] / size
        wanted = moves[WEIGHTS.index(name)][columns, 1]
        assert (found @ wanted) / (wanted @ wanted) == pytest.approx(1.0, abs=0.1)
    assert len(person.head) >= 20


def test_a_chin_of_which_half_is_seen_still_tells_an_open_jaw() -> None:
    track = markers_of(weights_of(jawOpen=0.5))
    chin = track.positions[0, :, 1] < -85
    positions = track.positions.copy()
    positions[:, chin] = positions[0, chin] + 0.5 * (positions[:, chin] - positions[0, chin])
    halved = MarkerTrack(track.names, positions, RATE)
    person = fit_person([halved], LAYOUT, face=load_face("default"))
    found = capture_take(halved, LAYOUT, head=person).channels
    assert found.channel("jawOpen").max() == pytest.approx(0.5, abs=0.05)
    assert found.channel("mouthLowerDownLeft").max() < 0.1
    jaws = [
        person.basis[person.channels.index("jawOpen")]
        for person in (
            fit_person([track], LAYOUT, source, face=load_face("default")) for source in ("tracker", "optical")
        )
    ]
    assert np.allclose(*jaws)  # a chin that comes along is left as it is


def test_noise_is_measured() -> None:
    person = fit_person([markers_of(weights_of(jawOpen=0.4), noise=0.2)], LAYOUT, face=load_face("default"))
    assert np.median(person.noise) == pytest.approx(0.2, rel=0.2)


def test_a_person_is_kept_as_arrays() -> None:
    person = fit_person([markers_of(weights_of(jawOpen=0.4))], LAYOUT, face=load_face("default"))
    again = person_from({name: np.array(array) for name, array in arrays_of(person).items()})
    assert stamp_of(again) == stamp_of(person)
    assert again.openings[0].opening == person.openings[0].opening


def test_too_few_or_other_markers_are_refused() -> None:
    track = markers_of(weights_of(jawOpen=0.5))
    few = [LAYOUT.landmarks[n] for n in (13, 14, 61, 291, 152)]
    columns = [track.names.index(name) for name in few]
    small = MarkerTrack(few, track.positions[:, columns], track.rate)
    with pytest.raises(InputError, match="12 or more are needed"):
        fit_person([small], LAYOUT)
    with pytest.raises(InputError, match="the same markers in the same order"):
        fit_person([track, small], LAYOUT)
    with pytest.raises(InputError, match="at least one recording"):
        fit_person([], LAYOUT)
    with pytest.raises(InputError, match="no frame shows both lips"):
        fit_person([MarkerTrack(track.names, track.positions * np.nan, track.rate)], LAYOUT)
    with pytest.raises(InputError, match="neutral face of 218 markers"):
        fit_person([track], LAYOUT, neutral=np.zeros((3, 3)))
