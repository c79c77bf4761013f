"""From tallies of takes to figures with confidence intervals."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.metrics.counts import Tally
from mien.metrics.dynamics import CLASSES
from mien.metrics.mouth_distributions import median_of, p99_of, range_of
from mien.metrics.trajectory import bias_of, correlation_of, error_without_bias_of, rms_error_of, spread_of

__all__ = ["METRICS", "RESAMPLES", "Metric", "Score", "score"]

Array = NDArray[np.float64]

RESAMPLES = 1000
"""Bootstrap samples behind a confidence interval."""


@dataclass(frozen=True)
class Metric:
    """One column of a table.

    Attributes
    ----------
    title, unit : str
    digits : int
        Decimals that are printed.
    family : str
        The part of a tally that it is read from.
    value : callable
        From tallies of shape (..., columns) to values of shape (...).
    pooling : {"protocol", "always", "mean"}
        Averaged over takes or pooled over frames as the protocol has it; always pooled (closures: one take has too
        few); or always the mean over takes (lags).
    """

    title: str
    unit: str
    digits: int
    family: str
    value: Callable[[Array], Array]
    pooling: Literal["protocol", "always", "mean"] = "protocol"


@dataclass(frozen=True)
class Score:
    """A figure and its 95 % confidence interval over takes; NaN where it cannot be told."""

    value: float
    low: float
    high: float


def _ratio(column: int = 0) -> Callable[[Array], Array]:
    def value(sums: Array) -> Array:
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(sums[..., column] / sums[..., column + 1])

    return value


def _root_ratio(sums: Array) -> Array:
    return np.asarray(np.sqrt(_ratio()(sums)))


def _recall(counts: Array) -> Array:
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(counts[..., 1] / counts[..., 0])


def _precision(counts: Array) -> Array:
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(counts[..., 3] / counts[..., 2])


def _f1(counts: Array) -> Array:
    recall, precision = _recall(counts), np.nan_to_num(_precision(counts))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(recall + precision == 0, 0.0, 2 * recall * precision / (recall + precision))


METRICS: Mapping[str, Metric] = {
    "rms": Metric("RMS", "mm", 2, "distance", _root_ratio),
    "lips_rms": Metric("lips RMS", "mm", 2, "lip_distance", _root_ratio),
    "lips_rms_frontal": Metric("lips RMS from the front", "mm", 2, "frontal", _root_ratio),
    "opening_r": Metric("opening r", "", 2, "opening", correlation_of),
    "opening_error": Metric("opening error", "mm", 2, "opening", rms_error_of),
    "opening_spread": Metric("opening spread", "", 2, "opening", spread_of),
    "opening_bias": Metric("opening bias", "mm", 2, "opening", bias_of),
    "opening_error_without_bias": Metric("opening error", "mm", 2, "opening", error_without_bias_of),
    "opening_velocity_r": Metric("opening velocity r", "", 2, "opening_velocity", correlation_of),
    "opening_velocity_error": Metric("opening velocity error", "mm/s", 0, "opening_velocity", rms_error_of),
    "width_r": Metric("width r", "", 2, "width", correlation_of),
    "width_error": Metric("width error", "mm", 2, "width", rms_error_of),
    "width_spread": Metric("width spread", "", 2, "width", spread_of),
    "width_bias": Metric("width bias", "mm", 2, "width", bias_of),
    "width_error_without_bias": Metric("width error", "mm", 2, "width", error_without_bias_of),
    "width_velocity_r": Metric("width velocity r", "", 2, "width_velocity", correlation_of),
    "width_velocity_error": Metric("width velocity error", "mm/s", 0, "width_velocity", rms_error_of),
    "closure_recall": Metric("closure recall", "", 2, "closure", _recall, "always"),
    "closure_precision": Metric("closure precision", "", 2, "closure", _precision, "always"),
    "closure_f1": Metric("closure F1", "", 2, "closure", _f1, "always"),
    "shut_f1": Metric("shut with the recording, F1", "", 2, "shut", _f1, "always"),
    "lip_vertex_error": Metric("lip-vertex error", "mm²", 1, "lips", _ratio()),
    "jitter": Metric("jitter", "mm", 2, "jitter", _root_ratio),
    "speed_p99": Metric("lip speed p99", "mm/s", 0, "speeds", p99_of, "always"),
    "turns": Metric("turns", "1/s", 2, "turns", _ratio(), "always"),
    **{f"median_{kind}": Metric(kind, "mm", 1, f"opening {kind}", median_of, "always") for kind in CLASSES},
    **{f"range_{kind}": Metric(kind, "mm", 1, f"opening {kind}", range_of, "always") for kind in CLASSES},
    "lag": Metric("lag", "ms", 0, "sync", _ratio(0), "mean"),
    "onset_lag": Metric("onset lag", "ms", 0, "sync", _ratio(2), "mean"),
    "in_sync": Metric("within BT.1359", "", 2, "sync", _ratio(4), "mean"),
}


def score(
    tallies: Sequence[Tally], *, pooled: bool, random: np.random.Generator, resamples: int = RESAMPLES
) -> dict[str, Score]:
    """All metrics of one model.

    Parameters
    ----------
    tallies : sequence of Tally
        One for each take.
    pooled : bool
        Pool the frames of all takes (True), or take each metric in each take and average (False).
    random : numpy.random.Generator
        Draws the bootstrap samples of takes.
    resamples : int
        How many are drawn.

    Returns
    -------
    dict of str to Score
        Keys are those of `METRICS`. The interval is the 2.5th to the 97.5th percentile.

    Raises
    ------
    InputError
        If there is no tally.
    """
    if not tallies:
        raise InputError("expected at least one take to score, got none")
    number = len(tallies)
    drawn = random.integers(0, number, (resamples, number))
    counts = np.stack([np.bincount(row, minlength=number) for row in drawn]).astype(np.float64)
    result = {}
    for name, metric in METRICS.items():
        rows = np.stack([t[metric.family] for t in tallies])
        whole = metric.pooling == "always" or (pooled and metric.pooling == "protocol")
        summarise = _pooled if whole else _averaged
        value = float(summarise(metric, rows, np.ones((1, number)))[0])
        result[name] = Score(value, *_interval(summarise(metric, rows, counts)))
    return result


def _pooled(metric: Metric, rows: Array, counts: Array) -> Array:
    return metric.value(counts @ rows)


def _averaged(metric: Metric, rows: Array, counts: Array) -> Array:
    values = metric.value(rows)
    told = np.isfinite(values)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(counts[:, told] @ values[told] / counts[:, told].sum(axis=1))


def _interval(values: Array) -> tuple[float, float]:
    told = values[np.isfinite(values)]
    if not len(told):
        return float("nan"), float("nan")
    low, high = np.percentile(told, [2.5, 97.5])
    return float(low), float(high)
