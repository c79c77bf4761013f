"""The picture of an expression space."""

from __future__ import annotations

import numpy as np
import pytest

from mien.inspection.expression_picture import draw_expression_space, kept_variance
from mien.motion.expression.expression_space import RATE, ExpressionSpace, ExpressiveMotion


def space() -> ExpressionSpace:
    times = np.arange(1300) / RATE
    motion = np.stack(
        [6 * np.sin(2 * times), 3 * np.cos(3 * times), np.sin(5 * times), 0.2 * np.cos(9 * times)], axis=1
    )
    stretch = {
        name: [ExpressiveMotion(motion + offset, motion[:, :1])] for name, offset in (("happy", 0.0), ("sad", 4.0))
    }
    return ExpressionSpace().fit(stretch)


def test_shares_of_the_components_add_up_to_what_is_kept() -> None:
    kept = kept_variance(space())
    assert kept.shape == (3,)
    assert (np.diff(kept) <= 0).all()
    assert kept.sum() == pytest.approx(space().space_.share_)


def test_every_emotion_is_drawn_in_a_colour_of_its_own() -> None:
    picture = np.asarray(draw_expression_space(space()))
    curves = picture[70:560, 30:600].reshape(-1, 3)
    for colour in ((213, 94, 0), (0, 114, 178)):
        assert (np.abs(curves.astype(int) - colour).sum(axis=1) < 120).sum() > 100
