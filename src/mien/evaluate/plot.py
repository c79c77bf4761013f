"""Pictures of trajectories: lip opening and its velocity, recorded and synthesised (Deng et al. 2006, Fig. 20)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from mien.errors import InputError
from mien.evaluate.protocols import RECORDING, Trace
from mien.evaluate.trajectory import separation, velocity
from mien.files import replace_when_complete
from mien.speech.utterance import PAUSE
from mien.timeline import Tier

__all__ = ["MOST_MODELS", "draw_trajectories", "write_trajectories"]

Array = NDArray[np.float64]
Colour = tuple[int, int, int]

_SCALE = 2  # drawn so much larger, then reduced: smooth lines
_WIDTH, _OPENING, _VELOCITY, _GAP = 1000, 190, 120, 34
_LEFT, _RIGHT, _TOP = 64, 16, 30
_PAPER, _INK, _GRID = (255, 255, 255), (30, 30, 34), (222, 222, 226)
_RECORDED: Colour = (20, 20, 20)
# Okabe and Ito's colours: told apart by colour-blind readers too.
_COLOURS: tuple[Colour, ...] = (
    (213, 94, 0),
    (0, 114, 178),
    (0, 158, 115),
    (204, 121, 167),
    (230, 159, 0),
    (86, 180, 233),
)

MOST_MODELS = len(_COLOURS)
"""Models that can be told apart in one picture."""


@dataclass(frozen=True)
class _Panel:
    """A rectangle of the picture with the ranges of its axes, in pixels of the enlarged picture."""

    box: tuple[int, int, int, int]
    times: tuple[float, float]
    values: tuple[float, float]

    def points(self, times: Array, curve: Array) -> list[tuple[float, float]]:
        left, top, right, bottom = self.box
        x = left + (times - self.times[0]) / (self.times[1] - self.times[0]) * (right - left)
        share = (np.clip(curve, *self.values) - self.values[0]) / (self.values[1] - self.values[0])
        return list(zip(x.tolist(), (bottom - share * (bottom - top)).tolist(), strict=True))


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
    colours = {RECORDING: _RECORDED, **dict(zip(models, _COLOURS, strict=False))}
    each = _TOP + _OPENING + _VELOCITY + _GAP
    image = Image.new("RGB", (_WIDTH * _SCALE, (each * len(traces) + _GAP) * _SCALE), _PAPER)
    draw = ImageDraw.Draw(image)
    _draw_legend(draw, colours)
    for row, trace in enumerate(traces):
        _draw_take(draw, trace, colours, _GAP + row * each)
    return image.resize((_WIDTH, each * len(traces) + _GAP), Image.Resampling.LANCZOS)


def write_trajectories(path: str | Path, traces: Sequence[Trace], models: Sequence[str]) -> None:
    """Write `draw_trajectories` as a PNG."""
    image = draw_trajectories(traces, models)
    with replace_when_complete(path) as unfinished:
        image.save(unfinished, format="PNG", optimize=True)


def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(size * _SCALE)


def _draw_legend(draw: ImageDraw.ImageDraw, colours: Mapping[str, Colour]) -> None:
    x, y = _LEFT * _SCALE, (_GAP // 2 + 4) * _SCALE
    for name, colour in colours.items():
        draw.line([(x, y), (x + 24 * _SCALE, y)], fill=colour, width=3 * _SCALE)
        x += 30 * _SCALE
        draw.text((x, y), name, fill=_INK, font=_font(13), anchor="lm")
        x += int(draw.textlength(name, font=_font(13))) + 22 * _SCALE


def _draw_take(draw: ImageDraw.ImageDraw, trace: Trace, colours: Mapping[str, Colour], top: int) -> None:
    recording = trace.recording
    shown = np.flatnonzero(recording.speech)
    part = slice(max(shown[0] - 3, 0), shown[-1] + 4)
    times = recording.times[part]
    openings = {
        name: separation(mouth, *recording.sites.opening)[part]
        for name, mouth in trace.mouths.items()
        if name in colours
    }
    draw.text((_LEFT * _SCALE, (top + 4) * _SCALE), recording.take.name, fill=_INK, font=_font(13))
    high = max(float(curve.max()) for curve in openings.values())
    panel = _panel(top + _TOP, _OPENING - 8, times, (0.0, high * 1.05))
    _draw_phones(draw, panel, recording.take.phones)
    _draw_axes(draw, panel, "lip opening", "mm", 5.0)
    _draw_curves(draw, panel, times, openings, colours)
    speeds = {name: velocity(curve, recording.fps) for name, curve in openings.items()}
    most = max(float(np.abs(speed).max()) for speed in speeds.values())
    below = _panel(top + _TOP + _OPENING, _VELOCITY, times, (-most * 1.05, most * 1.05))
    _draw_axes(draw, below, "velocity", "mm/s", 100.0)
    _draw_curves(draw, below, times, speeds, colours)


def _panel(top: int, height: int, times: Array, values: tuple[float, float]) -> _Panel:
    box = (_LEFT * _SCALE, top * _SCALE, (_WIDTH - _RIGHT) * _SCALE, (top + height) * _SCALE)
    return _Panel(box, (float(times[0]), float(times[-1])), (values[0], max(values[1], values[0] + 1.0)))


def _draw_axes(draw: ImageDraw.ImageDraw, panel: _Panel, title: str, unit: str, step: float) -> None:
    left, top, right, _ = panel.box
    draw.rectangle(panel.box, outline=_GRID, width=_SCALE)
    for value in np.arange(np.ceil(panel.values[0] / step), np.floor(panel.values[1] / step) + 1) * step:
        y = panel.points(np.array([panel.times[0]]), np.array([value]))[0][1]
        draw.line([(left, y), (right, y)], fill=_GRID, width=_SCALE)
        draw.text((left - 6 * _SCALE, y), f"{value:g}", fill=_INK, font=_font(10), anchor="rm")
    draw.text((right - 6 * _SCALE, top + 4 * _SCALE), f"{title}, {unit}", fill=_INK, font=_font(11), anchor="ra")


def _draw_phones(draw: ImageDraw.ImageDraw, panel: _Panel, phones: Tier) -> None:
    left, top, right, bottom = panel.box
    taken = 0.0  # where the last label ends; one that would touch it is lifted
    for phone in phones:
        if phone.label == PAUSE or phone.end < panel.times[0] or phone.start > panel.times[1]:
            continue
        ends = [x for x, _ in panel.points(np.array([phone.start, phone.end]), np.zeros(2))]
        x0, x1 = max(ends[0], left), min(ends[1], right)
        draw.line([(x0, top), (x0, bottom)], fill=_GRID, width=_SCALE)
        half = draw.textlength(phone.label, font=_font(10)) / 2
        touches = (x0 + x1) / 2 - half < taken + 2 * _SCALE
        draw.text(
            ((x0 + x1) / 2, top - (12 if touches else 3) * _SCALE), phone.label, fill=_INK, font=_font(10), anchor="mb"
        )
        taken = 0.0 if touches else (x0 + x1) / 2 + half


def _draw_curves(
    draw: ImageDraw.ImageDraw, panel: _Panel, times: Array, curves: Mapping[str, Array], colours: Mapping[str, Colour]
) -> None:
    for name in [n for n in curves if n != RECORDING] + [RECORDING]:
        width = (3 if name == RECORDING else 2) * _SCALE
        draw.line(panel.points(times, curves[name]), fill=colours[name], width=width, joint="curve")
