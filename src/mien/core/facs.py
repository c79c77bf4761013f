"""Muscles by name: action units of the Facial Action Coding System as weights of channels.

An action unit is named ``AU12``, with ``L`` or ``R`` after it for one side of the face (the speaker's own) and, if
wanted, one of FACS's letters of intensity: ``AU12LC``. A weight of 1 is the unit at its strongest.

Units are not channels of their own: they are spelt in the channels of `mien.core.channels`, so that they reach every
face and every deformer by one way. ``assets/facs/units.toml`` holds the table, ``expressions.toml`` the basic
expressions.

References
----------
Ekman, P. & Friesen, W. V. (1978). Facial Action Coding System. Frydrych et al. (2003), Table 1: the units chosen there.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from mien.core.assets import asset_table
from mien.core.channels import ALL, WEIGHTS
from mien.core.errors import InputError, unknown_name
from mien.core.tracks import ChannelTrack

__all__ = [
    "ActionUnit",
    "action_units",
    "au_channels",
    "basic_expressions",
    "channels_of_units",
    "expression_channels",
    "is_unit",
    "missing_channels",
    "unit_track",
]

INTENSITIES: dict[str, float] = {"A": 0.1, "B": 0.3, "C": 0.5, "D": 0.75, "E": 1.0}
"""FACS's letters (trace, slight, marked, severe, maximum) as weights. Hand-made: FACS orders, it does not measure."""

_NAME = re.compile(r"(?:AU)?(\d+)([LR]?)([A-E]?)", re.IGNORECASE)
# ARKit has one channel for both inner brows; where the two sides are asked for alike, the one channel is used.
_JOINED = {"browInnerUp": ("browInnerUpLeft", "browInnerUpRight")}


@dataclass(frozen=True)
class ActionUnit:
    """One action unit.

    Attributes
    ----------
    code : str
        Such as ``AU12``.
    name, muscle : str
    both : mapping of str to float
        Weights of channels at full intensity.
    left, right : mapping of str to float
        The same for one side; empty where the unit has no sides.
    """

    code: str
    name: str
    muscle: str
    both: Mapping[str, float]
    left: Mapping[str, float]
    right: Mapping[str, float]


def _table(name: str) -> dict[str, Any]:
    return asset_table(f"facs/{name}")


@cache
def action_units() -> dict[str, ActionUnit]:
    """All units by code, in the order of their numbers.

    Examples
    --------
    >>> action_units()["AU12"].name
    'lip corner puller'
    """
    found = {}
    for code, facts in _table("units.toml").items():
        left = facts.get("left", {})
        right = {name.replace("Left", "Right"): weight for name, weight in left.items()}
        both = facts.get("both", left | right)
        for name in (*both, *left, *right):
            if name not in WEIGHTS:
                raise unknown_name(f"channel of {code} in facs/units.toml", name, WEIGHTS)
        found[code] = ActionUnit(code, facts["name"], facts["muscle"], both, left, right)
    return dict(sorted(found.items(), key=lambda entry: int(entry[0][2:])))


def is_unit(name: str) -> bool:
    """Whether a name is that of a known action unit, with or without a side.

    Examples
    --------
    >>> is_unit("AU12L"), is_unit("jawOpen"), is_unit("AU99")
    (True, False, False)
    """
    found = _NAME.fullmatch(name)
    return found is not None and f"AU{int(found[1])}" in action_units()


def au_channels(unit: str, weight: float = 1.0) -> dict[str, float]:
    """Channel weights that show one action unit.

    Parameters
    ----------
    unit : str
        ``AU12``, ``AU12L``, ``AU12R``; ``AU`` may be left out, and a letter A to E after it scales the weight.
    weight : float
        0..1.

    Raises
    ------
    InputError
        If there is no such unit, it has no sides, or the weight is out of range.

    Examples
    --------
    >>> au_channels("AU12L", 0.7)
    {'mouthSmileLeft': 0.7}
    >>> au_channels("AU1")
    {'browInnerUp': 1.0}
    >>> au_channels("AU12C")
    {'mouthSmileLeft': 0.5, 'mouthSmileRight': 0.5}
    """
    found = _NAME.fullmatch(str(unit).strip())
    units = action_units()
    if found is None or f"AU{int(found[1])}" not in units:
        raise unknown_name("action unit", str(unit), units)
    if not 0 <= weight <= 1:
        raise InputError(f"{unit}: the weight of an action unit runs from 0 to 1, not {weight:g}")
    known = units[f"AU{int(found[1])}"]
    side = found[2].upper()
    if side and not known.left:
        raise InputError(f"{known.code} ({known.name}) has no sides: write {known.code}, not {unit}")
    weight *= INTENSITIES.get(found[3].upper(), 1.0)
    chosen = {"": known.both, "L": known.left, "R": known.right}[side]
    return {name: share * weight for name, share in chosen.items()}


