"""`ParameterCurve`: a face parameter over time, the low level of control (Frydrych et al. 2003), and how curves lie
over motion.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError, unknown_name
from mien.text.face_parameters import face_parameter
from mien.text.key_tangents import check_tangents, through_tangents

__all__ = ["INTERPOLATIONS", "MODES", "ParameterCurve", "lay_over"]

Floats = NDArray[np.float64]
INTERPOLATIONS = ("linear", "smooth", "spline", "hold")
MODES = ("add", "set")


@dataclass(frozen=True)
class ParameterCurve:
    """A face parameter driven over time.

    Attributes
    ----------
    parameter : str
        A name of `mien.text.face_parameters`.
    keys : tuple of (float, float)
        Milliseconds from the start of the sound (as commands count) and values, in order of time. Two keys at
        one time are a jump.
    interpolation : {"linear", "smooth", "spline", "hold"}
        Between keys: straight; half a cosine; a monotone cubic (PCHIP); the earlier value until the next key.
    mode : {"add", "set"}
        Whether the curve is added to the rest of the motion, or takes its place from the first key to the last.
    fade : float
        Milliseconds before the first and after the last key over which the curve comes and goes, with the value of
        that key. 0: at once.
    tangents : tuple of str
        How the curve passes each key (`mien.text.key_tangents`); empty: as ``interpolation`` has it for all.

    Raises
    ------
    InputError
        If the name is not known, there is no key, times run backwards, or a number is not finite.

    Examples
    --------
    >>> curve = ParameterCurve("HeadNod", ((0.0, 0.0), (500.0, 0.1)))
    >>> curve.values_at(np.array([0.0, 0.25, 0.5, 2.0])).tolist()
    [0.0, 0.05, 0.1, 0.0]
    """

    parameter: str
    keys: tuple[tuple[float, float], ...]
    interpolation: str = "linear"
    mode: Literal["add", "set"] = "add"
    fade: float = 0.0
    tangents: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        face_parameter(self.parameter)
        if self.interpolation not in INTERPOLATIONS:
            raise unknown_name("interpolation", self.interpolation, INTERPOLATIONS)
        if self.mode not in MODES:
            raise unknown_name("mode of a curve", self.mode, MODES)
        if not self.keys:
            raise InputError(f"a curve of {self.parameter} needs at least one key: <key at= value=/>")
        check_tangents(self.tangents, len(self.keys))
        numbers = [number for key in self.keys for number in key] + [self.fade]
        if not all(math.isfinite(number) for number in numbers) or self.fade < 0:
            raise InputError(f"a curve of {self.parameter} has a time or value that is not a finite number")
        for (before, _), (after, _) in pairwise(self.keys):
            if after < before:
                raise InputError(f"a curve of {self.parameter} runs backwards: {after:g} ms comes after {before:g} ms")

    def values_at(self, seconds: Floats) -> Floats:
        """Values at instants, shape (times,), faded out of 0 and into 0. A time on a jump has the later value."""
        return self.held_at(seconds) * self.share_at(seconds)

    def held_at(self, seconds: Floats) -> Floats:
        """Values at instants, shape (times,); before the first and after the last key the value of that key."""
        at, value = (np.array(column, dtype=np.float64) for column in zip(*self.keys, strict=True))
        now = np.clip(np.round(np.asarray(seconds) * 1000, 6), at[0], at[-1])
        if self.tangents:
            return through_tangents(at, value, self.tangents, now)
        return np.full(now.shape, value[0]) if len(at) == 1 else self._between(at, value, now)

    def _between(self, at: Floats, value: Floats, now: Floats) -> Floats:
        place = np.clip(np.searchsorted(at, now, side="right") - 1, 0, len(at) - 1)
        after = np.minimum(place + 1, len(at) - 1)
        span = at[after] - at[place]
        share = np.divide(now - at[place], span, out=np.zeros_like(now), where=span > 0)
        if self.interpolation == "hold":
            share = np.zeros_like(share)
        elif self.interpolation == "smooth":
            share = (1 - np.cos(np.pi * share)) / 2
        elif self.interpolation == "spline" and (np.diff(at) > 0).all():
            from scipy.interpolate import PchipInterpolator

            return np.asarray(PchipInterpolator(at, value)(now))
        return np.asarray(value[place] + (value[after] - value[place]) * share)

    def share_at(self, seconds: Floats) -> Floats:
        """How much the curve counts, 0..1, shape (times,): 1 from the first key to the last, less where it fades."""
        now = np.round(np.asarray(seconds) * 1000, 6)
        first, last = self.keys[0][0], self.keys[-1][0]
        outside = np.maximum(np.maximum(first - now, now - last), 0.0)
        if self.fade == 0:
            return np.asarray((outside == 0).astype(np.float64))
        return np.asarray(1 - np.clip(outside / self.fade, 0.0, 1.0))


def lay_over(
    values: Floats, names: Sequence[str], curves: Sequence[ParameterCurve], times: Floats, share: Floats | None = None
) -> Floats:
    """Lay curves over motion: first all that set, in order, then all that add. Nothing is clipped here.

    Parameters
    ----------
    values : ndarray, shape (frames, channels)
        Left as it is; the result is a copy.
    names : sequence of str
        Channels of the columns.
    curves : sequence of ParameterCurve
    times : ndarray, shape (frames,)
        Seconds.
    share : ndarray, shape (frames, channels), optional
        How much of what is added remains, so that closures of the lips hold. What is set is set in full: who drives a
        channel by hand gets it exactly.

    Raises
    ------
    InputError
        If the motion lacks a channel that a curve moves.
    """
    result = values.copy()
    place = {name: number for number, name in enumerate(names)}
    for curve in sorted(curves, key=lambda curve: curve.mode != "set"):
        parameter = face_parameter(curve.parameter)
        missing = [name for name in parameter.channels if name not in place]
        if missing:
            raise InputError(f"the curve of {curve.parameter} moves {missing[0]}, which this animation does not have")
        columns = [place[name] for name in parameter.channels]
        drive = curve.held_at(times) if curve.mode == "set" else curve.values_at(times)
        moved = np.zeros((len(times), len(columns)))
        for sign, factors in ((1.0, parameter.plus), (-1.0, parameter.minus)):
            for name, factor in factors:
                moved[:, columns.index(place[name])] += np.clip(sign * drive, 0.0, None) * factor
        if curve.mode == "set":
            taken = curve.share_at(times)[:, None]
            result[:, columns] = result[:, columns] * (1 - taken) + moved * taken
        else:
            result[:, columns] += moved if share is None else moved * share[:, columns]
    return result
