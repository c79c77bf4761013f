"""Folds for the page: texels within the texture, driven by channels; none where the skin is another's."""

from __future__ import annotations

from base64 import b64decode

import numpy as np

from mien.face.folds import drawn_folds
from mien.serve.studio.page_folds import folds_of_face


def test_folds_are_those_of_the_renderer_in_a_smaller_size() -> None:
    told = folds_of_face("default")
    folds = drawn_folds()[1]
    assert [one["drivers"] for one in told["folds"]] == [dict(fold.drivers) for fold in folds]
    for one, fold in zip(told["folds"], folds, strict=True):
        shade = np.zeros(told["size"] ** 2)
        shade[np.frombuffer(b64decode(one["texels"]), "<u4")] = np.frombuffer(b64decode(one["shade"]), np.int8) / 127
        smaller = fold.shade.reshape(512, 2, 512, 2).mean(axis=(1, 3))
        assert np.abs(shade.reshape(512, 512) - np.clip(smaller, -1, 1)).max() < 0.025, fold.name
