"""What was performed is what is captured: size, shape, closures, antagonists; and input that cannot be used."""

from __future__ import annotations

import numpy as np
import pytest

from mien.capture import capture_take, fit_person
from mien.capture.knowledge import knowledge
from mien.capture.layouts import load_layout
from mien.capture.person import Person
from mien.core.channels import WEIGHTS
from mien.core.errors import InputError
from mien.core.tracks import MarkerTrack
from mien.face.library import load_face
from tests.capture.performed import basis, channel, markers_of, weights_of

LAYOUT = load_layout("mediapipe-218")


@pytest.fixture(scope="module")
def person() -> Person:
    """The default face at rest, known to be that."""
    return fit_person([markers_of(weights_of(jawOpen=0.3))], LAYOUT, face=load_face("default"))


@pytest.mark.parametrize(
    "heights",
    [
        {"jawOpen": 0.5},
        {"mouthSmileLeft": 0.6, "mouthSmileRight": 0.6},
        {"mouthPucker": 0.7},
        {"mouthUpperUpLeft": 0.5, "mouthUpperUpRight": 0.5},
        {"browInnerUp": 0.8},
        {"browDownLeft": 0.6, "browDownRight": 0.6},
        {"eyeBlinkLeft": 1.0, "eyeBlinkRight": 1.0},
        {"eyeSquintLeft": 0.7, "cheekSquintLeft": 0.5},
        {"jawOpen": 0.4, "mouthPucker": 0.5},
        {"mouthLeft": 0.5},
    ],
    ids=lambda heights: "+".join(heights),
)
def test_what_was_performed_is_captured_in_size_and_shape(person: Person, heights: dict[str, float]) -> None:
    weights = weights_of(**heights)
    found = capture_take(markers_of(weights, noise=0.15), LAYOUT, head=person)
    for name in heights:
        true, got = channel(weights, name), found.channels.channel(name)
        assert np.corrcoef(true, got)[0, 1] > 0.95
        assert 0.9 < (true @ got) / (true @ true) < 1.1
    other = [n for n in found.sought if n not in heights]
    assert found.channels.select(other).values.mean() < 0.01


def test_of_two_antagonists_one_is_next_to_nothing(person: Person) -> None:
    rng = np.random.default_rng(1)
    weights = sum(weights_of(**{name: rng.uniform(0, 0.5)}) for name in person.channels)
    found = capture_take(markers_of(weights / 2, noise=0.3), LAYOUT, head=person).channels
    most = knowledge().most_of_both
    for one, other in knowledge().antagonists:
        assert (np.minimum(found.channel(one), found.channel(other)) <= most).all(), (one, other)


def test_lips_and_lids_are_shut_where_they_were(person: Person) -> None:
    weights = weights_of(jawOpen=0.5, eyeBlinkLeft=1.0, mouthSmileRight=0.3)
    weights[30, WEIGHTS.index("mouthClose")] = weights[30, WEIGHTS.index("jawOpen")]  # an /m/ in the middle of it
    track = markers_of(weights, noise=0.1)
    values = capture_take(track, LAYOUT, head=person).channels.values
    shown = np.einsum("tk,kmc->tmc", values, basis("mediapipe-218"))
    at = {number: track.names.index(LAYOUT.landmarks[number]) for number in (13, 14)}
    opening = shown[:, at[13], 1] - shown[:, at[14], 1]
    asked = track.positions[:, at[13], 1] - track.positions[:, at[14], 1]
    shut = asked - asked[:8].mean() < 0.7  # lips that touch have their landmarks a little past one another
    assert shut[30]
    assert np.abs(opening[shut]).max() < 0.3  # mm
    assert opening[25] > 8
    assert channel(values, "eyeBlinkLeft").max() > 0.95
    assert (channel(values, "mouthClose") <= channel(values, "jawOpen") + 1e-9).all()


def test_optical_markers_are_captured_too() -> None:
    weights = weights_of(jawOpen=0.5, mouthSmileLeft=0.5, mouthSmileRight=0.5)
    found = capture_take(markers_of(weights, "face-102", depth=1.0), "face-102", source="optical")
    for name in ("jawOpen", "mouthSmileLeft"):
        true, got = channel(weights, name), found.channels.channel(name)
        assert np.corrcoef(true, got)[0, 1] > 0.95
        assert 0.85 < (true @ got) / (true @ true) < 1.15


def test_the_same_bits_each_time(person: Person) -> None:
    track = markers_of(weights_of(jawOpen=0.5), noise=0.2)
    one, other = (capture_take(track, LAYOUT, head=person).channels.values for _ in range(2))
    assert one.tobytes() == other.tobytes()


def test_an_array_needs_its_layout_and_rate() -> None:
    with pytest.raises(InputError, match="layout= and fps="):
        capture_take(LAYOUT.places[None])
    with pytest.raises(InputError, match=r"expected \(frames, 218 markers"):
        capture_take(np.zeros((3, 5, 3)), "mediapipe-218", 25)
    with pytest.raises(InputError, match="expected a take, a MarkerTrack or an array"):
        capture_take("a take")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="expected numbers"):
        capture_take(np.full((2, 218, 3), "a"), "mediapipe-218", 25)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="in one place"):
        capture_take(np.zeros((5, 218, 3)), "mediapipe-218", 25)
    with pytest.raises(InputError, match="no frame"):
        capture_take(np.zeros((0, 218, 3)), "mediapipe-218", 25)
    with pytest.raises(InputError, match="source of markers"):
        capture_take(markers_of(weights_of()), LAYOUT, source="guess")


def test_recordings_with_many_holes_are_refused_and_few_are_filled(person: Person) -> None:
    track = markers_of(weights_of(jawOpen=0.5))
    few, many = track.positions.copy(), track.positions.copy()
    few[20:22] = np.nan
    many[20:50] = np.nan
    whole = capture_take(track, LAYOUT, head=person)
    filled = capture_take(MarkerTrack(track.names, few, track.rate), LAYOUT, head=person)
    assert 0 < filled.filled < 0.05
    assert np.abs(filled.channels.values - whole.channels.values).max() < 0.1
    with pytest.raises(InputError, match="of the marker positions are missing"):
        capture_take(MarkerTrack(track.names, many, track.rate), LAYOUT, head=person)


def test_markers_that_a_recording_lacks_are_done_without(person: Person) -> None:
    weights = weights_of(jawOpen=0.5)
    track = markers_of(weights, noise=0.1)
    positions = track.positions.copy()
    positions[:, track.names.index(LAYOUT.landmarks[61])] = np.nan  # a corner of the mouth, and with it the width
    found = capture_take(MarkerTrack(track.names[:-1], positions[:, :-1], track.rate), LAYOUT, head=person)
    assert np.abs(found.channels.channel("jawOpen") - channel(weights, "jawOpen")).max() < 0.05
    few = [track.names.index(LAYOUT.landmarks[number]) for number in (13, 14, 61, 291)]
    with pytest.raises(InputError, match="4 markers of the person are seen in this recording, 12 are needed"):
        capture_take(
            MarkerTrack([track.names[i] for i in few], track.positions[:, few], track.rate), LAYOUT, head=person
        )
