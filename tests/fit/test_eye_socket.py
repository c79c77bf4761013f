"""What lies behind the lids turns about the eyeball."""

from __future__ import annotations

import numpy as np

from mien.fit.eye_socket import Socket


def test_the_skin_behind_a_lid_turns_with_it_and_keeps_its_distance() -> None:
    angle = np.radians(np.linspace(-40, 40, 9))
    upper = 12.0 * np.stack([np.sin(angle), np.full(9, 0.5), np.cos(angle)], axis=1)
    lower = upper * [1, -1, 1]
    deep = np.array([[0.0, 11.0, -2.0], [3.0, 9.0, -8.0], [0.0, 10.0, 6.0]])
    turn = np.array([0.1, 0.0, 0.0])  # down over the eyeball
    moves = np.vstack([np.cross(turn, upper), np.zeros_like(lower), np.zeros_like(deep)])
    depth, share = np.array([8.0, 16.0, 1.0]), np.ones(3)
    lids = ((np.arange(9), upper), (np.arange(9, 18), lower))
    Socket(np.arange(18, 21), deep, depth, share, lids).turn(moves)
    found = moves[18:]
    assert np.allclose(np.einsum("nd,nd->n", found, deep), 0, atol=1e-9)  # neither nearer nor farther
    assert found[0, 2] > 0.3  # the top comes forward
    assert found[1, 1] > 0.2  # and what is behind goes up, as on a ball
    whole = np.linalg.norm(np.cross(turn, deep), axis=1)
    share_of = np.linalg.norm(found, axis=1) / whole
    assert share_of[1] < share_of[0] < 0.7


def test_a_still_lid_moves_nothing() -> None:
    moves = np.zeros((9, 6))
    arm = np.random.default_rng(0).normal(size=(6, 3))
    lids = ((np.arange(3), arm[:3]), (np.arange(3, 6), arm[3:]))
    Socket(np.arange(6, 9), arm[:3], np.full(3, 5.0), np.full(3, 0.5), lids).turn(moves)
    assert not moves.any()
