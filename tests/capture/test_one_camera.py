"""Speech by one camera: lips tell how far the jaw is open, and round lips part by a funnel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.capture import capture_take, fit_person
from mien.capture.layouts import load_layout
from mien.capture.one_camera import believed, reported_depth, reported_raising
from mien.capture.person import Person
from mien.core.channels import WEIGHTS
from mien.core.tracks import ChannelTrack, MarkerTrack
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


PARTED = {f"{lip}{side}": 0.6 for lip in ("mouthUpperUp", "mouthLowerDown") for side in ("Left", "Right")}


def spoken(person: Person, **weights: float) -> tuple[MarkerTrack, ChannelTrack]:
    markers = markers_of(weights_of(**weights), noise=0.1)
    return markers, capture_take(markers, LAYOUT, head=person, spoken=True).channels


def test_open_lips_have_an_open_jaw(person: Person) -> None:
    _, found = spoken(person, jawOpen=0.3)
    assert found.channel("jawOpen").max() == pytest.approx(0.3, rel=0.15)
    assert found.channel("mouthLowerDownLeft").max() < 0.3


def test_lips_that_part_over_shut_teeth_leave_the_jaw_shut(person: Person) -> None:
    markers, found = spoken(person, jawOpen=0.03, **PARTED)
    seen = capture_take(markers, LAYOUT, head=person).channels
    assert found.channel("jawOpen").max() < 0.1
    assert found.channel("mouthLowerDownLeft").max() > 0.4
    assert np.corrcoef(opening(seen), opening(found))[0, 1] > 0.99
    assert np.abs(opening(seen) - opening(found)).max() < 1.5


def test_a_jaw_is_never_more_open_than_reported(person: Person) -> None:
    weights = np.random.default_rng(1).uniform(0, 0.5, (50, len(person.channels)))
    jaw, close = believed(person, weights)
    assert (jaw <= weights[:, person.channels.index("jawOpen")]).all()
    assert (close <= jaw).all()
    assert (close >= 0).all()


def test_a_mouth_that_is_wide_open_keeps_its_jaw(person: Person) -> None:
    markers = markers_of(weights_of(jawOpen=0.9))
    jaws = [capture_take(markers, LAYOUT, head=person, spoken=s).channels.channel("jawOpen").max() for s in (0, 1)]
    assert jaws[1] > 0.75 * jaws[0]


def test_round_lips_part_by_a_funnel(person: Person) -> None:
    markers, found = spoken(person, jawOpen=0.15, mouthPucker=0.45)
    seen = capture_take(markers, LAYOUT, head=person).channels
    assert found.channel("mouthFunnel").max() > 0.1
    assert found.channel("jawOpen").max() < 0.12
    assert np.abs(opening(seen) - opening(found)).max() < 1.0


def test_what_optical_markers_show_is_believed() -> None:
    person = fit_person([markers_of(weights_of(jawOpen=0.3), depth=1.0)], LAYOUT, "optical", face=load_face("default"))
    markers = markers_of(weights_of(jawOpen=0.3), depth=1.0)
    one, other = (capture_take(markers, LAYOUT, head=person, spoken=s).channels.values for s in (False, True))
    np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("depth", [0.1, 0.6])
def test_how_much_depth_is_reported_is_measured(person: Person, depth: float) -> None:
    tracks = [markers_of(weights_of(jawOpen=0.3, mouthPucker=0.4), depth=depth, noise=0.05)]
    assert reported_depth(person, tracks) == pytest.approx(depth, abs=0.15)


def test_an_opening_that_a_tracker_lays_on_the_upper_lip_is_the_jaws(person: Person) -> None:
    weights = weights_of(jawOpen=0.4)
    markers = markers_of(weights)
    upper = next(seen for seen in person.openings if seen.opening.name == "mouth").rows > 0
    split = markers.positions.copy()
    lips = [number for number, name in enumerate(markers.names) if name in np.array(person.markers)[upper]]
    split[:, lips, 1] += 0.3 * 30.0 * weights[:, WEIGHTS.index("jawOpen")][:, None]
    track = replace(markers, positions=split)
    assert reported_raising(person, [markers]) == 0.0
    assert reported_raising(person, [track]) == pytest.approx(0.2, abs=0.08)
    told = replace(person, raised=reported_raising(person, [track]))
    jaws = [
        capture_take(track, LAYOUT, head=one, spoken=True).channels.channel("jawOpen").max() for one in (person, told)
    ]
    assert jaws[0] + 0.05 < jaws[1] < 0.45
