"""Pictures of an expression space: curves in three dimensions, kept variance, and what is sampled beside its source.

As Figs. 12 and 13 of Deng et al. 2006.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from mien.core.plotting import COLOURS, GRID, INK, Colour, Figure, Panel, tick_step
from mien.motion.expression.expression_space import RATE, ExpressionSpace

__all__ = ["draw_expression_space", "kept_variance"]

Floats = NDArray[np.float64]
_SHOWN = 8.0  # seconds of each curve that are drawn: all of a minute is a ball of wool
_VIEWS = (("from in front of components 1 and 2", -35.0, 20.0), ("turned by a quarter", 55.0, 20.0))
_MORE: tuple[Colour, ...] = ((120, 120, 120), (140, 90, 40), (20, 20, 20), (150, 60, 60))
_SAMPLED: Colour = (0, 114, 178)


def kept_variance(space: ExpressionSpace) -> Floats:
    """Share of the variance that each component keeps, shape (components,)."""
    held = space.space_.variances_
    return np.asarray(held / held.sum() * space.space_.share_)


def draw_expression_space(space: ExpressionSpace, seed: int = 0) -> Image.Image:
    """Draw a space: every emotion's curve from two sides, the kept variance, one curve sampled anew."""
    figure = Figure(1240, 1010)
    title = f"Expression space: {_SHOWN:g} s of each emotion, mm over all markers (root of the sum of squares)"
    figure.text((30, 20), title, 14, anchor="lm")
    colours = dict(zip(space.emotions, (*COLOURS, *_MORE), strict=False))
    figure.legend((30, 46), colours, size=12)
    rows = round(_SHOWN * RATE)
    reach = max(float(np.abs(curve).max()) for curves in space.curves_.values() for curve in curves)
    for number, (name, yaw, pitch) in enumerate(_VIEWS):
        panel = _panel(figure, (30 + 600 * number, 70, 600 + 600 * number, 560), reach)
        panel.frame(name)
        _draw_axes(panel, reach, yaw, pitch)
        for emotion in space.emotions:
            panel.curve(*_seen(space.curves_[emotion][0][:rows], yaw, pitch), colours[emotion], 1)
    _draw_kept(figure, (70, 620, 300, 950), kept_variance(space))
    _draw_sampled(figure, (360, 620, 1200, 950), space, seed)
    return figure.finished()


def _panel(figure: Figure, box: tuple[float, float, float, float], reach: float) -> Panel:
    return Panel(figure, box, (-1.25 * reach, 1.25 * reach), (-1.05 * reach, 1.05 * reach))


def _seen(points: Floats, yaw: float, pitch: float) -> tuple[Floats, Floats]:
    """Where points in three dimensions are seen: across and up."""
    three = np.zeros((len(points), 3))
    three[:, : min(3, points.shape[1])] = points[:, :3]
    turn, tip = np.radians([yaw, pitch])
    across = three[:, 0] * np.cos(turn) - three[:, 1] * np.sin(turn)
    depth = three[:, 0] * np.sin(turn) + three[:, 1] * np.cos(turn)
    return across, three[:, 2] * np.cos(tip) + depth * np.sin(tip)


def _draw_axes(panel: Panel, reach: float, yaw: float, pitch: float) -> None:
    for axis in range(3):
        ends = np.zeros((2, 3))
        ends[:, axis] = -0.9 * reach, 0.9 * reach
        across, up = _seen(ends, yaw, pitch)
        panel.curve(across, up, GRID, 1)
        place = panel.points(across[1:], up[1:])[0]
        panel.figure.text(place, f"component {axis + 1}, +{0.9 * reach:.0f}", 10, anchor="mm")


def _draw_kept(figure: Figure, box: tuple[float, float, float, float], kept: Floats) -> None:
    panel = Panel(figure, box, (0.4, len(kept) + 0.6), (0.0, 1.0))
    panel.ticks_up([0, 0.2, 0.4, 0.6, 0.8, 1.0], ["0", "20 %", "40 %", "60 %", "80 %", "100 %"])
    panel.frame(f"variance kept: {kept.sum():.1%}")
    for number, share in enumerate(kept, start=1):
        corners = panel.points(np.array([number - 0.3, number + 0.3]), np.array([share, 0.0]))
        figure.rectangle((corners[0][0], corners[0][1], corners[1][0], corners[1][1]), COLOURS[1])
        figure.text(((corners[0][0] + corners[1][0]) / 2, corners[0][1] - 4), f"{share:.1%}", 10, anchor="mb")
    panel.ticks_across(range(1, len(kept) + 1))
    figure.text(((box[0] + box[2]) / 2, box[3] + 34), "component", 11, anchor="mm")


def _draw_sampled(figure: Figure, box: tuple[float, float, float, float], space: ExpressionSpace, seed: int) -> None:
    """The first component of the emotion that moves most: its source, and ten seconds sampled from it."""
    emotion = max(space.emotions, key=lambda name: float(np.std(np.concatenate(space.curves_[name])[:, 0])))
    source = space.curves_[emotion][0][: round(10 * RATE), 0]
    new = space.sample(emotion, 10.0, np.random.default_rng(seed))
    values = np.concatenate([source, new.curve[:, 0]])
    span = max(float(np.ptp(values)), 1e-6)
    panel = Panel(figure, box, (0.0, 10.0), (float(values.min() - 0.1 * span), float(values.max() + 0.2 * span)))
    step = tick_step(panel.up[1] - panel.up[0])
    panel.ticks_up((np.arange(np.ceil(panel.up[0] / step), np.floor(panel.up[1] / step) + 1) * step).tolist())
    panel.ticks_across(range(0, 11, 2))
    told = new.patches
    panel.frame(f"{told.joints} joints, {told.copied} of them copied on, {told.stretched} without a fitting patch")
    for curve, colour in ((source, INK), (new.curve[:, 0], _SAMPLED)):
        panel.curve(np.arange(len(curve)) / RATE, curve, colour, 1)
    figure.legend((box[0], box[1] - 18), {f"{emotion}, component 1: source": INK, "sampled anew": _SAMPLED}, size=11)
    figure.text(((box[0] + box[2]) / 2, box[3] + 34), "seconds", 11, anchor="mm")
