"""The table of what the solver knows."""

from __future__ import annotations

from mien.capture.knowledge import knowledge, source_named
from mien.capture.layouts import load_layout
from mien.core.channels import ARKIT


def test_the_table_names_channels_that_there_are() -> None:
    known = knowledge()
    assert {name for pair in known.antagonists for name in pair} <= set(ARKIT)
    assert all(region.hears for region in known.regions)
    assert {o.shut_by for o in known.openings if o.shut_by} == {"eyeBlinkLeft", "eyeBlinkRight"}
    assert set(known.channels["tracker"]) < set(known.channels["optical"])


def test_sides_are_treated_alike() -> None:
    def other(name: str) -> str:
        return name.replace("Left", "?").replace("Right", "Left").replace("?", "Right")

    pairs = {frozenset(pair) for pair in knowledge().antagonists}
    assert {frozenset(map(other, pair)) for pair in pairs} == pairs
    for region in knowledge().regions:
        assert {other(name) for name in region.hears} == set(region.hears)


def test_every_part_of_the_face_has_its_markers() -> None:
    layout = load_layout("mediapipe-218")
    found = knowledge().regions_at(layout.places)
    assert {knowledge().regions[n].name for n in found if n >= 0} == {region.name for region in knowledge().regions}
    lips = [layout.markers.index(layout.landmarks[number]) for number in (13, 14, 61, 291, 0, 17)]
    assert {knowledge().regions[found[i]].name for i in lips} == {"lips"}


def test_a_tracker_sees_little_depth() -> None:
    assert source_named("tracker").gain[2] == 0.1
    assert source_named("optical").gain == (1.0, 1.0, 1.0)
