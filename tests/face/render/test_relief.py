"""The relief of skin."""

from __future__ import annotations

import numpy as np

from mien.face.render.relief import relief_share, tile


def test_the_tile_repeats_without_a_seam_and_has_pores():
    found = tile()
    inner = np.abs(np.diff(found, axis=0)).max(axis=(0, 1))
    across = np.abs(found[-1] - found[0]).max(axis=0)
    assert (across <= 1.2 * inner).all()
    assert found[:, :, 2].max() == 1
    assert np.abs(found[:, :, :2].mean(axis=(0, 1))).max() < 1e-3
    assert 0.05 < found[:, :, :2].std() < 0.5


def test_it_shows_only_where_a_pixel_is_small():
    assert [relief_share(each) for each in (1.0, 0.3, 0.05)] == [0.0, 0.0, 1.0]
    assert 0 < relief_share(0.2) < 1
