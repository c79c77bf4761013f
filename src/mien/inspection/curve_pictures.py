"""Pictures of the paper's curves: weights over time (Deng et al. 2006, Figs. 5 to 8) and their cost (Fig. 9)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from mien.core.errors import InputError
from mien.core.plotting import COLOURS, GRID, INK, Colour, Figure, Panel
from mien.core.utterance import PAUSE
from mien.motion.mouth.articulation import articulation_table
from mien.motion.mouth.coarticulation import Coarticulation
from mien.motion.mouth.influence_curves import PENALTIES, Curves
from mien.motion.performer_file import LearnedSpeech

__all__ = ["draw_curves", "draw_fitting_cost", "most_heard", "read_sequence"]

Labels = tuple[str, ...]

_WIDTH, _HEIGHT = 330, 190  # of one panel
_LEFT, _RIGHT, _TOP, _BOTTOM, _HEAD = 44, 10, 36, 30, 34
_COLUMNS = 3
_LEGEND = 350
_TIMES: NDArray[np.float64] = np.linspace(0, 1, 101)
_COST_COLOURS: tuple[Colour, ...] = (INK, COLOURS[1], COLOURS[2], COLOURS[0])


def most_heard(paper: Coarticulation, phones: int, count: int = 9) -> tuple[Labels, ...]:
    """The diphones (``phones`` 2) or triphones (3) with most time-weight pairs; those with a pause come last."""
    found = [labels for labels in paper.curves_ if len(labels) == phones]
    found.sort(key=lambda labels: (PAUSE in labels, -paper.curves_[labels].pairs, labels))
    return tuple(found[:count])


def read_sequence(text: str) -> Labels:
    """A diphone or triphone from a text such as ``"P AA"``.

    Raises
    ------
    InputError
        If it is not two or three phones.

    Examples
    --------
    >>> read_sequence("p aa t")
    ('P', 'AA', 'T')
    """
    labels = tuple(text.upper().split())
    if len(labels) not in (2, 3):
        raise InputError(f"curves run over two or three phones such as 'P AA' or 'P AA T', not {text!r}")
    for label in labels:
        articulation_table().viseme_of(label)
    return labels


def draw_curves(paper: Coarticulation, sequences: Sequence[Labels]) -> Image.Image:
    """Draw the weight of each phone over normalised time, one panel for each diphone or triphone.

    A diphone that was not learned is drawn with the curves of its pair of classes, which would be used in its place.

    Raises
    ------
    InputError
        If there is nothing to draw, or nothing was learned for a sequence.
    """
    if not sequences:
        raise InputError("no diphone or triphone has curves in this performer: nothing to draw")
    drawn = [_curves_for(paper, labels) for labels in sequences]
    columns = min(_COLUMNS, len(drawn))
    rows = -(-len(drawn) // columns)
    figure = Figure(max(columns * _WIDTH, _LEGEND), _HEAD + rows * (_HEIGHT + _TOP + _BOTTOM))
    names = ("start F_s", "end F_e") if len(sequences[0]) == 2 else ("start F_s", "middle F_m", "end F_e")
    figure.legend((_LEFT, _HEAD / 2 + 2), dict(zip(names, _colours(len(names)), strict=True)), size=12)
    values = np.concatenate([curves.at(_TIMES).ravel() for curves, _ in drawn])
    low = min(-0.25, float(np.floor(values.min() * 4) / 4))
    high = max(1.25, float(np.ceil(values.max() * 4) / 4))
    for number, (curves, title) in enumerate(drawn):
        left = number % columns * _WIDTH
        top = _HEAD + number // columns * (_HEIGHT + _TOP + _BOTTOM) + _TOP
        box = (left + _LEFT, top, left + _WIDTH - _RIGHT, top + _HEIGHT)
        _draw_panel(Panel(figure, box, (0.0, 1.0), (low, high)), curves, title)
    return figure.finished()


def _colours(phones: int) -> tuple[Colour, ...]:
    return (COLOURS[1], COLOURS[0]) if phones == 2 else (COLOURS[1], COLOURS[2], COLOURS[0])


def _curves_for(paper: Coarticulation, labels: Labels) -> tuple[Curves, str]:
    """Curves of a sequence and the title of their panel."""
    said = " ".join(labels)
    if labels in paper.curves_:
        curves = paper.curves_[labels]
        return curves, f"{said}   {_quality(curves)}"
    classes = tuple(articulation_table().viseme_of(label) for label in labels)
    if len(labels) == 2 and classes in paper.class_curves_:
        curves = paper.class_curves_[classes]
        return curves, f"{said} as {' + '.join(classes)}   {_quality(curves)}"
    least = max(paper.settings.least_pairs, paper.settings.degree + 1)
    instead = "cosine interpolation of key shapes" if len(labels) == 2 else "its diphones"
    raise InputError(
        f"no curves were learned for {said} (fewer than {least} time-weight pairs): {instead} would be used"
    )


def _quality(curves: Curves) -> str:
    spread = np.sqrt(curves.error / (curves.pairs * curves.coefficients.shape[1]))
    return f"{curves.pairs} pairs, RMS {spread:.2f}"


def _draw_panel(panel: Panel, curves: Curves, title: str) -> None:
    figure, (left, top, _, _) = panel.figure, panel.box
    low, high = panel.up
    step = 0.5 if high - low <= 4 else float(np.ceil((high - low) / 6))
    panel.ticks_up([step * number for number in range(int(np.ceil(low / step)), int(np.floor(high / step)) + 1)])
    panel.ticks_across([0.0, 0.25, 0.5, 0.75, 1.0])
    panel.frame()
    figure.text((left, top - 6), title, 11, anchor="lb")
    weights = curves.at(_TIMES)
    for column, colour in enumerate(_colours(weights.shape[1])):
        panel.curve(_TIMES, weights[:, column], colour, 3)


def draw_fitting_cost(learned: LearnedSpeech) -> Image.Image:
    """Draw the cost of the curves against the degree of their polynomials, for each λ (Fig. 9); logarithmic."""
    cost = learned.fitting_cost
    degrees = np.arange(1, cost.shape[1] + 1, dtype=np.float64)
    figure = Figure(760, 460)
    names = [f"lambda {penalty:g}" for penalty in PENALTIES]
    figure.legend((80, 24), dict(zip(names, _COST_COLOURS, strict=True)), size=12)
    low, high = np.log10(max(float(cost.min()), 1e-12)), np.log10(max(float(cost.max()), 1e-12))
    margin = max(0.05 * (high - low), 0.05)
    panel = Panel(figure, (80, 48, 740, 410), (0.8, cost.shape[1] + 0.2), (low - margin, high + margin))
    ticks = _round_numbers(panel.up)
    panel.ticks_up([float(np.log10(v)) for v in ticks], [f"{v:,.0f}" if v >= 10 else f"{v:g}" for v in ticks])
    panel.ticks_across(degrees.tolist())
    used = learned.coarticulation.settings.degree
    if used <= cost.shape[1]:
        x = panel.points(np.array([float(used)]), np.array([low]))[0][0]
        figure.line([(x, 48), (x, 410)], GRID, 4)
        figure.text((x + 6, 66), "degree used", 11, anchor="lm")
    panel.frame()
    figure.text((86, 66), "fit cost of all diphones and triphones", 11, anchor="lm")
    for row, (values, colour) in enumerate(zip(cost, _COST_COLOURS, strict=True)):
        panel.curve(degrees, np.log10(np.maximum(values, 1e-12)), colour, 4 - row if row < 3 else 2)
    figure.text((410, 440), "degree of the polynomials", 11, anchor="mm")
    return figure.finished()


def _round_numbers(up: tuple[float, float]) -> list[float]:
    """1, 2 and 5 times powers of ten inside a range of logarithms."""
    decades = range(int(np.floor(up[0])), int(np.ceil(up[1])) + 1)
    numbers = [step * 10.0**decade for decade in decades for step in (1, 2, 5)]
    return [number for number in numbers if up[0] <= np.log10(number) <= up[1]]
