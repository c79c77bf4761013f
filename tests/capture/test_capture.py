import numpy as np
import pytest

from mien.capture import capture_take, fit_person
from mien.capture.layouts import load_layout
from mien.core.channels import WEIGHTS
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from mien.face.library import load_face
from mien.face.marker_sites import place_markers
from mien.face.retargeting import basis_at

LAYOUT = load_layout("mediapipe-218")
FRAMES = 60


def performed(**curves):
    """Markers of the default face, depth flattened, that performs these channels; rest at the start and at the end."""
    placed = place_markers(load_face("default"), LAYOUT)
    basis = basis_at(load_face("default"), placed.sites, WEIGHTS)
    weights = np.zeros((FRAMES, len(WEIGHTS)))
    swell = np.sin(np.linspace(0, np.pi, FRAMES - 20)) ** 2
    for name, height in curves.items():
        weights[10:-10, WEIGHTS.index(name)] = height * swell
    motion = np.einsum("tk,kmc->tmc", weights, basis) * [1.0, 1.0, 0.1]
    return MarkerTrack(LAYOUT.markers, LAYOUT.places + motion, FrameRate.of(25)), weights


@pytest.mark.parametrize(
    ("curves", "least"),
    [
        ({"jawOpen": 0.5}, 0.99),
        ({"mouthSmileLeft": 0.6, "mouthSmileRight": 0.6}, 0.97),
        ({"browInnerUp": 0.8}, 0.97),
        ({"browDownLeft": 0.6, "browDownRight": 0.6}, 0.97),
        ({"eyeBlinkLeft": 1.0, "eyeBlinkRight": 1.0}, 0.97),
    ],
)
def test_what_was_performed_is_captured_in_size_and_shape(curves, least):
    track, weights = performed(**curves)
    found = capture_take(track, LAYOUT)
    for name in curves:
        true, got = weights[:, WEIGHTS.index(name)], found.channels.channel(name)
        assert np.corrcoef(true, got)[0, 1] > least
        assert 0.85 < (true @ got) / (true @ true) < 1.15


def test_an_array_needs_its_layout_and_rate():
    with pytest.raises(InputError, match="layout= and fps="):
        capture_take(LAYOUT.places[None])
    with pytest.raises(InputError, match=r"expected \(frames, 218 markers"):
        capture_take(np.zeros((3, 5, 3)), "mediapipe-218", 25)


def test_recordings_with_many_holes_are_refused_and_few_are_filled():
    track, _ = performed(jawOpen=0.5)
    few, many = track.positions.copy(), track.positions.copy()
    few[20:22] = np.nan
    many[20:50] = np.nan
    whole = capture_take(track, LAYOUT)
    filled = capture_take(MarkerTrack(track.names, few, track.rate), LAYOUT, head=whole.person)
    assert 0 < filled.filled < 0.05
    assert np.abs(filled.channels.values - whole.channels.values).max() < 0.1
    with pytest.raises(InputError, match="of the marker positions are missing"):
        capture_take(MarkerTrack(track.names, many, track.rate), LAYOUT, head=whole.person)


def test_too_few_markers_are_refused():
    track, _ = performed(jawOpen=0.5)
    few = [LAYOUT.landmarks[n] for n in (13, 14, 61, 291, 152)]
    columns = [track.names.index(name) for name in few]
    with pytest.raises(InputError, match="12 or more are needed"):
        fit_person([MarkerTrack(few, track.positions[:, columns], track.rate)], LAYOUT)
