"""The fast kernel against plain descent on the same cost."""

from __future__ import annotations

import numpy as np

from mien.capture.kernel import descend


def descended_plainly(gram, goal, upper, steady, openings, open_goal, open_weight, rounds=40_000):  # type: ignore[no-untyped-def]
    """Projected gradient steps, all weights at once: slow, and nothing to get wrong."""
    weights = np.zeros_like(goal)
    most = np.linalg.eigvalsh(gram)[-1] + open_weight.max() * (openings**2).sum() + 4 * steady.max()
    for _ in range(rounds):
        slope = weights @ gram - goal
        slope += (open_weight * (weights @ openings.T - open_goal)) @ openings
        change = np.diff(weights, axis=0) * steady[1:]
        slope[1:] += change
        slope[:-1] -= change
        weights = np.clip(weights - slope / most, 0.0, upper)
    return weights


def test_the_kernel_finds_what_plain_descent_finds() -> None:
    rng = np.random.default_rng(0)
    frames, channels, markers = 12, 7, 20
    basis = rng.normal(size=(channels, markers))
    openings = rng.normal(size=(2, channels))
    problem = (
        basis @ basis.T + 0.1 * np.eye(channels),
        rng.normal(size=(frames, markers)) @ basis.T + rng.uniform(0, 8, (frames, 1)),
        rng.uniform(0.2, 1.0, (frames, channels)),
        rng.uniform(0, 5, (frames, channels)),
        openings,
        rng.normal(size=(frames, 2)),
        rng.uniform(0, 30, (frames, 2)),
    )
    found = np.zeros((frames, channels))
    sweeps = descend(*problem, found, 1e-10, 5000)
    assert sweeps < 5000
    wanted = descended_plainly(*problem)
    for bound in (np.zeros_like(found), problem[2]):
        assert (wanted == bound).any()
        assert (wanted != bound).any()
    assert np.abs(found - wanted).max() < 1e-5
