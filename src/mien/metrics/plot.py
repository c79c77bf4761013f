"""Pictures of trajectories: lip opening and its velocity, recorded and synthesised (Deng et al. 2006, Fig. 20)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from mien.core.errors import InputError
from mien.core.plotting import COLOURS, GRID, Colour, Figure, Panel, write_png
from mien.core.timeline import Tier
from mien.core.utterance import PAUSE
from mien.metrics.evaluation import RECORDING, Trace
from mien.metrics.trajectory import separation, velocity

__all__ = ["MOST_MODELS", "draw_trajectories", "write_trajectories"]

Array = NDArray[np.float64]

_WIDTH, _OPENING, _VELOCITY, _GAP = 1000, 190, 120, 34
_LEFT, _RIGHT, _TOP = 64, 16, 30
_RECORDED: Colour = (20, 20, 20)

MOST_MODELS = len(COLOURS)
"""Models that can be told apart in one picture."""


def draw_trajectories(traces: Sequence[Trace], models: Sequence[str]) -> Image.Image:
    """Draw lip opening and its velocity for some takes, one above another.

    Parameters
    ----------
    traces : sequence of Trace
    models : sequence of str
        Which models to draw beside the recording, at most six.

    Raises
    ------
    InputError
        If there is no take, or more models than can be told apart.
    """
    if not traces or not 0 < len(models) <= MOST_MODELS:
        raise InputError(
            f"a picture of trajectories needs a take and 1 to {MOST_MODELS} models, got {len(traces)} and {len(models)}"
        )
    colours = {RECORDING: _RECORDED, **dict(zip(models, COLOURS, strict=False))}
    each = _TOP + _OPENING + _VELOCITY + _GAP
    figure = Figure(_WIDTH, each * len(traces) + _GAP)
    figure.legend((_LEFT, _GAP // 2 + 4), colours)
    for row, trace in enumerate(traces):
        _draw_take(figure, trace, colours, _GAP + row * each)
    return figure.finished()


def write_trajectories(path: str | Path, traces: Sequence[Trace], models: Sequence[str]) -> None:
    """Write `draw_trajectories` as a PNG."""
    write_png(draw_trajectories(traces, models), path)


def _draw_take(figure: Figure, trace: Trace, colours: Mapping[str, Colour], top: int) -> None:
    recording = trace.recording
    shown = np.flatnonzero(recording.speech)
    part = slice(max(shown[0] - 3, 0), shown[-1] + 4)
    times = recording.times[part]
    openings = {
        name: separation(mouth, *recording.sites.opening)[part]
        for name, mouth in trace.mouths.items()
        if name in colours
    }
    figure.text((_LEFT, top + 4), recording.take.name, 13)
    high = max(float(curve.max()) for curve in openings.values())
    panel = _panel(figure, top + _TOP, _OPENING - 8, times, (0.0, high * 1.05))
    _draw_phones(panel, recording.take.phones)
    _draw_axes(panel, "lip opening, mm", 5.0)
    _draw_curves(panel, times, openings, colours)
    speeds = {name: velocity(curve, recording.fps) for name, curve in openings.items()}
    most = max(float(np.abs(speed).max()) for speed in speeds.values())
    below = _panel(figure, top + _TOP + _OPENING, _VELOCITY, times, (-most * 1.05, most * 1.05))
    _draw_axes(below, "velocity, mm/s", 100.0)
    _draw_curves(below, times, speeds, colours)


def _panel(figure: Figure, top: int, height: int, times: Array, values: tuple[float, float]) -> Panel:
    box = (_LEFT, top, _WIDTH - _RIGHT, top + height)
    return Panel(figure, box, (float(times[0]), float(times[-1])), (values[0], max(values[1], values[0] + 1.0)))


def _draw_axes(panel: Panel, title: str, step: float) -> None:
    panel.ticks_up((np.arange(np.ceil(panel.up[0] / step), np.floor(panel.up[1] / step) + 1) * step).tolist())
    panel.frame(title)


def _draw_phones(panel: Panel, phones: Tier) -> None:
    left, top, right, bottom = panel.box
    taken = 0.0  # where the last label ends; one that would touch it is lifted
    for phone in phones:
        if phone.label == PAUSE or phone.end < panel.across[0] or phone.start > panel.across[1]:
            continue
        ends = [x for x, _ in panel.points(np.array([phone.start, phone.end]), np.zeros(2))]
        x0, x1 = max(ends[0], left), min(ends[1], right)
        panel.figure.line([(x0, top), (x0, bottom)], GRID)
        half = panel.figure.length_of(phone.label) / 2
        touches = (x0 + x1) / 2 - half < taken + 2
        panel.figure.text(((x0 + x1) / 2, top - (12 if touches else 3)), phone.label, anchor="mb")
        taken = 0.0 if touches else (x0 + x1) / 2 + half


def _draw_curves(panel: Panel, times: Array, curves: Mapping[str, Array], colours: Mapping[str, Colour]) -> None:
    for name in [n for n in curves if n != RECORDING] + [RECORDING]:
        panel.curve(times, curves[name], colours[name], 3 if name == RECORDING else 2)
