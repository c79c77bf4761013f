"""The shape of a person's head, as weights of the space of heads (baked by ``tools/bake_face/people.py``)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset

__all__ = ["drawn_features", "feature_names", "head_weights", "open_sky"]

_YOUNG, _OLD, _CHILD = 25.0, 90.0, 8.0  # years at which MakeHuman's characters of these names stand
_DRAWN, _SPREAD = 18, 0.36  # local features that a seed draws, and how far they go
_LIDS = 0.5  # how far lids vary beside the rest: whose eyes are half shut at rest, has none left to feel with
_ORIGINS = ("african", "asian", "caucasian")
# What MakeHuman's means lack to look like somebody: hand-made, by eye. For all, women, men, and the old, who frown.
_TOUCHES: tuple[dict[str, float], ...] = (
    {"eye-scale-incr": 0.42, "eye-height2-incr": 0.40, "mouth-scale-horiz-incr": 0.20, "mouth-angles-up": 0.25},
    {"eye-scale-incr": 0.28, "head-oval": 0.30, "chin-width-decr": 0.35, "chin-jaw-drop-decr": 0.25,
     "nose-scale-horiz-decr": 0.20, "mouth-upperlip-height-incr": 0.20, "mouth-lowerlip-height-incr": 0.20,
     "eyebrows-trans-backward": 0.45, "forehead-nubian-decr": 0.1, "neck-scale-horiz-decr": 0.35},
    {"chin-width-incr": 0.15, "measure-neck-circ-incr": 0.15, "eye-height1-incr": 0.40, "eye-height2-incr": 0.45},
    {"mouth-angles-up": 0.75, "eye-height2-incr": 0.25, "eye-height3-incr": 0.30, "eyebrows-angle-down": 0.22},
)  # fmt: skip

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Table:
    """Rows are weights of the space of heads.

    ``people``: (female and male, child young and old, origins, k); ``builds``: thin, heavy, weak, strong (4, k);
    ``features``: MakeHuman's local targets (names, k).
    """

    people: Floats
    builds: Floats
    names: tuple[str, ...]
    features: Floats
    open_sky: Floats


@cache
def _table() -> _Table:
    with np.load(asset("fitting/people.npz"), allow_pickle=False) as data:
        people, builds, features = (data[key].astype(np.float64) for key in ("people", "builds", "features"))
        return _Table(people, builds, tuple(str(n) for n in data["names"]), features, data["open_sky"] / 255.0)


def feature_names() -> tuple[str, ...]:
    """MakeHuman's local targets that a face can be given.

    Examples
    --------
    >>> "nose-width1-incr" in feature_names()
    True
    """
    return _table().names


def open_sky() -> Floats:
    """How much of the sky each vertex of the default skin sees, 0..1."""
    return _table().open_sky


def drawn_features(seed: int, variety: float = 1.0) -> dict[str, float]:
    """The local targets that make one face unlike the next of its kind, and how much of each.

    Examples
    --------
    >>> drawn_features(4) == drawn_features(4)
    True
    """
    chance = np.random.default_rng([seed, 2])
    names = feature_names()
    chosen = chance.choice(len(names), size=_DRAWN, replace=False)
    amounts = variety * _SPREAD * np.abs(chance.normal(size=_DRAWN))
    drawn = {names[number]: float(amount) for number, amount in zip(chosen, amounts, strict=True)}
    return {name: amount * (_LIDS if name.startswith("eye-height") else 1.0) for name, amount in drawn.items()}


def head_weights(
    sex: float,
    age: float,
    shares: Mapping[str, float],
    features: Mapping[str, float] | None = None,
    build: tuple[float, float] = (0.0, 0.0),
) -> Floats:
    """Weights of the space of heads, standard deviations, shape (k,).

    Parameters
    ----------
    sex : float
        0 male .. 1 female.
    age : float
        Years.
    shares : mapping
        Of the origins african, asian, caucasian.
    features : mapping, optional
        Local targets on top, and how much of each.
    build : tuple of 2 float
        Weight and muscle, -1..1.

    Examples
    --------
    >>> head_weights(1, 30, {"asian": 1}).shape
    (60,)
    """
    table = _table()
    old = float(np.clip((age - _YOUNG) / (_OLD - _YOUNG), 0, 1))
    child = float(np.clip((_YOUNG - age) / (_YOUNG - _CHILD), 0, 1))
    ages = np.array([child, 1 - old - child, old])
    mix = np.array([shares.get(origin, 0.0) for origin in _ORIGINS])
    weights = np.einsum("s,a,o,saok->k", np.array([sex, 1 - sex]), ages, mix / mix.sum(), table.people)
    for value, (less, more) in zip(build, ((0, 1), (2, 3)), strict=True):
        weights = weights + abs(value) * table.builds[less if value < 0 else more]
    shares_of_touches = (1.0, sex, 1 - sex, old)
    touched = [(n, s * a) for s, touches in zip(shares_of_touches, _TOUCHES, strict=True) for n, a in touches.items()]
    for name, amount in (*touched, *(features or {}).items()):
        weights = weights + amount * table.features[table.names.index(name)]
    return np.asarray(weights)