def channels_of_units(units: Mapping[str, float]) -> dict[str, float]:
    """Channel weights of several units at once: what units share adds up, no weight goes past 1.

    Raises
    ------
    InputError
        As `au_channels`.

    Examples
    --------
    >>> channels_of_units({"AU1L": 0.6, "AU1R": 0.4, "AU12": 0.5})
    {'browInnerUpLeft': 0.2, 'mouthSmileLeft': 0.5, 'mouthSmileRight': 0.5, 'browInnerUp': 0.4}
    """
    total: dict[str, float] = {}
    for unit, weight in units.items():
        for name, share in au_channels(unit, weight).items():
            total[name] = total.get(name, 0.0) + share
    for whole, (left, right) in _JOINED.items():
        shared = min(total.get(left, 0.0), total.get(right, 0.0))
        if shared > 0:
            total[whole] = total.get(whole, 0.0) + shared
            total[left], total[right] = total[left] - shared, total[right] - shared
    return {name: round(min(weight, 1.0), 12) for name, weight in total.items() if weight > 1e-12}


def unit_track(track: ChannelTrack) -> ChannelTrack:
    """A track of action units as a track of `mien.core.channels.ALL`.

    Parameters
    ----------
    track : ChannelTrack
        Columns named by units (0..1) or by channels, mixed as wanted.

    Raises
    ------
    InputError
        If a column is neither, or a weight of a unit is out of range (the frame is named).

    Examples
    --------
    >>> from mien.core.timeline import FrameRate
    >>> moved = unit_track(ChannelTrack(("AU12L", "headYaw"), [[0.5, 10.0]], FrameRate.of(25)))
    >>> float(moved.channel("mouthSmileLeft")[0]), float(moved.channel("headYaw")[0])
    (0.5, 10.0)
    """
    values = np.zeros((len(track), len(ALL)))
    for column, name in enumerate(track.names):
        given = track.values[:, column]
        if name in ALL:
            values[:, ALL.index(name)] += given
            continue
        outside = np.flatnonzero((given < 0) | (given > 1))
        if len(outside):
            raise InputError(
                f"{name}: the weight of an action unit runs from 0 to 1, not {given[outside[0]]:g} (frame {outside[0]})"
            )
        for channel, share in au_channels(name).items():
            values[:, ALL.index(channel)] += share * given
    for whole, (left, right) in _JOINED.items():
        columns = [ALL.index(left), ALL.index(right)]
        shared = np.clip(values[:, columns].min(axis=1), 0, None)
        values[:, ALL.index(whole)] += shared
        values[:, columns] -= shared[:, None]
    weights = slice(0, len(WEIGHTS))
    values[:, weights] = np.clip(values[:, weights], 0.0, 1.0)
    return ChannelTrack(ALL, values, track.rate)


@cache
def basic_expressions() -> dict[str, dict[str, float]]:
    """Units at full intensity of every expression in ``assets/facs/expressions.toml``.

    Examples
    --------
    >>> sorted(basic_expressions())
    ['anger', 'disgust', 'fear', 'happiness', 'sadness', 'surprise']
    """
    return {name: dict(facts["units"]) for name, facts in _table("expressions.toml").items()}


def expression_channels(name: str, intensity: float = 1.0) -> dict[str, float]:
    """Channel weights of one of the `basic_expressions`; ``intensity`` (0..1) weighs all its units alike.

    Examples
    --------
    >>> expression_channels("surprise", 0.5)["browInnerUp"]
    0.5
    """
    if name not in basic_expressions():
        raise unknown_name("basic expression", name, basic_expressions())
    return channels_of_units({unit: weight * intensity for unit, weight in basic_expressions()[name].items()})


def missing_channels(units: Iterable[str], known: Iterable[str]) -> dict[str, tuple[str, ...]]:
    """Which units a face cannot show in full, and the channels that it lacks for them.

    Parameters
    ----------
    units : iterable of str
    known : iterable of str
        Channels that move the face.

    Examples
    --------
    >>> missing_channels(["AU12", "AU38L"], ["mouthSmileLeft", "mouthSmileRight"])
    {'AU38L': ('noseFlareLeft',)}
    """
    there = set(known)
    for whole, halves in _JOINED.items():
        if there.issuperset(halves):
            there.add(whole)
    lacking = {unit: tuple(name for name in au_channels(unit) if name not in there) for unit in units}
    return {unit: names for unit, names in lacking.items() if names}
