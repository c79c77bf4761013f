import numpy as np
import pytest

from mien.capture.cleaning.groups import MarkerGroups, select, split
from mien.capture.cleaning.normalise import least_squares
from mien.core.errors import InputError
from tests.capture.cleaning.synthetic import GROUPS, MOUTH, REST, UPPER, column, head_motion, recorded, speaking


def test_a_performance_splits_into_head_upper_face_and_mouth() -> None:
    still, head = speaking(), head_motion()
    normalised = least_squares(recorded(still, head), GROUPS.rigid, REST)
    motion = split(normalised.track, normalised.head, GROUPS)
    np.testing.assert_allclose(motion.head, head, atol=1e-9)
    assert motion.upper_face.names == tuple(UPPER)
    assert motion.mouth.names == tuple(MOUTH)
    np.testing.assert_allclose(motion.mouth.positions[:, 0], still.positions[:, column("lip_u")], atol=1e-9)


def test_select_keeps_the_given_order() -> None:
    picked = select(speaking(), ["chin", "nose"])
    np.testing.assert_array_equal(picked.positions[:, 1], speaking().positions[:, column("nose")])


def test_groups_that_make_no_sense_are_refused() -> None:
    with pytest.raises(InputError, match="at least three rigid markers, got 2"):
        MarkerGroups(("a", "b"), (), (), "a", "b", "c", "d", "e")
    with pytest.raises(InputError, match=r"\['m'\] are in the upper face and in the mouth"):
        MarkerGroups(("a", "b", "c"), ("m",), ("m",), "a", "b", "c", "d", "e")
    with pytest.raises(InputError, match=r"expected shape \(120, 4, 4\), got \(3, 4, 4\)"):
        split(speaking(), np.zeros((3, 4, 4)), GROUPS)


def test_without_leaves_out_markers_but_not_the_roles() -> None:
    fewer = GROUPS.without(["chin", "nose"])
    assert "chin" not in fewer.mouth
    assert "nose" not in fewer.rigid
    assert fewer.nose == "nose"
