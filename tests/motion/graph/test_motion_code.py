from __future__ import annotations

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.motion.graph.motion_code import MotionCode

RANDOM = np.random.default_rng(2)
SOURCES = np.stack(
    [np.sin(np.arange(3000) * 0.11), RANDOM.uniform(-1, 1, 3000), np.sign(np.sin(np.arange(3000) * 0.013))], axis=1
)
MIXING = RANDOM.standard_normal((3, 12)) * [[5.0], [3.0], [2.0]]
MOTION = SOURCES @ MIXING + 7.0


def test_mixed_sources_are_told_apart() -> None:
    code = MotionCode(1.0).fit(MOTION)
    found = code.separate(code.encode(MOTION))
    assert np.allclose(code.mix(found), code.encode(MOTION))
    likeness = np.abs(np.corrcoef(found.T, SOURCES.T)[:3, 3:])
    assert (likeness.max(axis=1) > 0.99).all()
    assert sorted(likeness.argmax(axis=1)) == [0, 1, 2]
    assert np.allclose(found.std(axis=0), 1, atol=0.02)


def test_all_of_the_variance_gives_the_motion_back() -> None:
    code = MotionCode(1.0).fit(MOTION)
    assert np.allclose(code.decode(code.encode(MOTION)), MOTION)


def test_no_more_components_are_kept_than_the_share_asks_for() -> None:
    noisy = MOTION + 0.1 * RANDOM.standard_normal(MOTION.shape)
    shares = [MotionCode(share).fit(noisy) for share in (0.5, 0.95, 0.9999)]
    counts = [len(code.mixing_) for code in shares]
    assert counts == sorted(counts)
    assert counts[1] <= 3 < counts[2]
    for code in shares:
        centred = noisy - noisy.mean(axis=0)
        left = ((noisy - code.decode(code.encode(noisy))) ** 2).sum() / (centred**2).sum()
        assert 1 - left == pytest.approx(code.share_)
        assert code.share_ >= code.share


def test_distances_of_components_are_distances_of_markers() -> None:
    code = MotionCode(1.0).fit(MOTION)
    one, other = code.encode(MOTION[:1]), code.encode(MOTION[50:51])
    assert np.linalg.norm(one - other) == pytest.approx(np.linalg.norm(MOTION[0] - MOTION[50]))


def test_the_same_seed_gives_the_same_bits_and_poor_motion_is_coded_all_the_same() -> None:
    assert np.array_equal(MotionCode().fit(MOTION).mixing_, MotionCode().fit(MOTION).mixing_)
    for data in (np.ones((5, 6)), RANDOM.standard_normal((4, 6)), RANDOM.standard_normal((500, 6))):
        code = MotionCode(1.0).fit(data)
        assert np.allclose(code.decode(code.encode(data)), data)


def test_what_cannot_be_coded_is_refused() -> None:
    for data in (np.ones((1, 6)), np.full((5, 6), np.nan)):
        with pytest.raises(InputError, match="two or more frames"):
            MotionCode().fit(data)
    with pytest.raises(InputError, match="share of variance"):
        MotionCode(0.0)
