"""The expressive repertoire that needs no recordings: emotions performed in action units by a table made by hand.

Hand-made, not learned (``assets/performance/emotions``). Each emotion is a performance of a minute: units are
held, wander, swell in episodes with onset, hold and offset, and are never quite the same on both sides. The
performance goes through the same `ExpressionSpace` as a recording would: as displacements of the markers on the face,
with the channels carried beside them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.capture.layouts import load_layout
from mien.core import channels
from mien.core.derived import read_derived
from mien.core.emotions import emotion_sources, emotion_table, emotions
from mien.core.facs import action_units, channels_of_units, unit_track
from mien.core.poses import pose_vector
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.face.library import load_face
from mien.face.model import Face
from mien.face.retargeting import basis_at
from mien.motion.drift import smooth_drift
from mien.motion.expression.expression import Expression
from mien.motion.expression.expression_space import RATE, ExpressionSpace, ExpressiveMotion

__all__ = [
    "derived_axes",
    "hand_made_expression",
    "hand_made_performance",
    "hand_made_sources",
    "hand_made_space",
    "marker_basis",
    "sealed_share",
    "sources",
    "space_of",
    "spoken_share",
    "without_eyelids",
]

Floats = NDArray[np.float64]
LAYOUT = "face-102"
"""Markers on which the space of the hand-made repertoire is learned: a set like that of Deng et al. 2006."""
DERIVED = "expression_axes"
KNEE = 0.75
SETTLED = 2.0  # seconds at the start of a performance that are left out: nobody is caught in the middle of an onset


def hand_made_expression() -> Expression:
    """The expression model of performers without expressive recordings.

    Examples
    --------
    >>> hand_made_expression().names
    ('afraid', 'angry', 'contempt', 'disgusted', 'frustrated', 'happy', 'neutral', 'sad', 'surprised')
    """
    table = emotions()
    efforts = {name: float(entry["effort"]) for name, entry in table.items() if "effort" in entry}
    return Expression(tuple(table), space_of, sealed_share(), frozenset(table), efforts, spoken_share())


def spoken_share() -> dict[str, Floats]:
    """What each emotion adds to a speaking mouth, shape (channels,) each.

    Examples
    --------
    >>> "angry" in spoken_share()
    True
    """
    found = {}
    for name, entry in emotions().items():
        row = np.zeros(len(channels.ALL))
        for channel, weight in channels_of_units(entry.get("spoken", {})).items():
            row[channels.ALL.index(channel)] = weight
        found[name] = row
    return found


def sealed_share() -> Floats:
    """Share of each channel that remains while the lips must be shut, shape (channels,)."""
    share = np.ones(len(channels.ALL))
    for name, left in emotion_table()["sealed_share"].items():
        share[channels.ALL.index(name)] = left
    return share


@cache
def hand_made_space() -> ExpressionSpace:
    """The expression space of the hand-made repertoire."""
    return ExpressionSpace().fit(hand_made_sources())


@cache
def space_of(emotion: str) -> ExpressionSpace:
    """The part of `hand_made_space` that one emotion needs, by what is kept of the space (`derived_axes`)."""
    axes, performed = _axes(), hand_made_performance(emotion)
    curve = performed @ axes["axes"] + axes["offset"]
    return ExpressionSpace().restore({emotion: (curve,)}, {emotion: (performed,)})


@cache
def _axes() -> dict[str, Floats]:
    return read_derived(DERIVED, sources()) or derived_axes()


def sources() -> tuple[str, ...]:
    """Files of ``assets`` that the space is worked out from."""
    return (*emotion_sources(), "facs/units.toml", f"markers/{LAYOUT}.toml", "faces/default.npz")


def derived_axes() -> dict[str, Floats]:
    """`hand_made_space` as a map of channels: ``curve = performed @ axes + offset`` (see `mien.core.derived`)."""
    space = hand_made_space().space_
    basis = marker_basis(load_face("default"), LAYOUT, without_eyelids(LAYOUT))
    return {
        "axes": np.asarray((basis * space.weights_) @ space.axes_.T),
        "offset": np.asarray(-(space.mean_ * space.weights_) @ space.axes_.T),
    }


def hand_made_sources() -> dict[str, list[ExpressiveMotion]]:
    """All performances as expressive motion: displacements of markers on the default face, channels carried beside."""
    basis = marker_basis(load_face("default"), LAYOUT, without_eyelids(LAYOUT))
    found = {}
    for name in emotions():
        performed = hand_made_performance(name)
        found[name] = [ExpressiveMotion(performed @ basis, performed)]
    return found


def hand_made_performance(emotion: str) -> Floats:
    """One emotion performed for a minute at `RATE`, shape (samples, channels); the same bits at every call."""
    facts, entry = emotion_table()["performance"], emotions()[emotion]
    # The seed goes by the name, so that an emotion added to the table leaves the others as they are.
    random = np.random.default_rng([facts["seed"], *emotion.encode()])
    times = np.arange(round((facts["seconds"] + SETTLED) * RATE)) / RATE
    swells = _episodes(facts, entry["episodes"][0], times, random)
    units: dict[str, Floats] = {}
    for unit, (held, wander) in entry["units"].items():
        units |= _unit(unit, held, wander, facts, entry, times, swells, random)
    values = unit_track(
        ChannelTrack(tuple(units), np.stack(list(units.values()), axis=1), FrameRate.of(RATE))
    ).values.copy()
    head = pose_vector(entry["head"], f"the emotion {emotion}")
    turning = [channels.ALL.index(name) for name in channels.HEAD]
    values[:, turning] += head[turning] * (1 + 0.2 * _drifts(times, 3, facts["wander_time"]["head"], random))
    return np.asarray(values[round(SETTLED * RATE) :])


def _unit(
    unit: str,
    held: float,
    wander: float,
    facts: Mapping[str, Any],
    entry: Mapping[str, Any],
    times: Floats,
    swells: Floats,
    random: np.random.Generator,
) -> dict[str, Floats]:
    """The weight of a unit over time, for each of its sides where it has sides."""
    mouth = any(name in channels.MOUTH for name in action_units()[unit.rstrip("LR")].both)
    memory = facts["wander_time"]["mouth" if mouth else "upper"]
    late = float(np.clip(random.normal(0, facts["lag"]), -2 * facts["lag"], 2 * facts["lag"]))
    swell = np.interp(times - late, times, swells)
    weight = held * (1 + entry["episodes"][1] * swell) + wander * smooth_drift(times, memory, random)
    sway = facts["sway"] * smooth_drift(times, 2.0, random)
    if unit[-1] in "LR" or not action_units()[unit].left:
        return {unit: _kept_below_full(weight)}
    lean = (entry["lean"] + sway) / 2
    return {unit + "L": _kept_below_full(weight * (1 + lean)), unit + "R": _kept_below_full(weight * (1 - lean))}


def _kept_below_full(weight: Floats) -> Floats:
    """0 or more, and over `KNEE` ever slower towards 1: a muscle at its end still quivers."""
    over = np.maximum(weight - KNEE, 0.0)
    return np.asarray(np.clip(np.minimum(weight, KNEE) + (1 - KNEE) * np.tanh(over / (1 - KNEE)), 0.0, 1.0))


def _episodes(facts: Mapping[str, Any], per_minute: float, times: Floats, random: np.random.Generator) -> Floats:
    """How far the emotion has swollen: between its mean, 0, and the apex of an episode, shape (samples,)."""
    swell, now = np.zeros(len(times)), 0.0
    while now < times[-1]:
        onset, hold, offset = (float(random.uniform(*facts[name])) for name in ("onset", "hold", "offset"))
        rise = np.clip((times - now) / onset, 0, 1)
        fall = np.clip((times - now - onset - hold) / offset, 0, 1)
        swell = np.maximum(swell, np.sin(np.pi / 2 * rise) ** 2 * np.cos(np.pi / 2 * fall) ** 2)
        now += max(float(random.gamma(4.0, 60.0 / per_minute / 4.0)), onset + hold)
    return np.asarray(swell - swell.mean())


def _drifts(times: Floats, count: int, memory: float, random: np.random.Generator) -> Floats:
    return np.stack([smooth_drift(times, memory, random) for _ in range(count)], axis=1)


def without_eyelids(layout: str) -> tuple[str, ...]:
    """Markers of a layout that are not on the eyelids, in its order.

    Examples
    --------
    >>> len(load_layout("face-102").markers) - len(without_eyelids("face-102"))
    4
    """
    found = load_layout(layout)
    lids = {found.landmarks.get(number) for number in emotion_table()["performance"]["eyelids"]["landmarks"]}
    return tuple(name for name in found.markers if name not in lids)


def marker_basis(face: Face, layout: str, markers: Sequence[str]) -> Floats:
    """How far markers of a layout move for each channel at weight 1, shape (channels, markers * 3), mm.

    The head's turns are no motion of the face: their rows are zero.
    """
    from scipy.spatial import cKDTree

    found = load_layout(layout)
    skin = face.part("skin")
    _, vertices = cKDTree(skin.vertices).query(found.places[found.index(markers)])
    basis = basis_at(face, [(skin.name, int(vertex)) for vertex in vertices], channels.WEIGHTS)
    return np.concatenate([basis.reshape(len(basis), -1), np.zeros((len(channels.HEAD), basis.shape[1] * 3))])
