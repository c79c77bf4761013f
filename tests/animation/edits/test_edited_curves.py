import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mien.animation.edits import Anchor, ChannelEdit, EditLayer, Place, line_of
from mien.animation.edits.edited_curves import with_curves
from mien.animation.edits.layer import channel_range
from mien.core import channels
from mien.core.opposed_channels import OPPOSED, apart
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from tests.animation.edits.layers import LINE, curves, say

BASE = say(LINE)
RATE = FrameRate.of(50)


def track(seed: int = 0, seconds: float = BASE.duration) -> ChannelTrack:
    values = np.random.default_rng(seed).uniform(0, 1, (RATE.frames_covering(seconds), len(channels.ALL)))
    return ChannelTrack(channels.ALL, values, RATE)


def laid(*edits, on=BASE, base=None):
    return with_curves(EditLayer(edits), on, base or track(seconds=on.duration))


def test_a_key_that_replaces_is_met_exactly_and_fades():
    edit = ChannelEdit("jawOpen", "replace", ((Anchor(Place("never", 1, 1), 0.4), 0.35),), 0.04)
    result, lost, before = laid(edit)  # "never" begins at 0.3 s, 0.4 of its second phone is frame 22
    column, old = result.channel("jawOpen"), track().channel("jawOpen")
    assert column[22] == pytest.approx(0.35)
    assert column[21] == pytest.approx((0.35 + old[21]) / 2)
    assert np.array_equal(np.delete(column, [21, 22, 23]), np.delete(old, [21, 22, 23]))
    assert np.array_equal(before["jawOpen"], old)
    assert not lost


def test_what_is_added_is_added_between_the_keys():
    keys = ((Anchor(Place("never"), 0.0), 0.1), (Anchor(Place("said", 1, 2), 1.0), 0.1))
    base = ChannelTrack(channels.ALL, np.full((80, len(channels.ALL)), 0.5), RATE)
    result, _, _ = laid(ChannelEdit("browInnerUp", "add", keys, 0.0), base=base)
    column = result.channel("browInnerUp")
    assert column[16:50] == pytest.approx(0.6)
    assert column[:14] == pytest.approx(0.5)
    assert column[52:] == pytest.approx(0.5)


def test_each_key_has_its_own_tangent():
    shares = ((Place("never"), 0.0), (Place("never", 1, 2), 0.0), (Place("said"), 0.0), (Place("said", 1, 2), 0.0))
    keys = tuple((Anchor(*place), value) for place, value in zip(shares, (0.0, 0.8, 0.2, 0.6), strict=True))
    edit = ChannelEdit("jawOpen", "replace", keys, 0.0, "linear", ("flat", "step", None, "linear"))
    column = laid(edit)[0].channel("jawOpen")[15:46]  # keys stand at frames 15, 25, 35, 45
    assert column[1:3] == pytest.approx([0.0224, 0.0832], abs=1e-4)  # rises slowly: it leaves the first key flat
    assert column[10:20] == pytest.approx(0.8)
    assert np.diff(column[20:30]) == pytest.approx(0.04)


def test_the_head_turns_either_way():
    keys = ((Anchor(Place("i"), 0.0), -20.0), (Anchor(Place("said", 2, 2), 1.0), -20.0))
    base = ChannelTrack(channels.ALL, np.zeros((80, len(channels.ALL))), RATE)
    result, _, _ = laid(ChannelEdit("headYaw", "replace", keys), base=base)
    assert result.channel("headYaw")[40] == pytest.approx(-20)


def test_a_curve_goes_with_its_words_into_another_voice():
    edit = ChannelEdit(
        "jawOpen", "replace", ((Anchor(Place("said", 2), 0.0), 0.9), (Anchor(Place("said", 2, 2), 1.0), 0.9))
    )
    layer = EditLayer((edit,), line_of(BASE).line)
    slow = say(LINE, 0.2)
    start, end = slow.words.intervals[6].start, slow.words.intervals[6].end
    base = ChannelTrack(channels.ALL, np.zeros((RATE.frames_covering(slow.duration), len(channels.ALL))), RATE)
    result, lost, _ = with_curves(layer, slow, base)
    times = RATE.times(len(result))
    inside = (times >= start) & (times <= end)
    assert result.channel("jawOpen")[inside] == pytest.approx(0.9)
    assert (result.channel("jawOpen")[times < start - 0.11] == 0).all()
    assert not lost


@given(st.lists(curves(), max_size=5), st.integers(0, 3))
def test_edited_channels_stay_in_range_others_and_the_input_stay_as_they_are(edits, seed):
    base = track(seed)
    held = base.values.copy()
    result, _, before = laid(*edits, base=base)
    assert np.array_equal(base.values, held)
    edited = {edit.channel for edit in edits}
    opposed = {name for pair in OPPOSED if edited & set(pair) for name in pair}
    for number, name in enumerate(channels.ALL):
        column = result.values[:, number]
        if name not in edited | opposed:
            assert np.array_equal(column, held[:, number])
        elif name in before:
            least, most = channel_range(name)
            assert (column >= least).all()
            assert (column <= most).all()
    again, _, _ = laid(*edits, base=base)
    assert np.array_equal(again.values, result.values)


@given(st.lists(curves().filter(lambda edit: edit.mode == "add"), max_size=5), st.randoms(use_true_random=False))
def test_the_order_of_what_is_added_does_not_matter(edits, random):
    shuffled = list(edits)
    random.shuffle(shuffled)
    one, other = laid(*edits)[0], laid(*shuffled)[0]
    assert np.allclose(one.values, other.values, atol=1e-12)


@pytest.mark.parametrize("mode", ["add", "replace"])
def test_opposed_channels_give_way(mode):
    keys = ((Anchor(Place("never"), 0.0), 0.4), (Anchor(Place("said", 1, 2), 1.0), 0.4))
    left, right = (ChannelEdit(name, mode, keys, 0.1) for name in ("jawLeft", "jawRight"))
    start = track()
    base = ChannelTrack(start.names, apart(start.values, start.names), RATE)
    for edits in ((left,), (left, right)):
        result, lost, before = laid(*edits, base=base)
        assert np.minimum(result.channel("jawLeft"), result.channel("jawRight")).max() == 0.0
        assert [loss.why for loss in lost if "opposed" in loss.why] == [loss.why for loss in lost]
        assert len(lost) == len(edits) - 1
        assert all(np.array_equal(before[name], base.channel(name)) for name in ("jawLeft", "jawRight"))
