"""Speech by one camera: the same lips over a jaw that is less open than a tracker's chin says."""

from __future__ import annotations

import numpy as np
import pytest

from mien.capture import capture_take, fit_person
from mien.capture.layouts import load_layout
from mien.capture.one_camera import believed, reported_depth
from mien.capture.person import Person
from mien.core.tracks import ChannelTrack
from mien.face.library import load_face
from mien.metrics.face_track import shown_landmarks
from tests.capture.performed import markers_of, weights_of

LAYOUT = load_layout("mediapipe-218")


@pytest.fixture(scope="module")
def person() -> Person:
    return fit_person([markers_of(weights_of(jawOpen=0.3))], LAYOUT, face=load_face("default"))


def opening(track: ChannelTrack) -> np.ndarray:
    shown = shown_landmarks(track)
    upper, lower = (shown.names.index(LAYOUT.landmarks[number]) for number in (13, 14))
    return shown.positions[:, upper, 1] - shown.positions[:, lower, 1]


def test_the_lips_do_what_the_jaw_does_not(person: Person) -> None:
    markers = markers_of(weights_of(jawOpen=0.3), noise=0.1)
    seen, spoken = (capture_take(markers, LAYOUT, head=person, spoken=s).channels for s in (False, True))
    jaws = [track.channel("jawOpen").max() for track in (seen, spoken)]
    assert jaws[1] < 0.65 * jaws[0]
    assert spoken.channel("mouthLowerDownLeft").max() > 0.4
    assert np.abs(opening(seen) - opening(spoken)).max() < 1.5
    assert np.corrcoef(opening(seen), opening(spoken))[0, 1] > 0.99


def test_a_mouth_that_is_wide_open_keeps_its_jaw(person: Person) -> None:
    markers = markers_of(weights_of(jawOpen=0.9))
    jaws = [capture_take(markers, LAYOUT, head=person, spoken=s).channels.channel("jawOpen").max() for s in (0, 1)]
    assert jaws[1] > 0.75 * jaws[0]


def test_believed_jaws_grow_with_those_reported() -> None:
    jaw = np.linspace(0, 1, 101)
    found, close = believed(jaw, np.zeros_like(jaw))
    assert (np.diff(found) > 0).all()
    assert (found <= jaw).all()
    assert not close.any()


def test_what_optical_markers_show_is_believed() -> None:
    person = fit_person([markers_of(weights_of(jawOpen=0.3), depth=1.0)], LAYOUT, "optical", face=load_face("default"))
    markers = markers_of(weights_of(jawOpen=0.3), depth=1.0)
    one, other = (capture_take(markers, LAYOUT, head=person, spoken=s).channels.values for s in (False, True))
    np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("depth", [0.1, 0.6])
def test_how_much_depth_is_reported_is_measured(person: Person, depth: float) -> None:
    tracks = [markers_of(weights_of(jawOpen=0.3, mouthPucker=0.4), depth=depth, noise=0.05)]
    assert reported_depth(person, tracks) == pytest.approx(depth, abs=0.15)
