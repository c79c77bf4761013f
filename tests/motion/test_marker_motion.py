"""Recorded markers on faces: the default one, and one in other proportions that is found through its shapes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mien.capture.layouts import load_layout
from mien.core.channels import ARKIT
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from mien.face.library import load_face
from mien.face.model import Face, Target
from mien.face.retargeting import basis_at
from mien.motion.marker_motion import MarkerPairs, head_channels, retarget, skin_markers

LAYOUT = load_layout("face-102")
POSES = [{}, {"jawOpen": 0.6}, {"mouthSmileLeft": 0.8, "browInnerUp": 0.5}, {"eyeBlinkRight": 1.0}, {}]


@pytest.fixture(scope="module")
def face() -> Face:
    return load_face("default")


def stretched(face: Face) -> Face:
    parts = []
    for part in face.parts:
        targets = {n: Target(t.vertices, t.offsets * np.float32([1.2, 0.9, 1.0])) for n, t in part.targets.items()}
        parts.append(
            replace(part, name=f"x {part.name}", vertices=part.vertices * np.float32([1.2, 0.9, 1.0]), targets=targets)
        )
    return replace(
        face, parts=tuple(parts), sites={}, eyes=tuple(replace(eye, part=f"x {eye.part}") for eye in face.eyes)
    )


def recorded(face: Face) -> MarkerTrack:
    """Markers of the default face in `POSES`, held for six frames each."""
    places = skin_markers(face, LAYOUT, LAYOUT.markers)
    skin = face.part("skin")
    rest = np.array([skin.vertices[vertex] for _, vertex in places.sites], dtype=np.float64)
    basis = basis_at(face, places.sites, ARKIT)
    rows = [rest + sum(w * basis[ARKIT.index(n)] for n, w in pose.items()) for pose in POSES for _ in range(6)]
    return MarkerTrack(places.markers, np.array(rows), FrameRate.of(25))


@pytest.mark.parametrize("method", ["least-squares", "rbf"])
def test_markers_made_from_weights_bring_the_weights_back(face: Face, method: str) -> None:
    found = retarget(recorded(face), LAYOUT, face, method, rest=0)
    for number, pose in enumerate(POSES):
        row = dict(zip(found.channels.names, found.channels.values[6 * number + 3], strict=True))
        errors = np.array([abs(row[name] - pose.get(name, 0.0)) for name in found.used])
        assert errors.mean() < 0.01  # of single frames; lids have few markers in this layout
        assert errors.max() < 0.15
    assert {region.region for region in found.regions} == {"mouth", "upper", "lower"}
    assert max(region.missed for region in found.regions) < 0.5
    assert found.how == "same mesh"
    assert len(found.lines()) >= 4


def test_a_face_of_other_proportions_is_found_through_its_shapes(face: Face) -> None:
    other = stretched(face)
    places = skin_markers(other, LAYOUT, LAYOUT.markers)
    parts = {part.name: part for part in other.parts}
    found = np.array([parts[name].vertices[vertex] for name, vertex in places.sites])
    away = np.linalg.norm(found - LAYOUT.places * [1.2, 0.9, 1.0], axis=1)
    assert places.how == "transferred"
    assert np.median(away) < 3.0
    moved = retarget(recorded(face), LAYOUT, other, rest=0)
    jaw = moved.channels.channel("jawOpen")
    assert jaw[9] > 0.4
    assert jaw[27] < 0.05


def test_pairs_of_ones_own(face: Face, tmp_path: Path) -> None:
    motion = recorded(face)
    shown = motion.positions[[0, 9, 15, 21]] - motion.positions[0]
    weights = [[0.0, 0.0], [0.6, 0.0], [0.0, 0.8], [0.0, 0.0]]
    channels = ["jawOpen", "mouthSmileLeft"]
    np.savez(tmp_path / "p.npz", markers=list(motion.names), channels=channels, displacements=shown, weights=weights)
    pairs = MarkerPairs.read(tmp_path / "p.npz")
    found = retarget(motion, LAYOUT, face, "rbf", pairs, rest=0)
    assert found.channels.channel("jawOpen")[9] == pytest.approx(0.6, abs=0.02)
    assert found.channels.channel("mouthSmileLeft")[15] == pytest.approx(0.8, abs=0.02)
    with pytest.raises(InputError, match="pairs are for"):
        retarget(motion, LAYOUT, face, pairs=pairs)
    np.savez(
        tmp_path / "q.npz", markers=["a"], channels=["nonsense"], displacements=shown[:, :1], weights=np.zeros((4, 1))
    )
    with pytest.raises(InputError, match="are not channels"):
        MarkerPairs.read(tmp_path / "q.npz")
    (tmp_path / "r.npz").write_bytes(b"nothing")
    with pytest.raises(InputError, match=r"r\.npz"):
        MarkerPairs.read(tmp_path / "r.npz")


def test_what_does_not_fit_is_refused(face: Face) -> None:
    motion = recorded(face)
    with pytest.raises(InputError, match="method"):
        retarget(motion, LAYOUT, face, "magic")
    with pytest.raises(InputError, match="frame at rest"):
        retarget(motion, LAYOUT, face, rest=99)
    gap = motion.positions.copy()
    gap[3, 5] = np.nan
    with pytest.raises(InputError, match="not seen in frame 3"):
        retarget(MarkerTrack(motion.names, gap, motion.rate), LAYOUT, face, rest=0)
    bare = replace(face, parts=tuple(replace(part, name="y", targets={}) for part in face.parts[:1]), eyes=(), sites={})
    with pytest.raises(InputError):
        retarget(motion, LAYOUT, bare, rest=0)


def test_the_heads_motion_as_angles() -> None:
    from mien.face.posing import head_rotation

    angles = np.array([[0.0, 0.0, 0.0], [12.0, 4.0, -6.0], [-12.0, -4.0, 6.0]])
    head = np.tile(np.eye(4), (3, 1, 1))
    head[:, :3, :3] = [head_rotation(*row) for row in angles]
    found = np.column_stack(list(head_channels(head).values()))
    np.testing.assert_allclose(found, angles, atol=0.6)
