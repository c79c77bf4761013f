"""Which markers and which frames are scored."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.capture.layouts import load_layout
from mien.core.errors import InputError
from mien.core.timeline import Tier
from mien.core.tracks import MarkerTrack
from mien.metrics.scored_takes import prepare
from mien.metrics.sites import mouth_sites
from tests.metrics.synthetic import LAYOUT, MOUTH, spoken


def test_the_mouth_of_the_landmarks_is_that_of_the_scoring_rule() -> None:
    sites = mouth_sites(LAYOUT, LAYOUT.markers)
    assert (len(sites.mouth), len(sites.lips), sites.inner) == (48, 40, True)
    number = {name: landmark for landmark, name in LAYOUT.landmarks.items()}
    named = [number[LAYOUT.markers[place]] for place in (*sites.opening, *sites.width)]
    assert named == [13, 14, 61, 291]
    assert {number[LAYOUT.markers[place]] for place in set(sites.mouth) - set(sites.lips)} == {
        152, 175, 199, 200, 148, 377, 176, 400,
    }  # fmt: skip


def test_a_part_of_the_markers_is_found_by_name_in_any_order() -> None:
    names = tuple(reversed(MOUTH))
    sites = mouth_sites(LAYOUT, names)
    assert len(sites.mouth) == 48
    assert [names[place] for place in sites.opening] == ["2.2", "2.3"]


@pytest.mark.parametrize("name", ["mpeg4-32", "face-102", "expression-109"])
def test_layouts_without_inner_lips_open_at_the_outer_ones(name: str) -> None:
    layout = load_layout(name)
    sites = mouth_sites(layout, layout.markers)
    assert not sites.inner
    assert [layout.markers[place] for place in (*sites.opening, *sites.width)] == ["8.1", "8.2", "8.4", "8.3"]
    assert set(sites.mouth) == {layout.markers.index(marker) for marker in layout.groups["mouth"]}
    assert "2.1" not in {layout.markers[place] for place in sites.lips}


def test_a_layout_without_lips_is_refused() -> None:
    with pytest.raises(InputError, match="lacks the middles of the upper and the lower lip: scoring needs"):
        mouth_sites(LAYOUT, ["8.3", "8.4"])
    with pytest.raises(InputError, match="lacks the corners of the mouth"):
        mouth_sites(LAYOUT, ["2.2", "2.3"])


def test_frames_from_two_before_the_first_phone_to_two_after_the_last() -> None:
    recording = prepare(spoken("a", ("ma",)))  # speech from 0.40 to 0.72 s: frames 10 to 18
    assert np.flatnonzero(recording.speech).tolist() == list(range(8, 21))
    assert recording.first_phone == 0.4


def test_frames_that_were_not_seen_whole_are_not_scored() -> None:
    take = spoken("a", ("ma",))
    positions = take.markers.positions.copy()
    positions[12, 3] = np.nan
    recording = prepare(replace(take, markers=MarkerTrack(MOUTH, positions, take.markers.rate)))
    assert not recording.speech[12]
    assert recording.speech.sum() == 12


def test_frames_inside_words() -> None:
    recording = prepare(spoken("a", ("ma", "tea", "ma")))  # words of 0.32 s from 0.40 s
    held = recording.times[recording.inside({"tea"})]
    assert held[0] == pytest.approx(0.72)
    assert held[-1] == pytest.approx(1.0)
    assert np.array_equal(recording.inside(()), recording.speech)


def test_takes_that_cannot_be_scored_are_refused_by_name() -> None:
    take = spoken("a", ("ma",))
    with pytest.raises(InputError, match="take 'a' holds no speech"):
        prepare(replace(take, phones=Tier("phones", ())))
    unseen = MarkerTrack(MOUTH, np.full_like(take.markers.positions, np.nan), take.markers.rate)
    with pytest.raises(InputError, match="take 'a': the mouth was not seen"):
        prepare(replace(take, markers=unseen))
    other = MarkerTrack(("9.3",), take.markers.positions[:, :1], take.markers.rate)
    with pytest.raises(InputError, match="take 'a': layout 'mediapipe-218' lacks"):
        prepare(replace(take, markers=other))
