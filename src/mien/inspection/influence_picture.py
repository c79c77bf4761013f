"""A picture of the performing mouth's influence curves: who pulls on it, and when, while a word is said."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from mien.core.plotting import COLOURS, GRID, INK, Colour, Figure, Panel, tick_step
from mien.core.timeline import Interval, Tier
from mien.core.utterance import PAUSE
from mien.inspection.shares import phones_of_text
from mien.motion.mouth.articulation import articulation_table, parts_of
from mien.motion.mouth.influence import influence_of
from mien.motion.mouth.speech_motion import SpeechMotion

__all__ = ["PHONE_LENGTH", "draw_influence", "evenly_spoken"]

Floats = NDArray[np.float64]

PHONE_LENGTH = 0.1
"""Seconds of each phone of the word that is drawn."""
_PAUSE_LENGTH = 0.25
_STEP = 0.002  # seconds between points of a curve
_STRANDS = 2  # drawn by themselves: those that move the mouth most
_WIDTH, _LEFT, _RIGHT, _PANEL, _GAP, _HEAD, _FOOT = 1000, 64, 16, 120, 52, 84, -8
_PAUSE_COLOUR: Colour = (150, 150, 156)


def evenly_spoken(text: str) -> Tier:
    """Phones of a text, each `PHONE_LENGTH` long, between pauses.

    Examples
    --------
    >>> [phone.label for phone in evenly_spoken("blue")]
    ['SIL', 'B', 'L', 'UW', 'SIL']
    """
    intervals, start = [], 0.0
    for label in phones_of_text(text):
        end = start + (_PAUSE_LENGTH if label == PAUSE else PHONE_LENGTH)
        intervals.append(Interval(start, end, label))
        start = end
    return Tier("phones", tuple(intervals))


def draw_influence(motion: SpeechMotion, text: str) -> Image.Image:
    """Draw how strongly each part of speech pulls over time, and the lip opening that results.

    From above: the influence over all strands of the motion, each weighed by how far it moves the mouth; the
    strands that move the mouth most; lip opening.

    Raises
    ------
    InputError
        If the text cannot be spoken.
    """
    phones = evenly_spoken(text)
    end = phones.intervals[-1].end
    times: Floats = np.arange(0, end, _STEP)
    influence, shares = _influence(motion, phones, times)
    mean = influence @ shares
    panels = [("influence, mean over the strands", mean)]
    for strand in np.argsort(-shares, kind="stable")[:_STRANDS]:
        panels.append((f"strand {strand + 1}: {100 * shares[strand]:.0f} % of the motion", influence[:, :, strand]))
    openings = _openings(motion, phones, times)
    rows = len(panels) + bool(openings)
    figure = Figure(_WIDTH, _HEAD + rows * (_PANEL + _GAP) + _FOOT)
    title = (
        f"{text}: each phone {1000 * PHONE_LENGTH:.0f} ms; the mouth runs {1000 * motion.settings.influence.lead:.0f}"
    )
    figure.text((_LEFT, 20), f"{title} ms ahead of the sound", 14, anchor="lm")
    for row, (name, values) in enumerate(panels):
        panel = _panel(figure, row, end, (0.0, 1.0))
        panel.ticks_up([0.0, 0.5, 1.0])
        _draw_parts(panel, phones, times, values)
        panel.frame()
        figure.text((_LEFT, panel.box[1] - 24), name, 12, anchor="lb")
    if openings:
        _draw_opening(figure, rows - 1, openings, phones, times)
    figure.text((_WIDTH - _RIGHT, figure.height - 14), "seconds", 10, anchor="rm")
    return figure.finished()


def _influence(motion: SpeechMotion, phones: Tier, times: Floats) -> tuple[Floats, Floats]:
    """Influence of each part on each strand, shape (frames, parts, strands), and each strand's share of the motion.

    Pauses that the model puts before the first part and after the last one count as those.
    """
    curves = motion.curves_
    placed = curves.place(phones, times)
    described = curves.curves(placed.described)
    count, ahead = len(parts_of(phones)), motion.settings.influence.neighbours
    part = np.clip(placed.index - ahead, 0, count - 1)
    found = np.zeros((len(times), count, described.shape[2]))
    np.add.at(found, (np.arange(len(times))[:, None], part), influence_of(described, placed))
    strength = np.linalg.norm(curves.shapes_, axis=1) * described[:, 0].std(axis=0)
    return found, strength / max(float(strength.sum()), 1e-12)


def _panel(figure: Figure, row: int, end: float, up: tuple[float, float]) -> Panel:
    top = _HEAD + row * (_PANEL + _GAP)
    return Panel(figure, (_LEFT, top, _WIDTH - _RIGHT, top + _PANEL), (0.0, end), up)


def _draw_parts(panel: Panel, phones: Tier, times: Floats, values: Floats) -> None:
    """One curve for each part in the colour of its name above; borders of the phones in grey."""
    parts, table = parts_of(phones), articulation_table()
    _draw_borders(panel, phones)
    spoken = 0
    for number, symbol in enumerate(parts.symbols):
        name = table.symbols[symbol]
        colour = _PAUSE_COLOUR if name == PAUSE else COLOURS[spoken % len(COLOURS)]
        spoken += name != PAUSE
        panel.curve(times, values[:, number], colour, 3)
        x = panel.points(np.array([(parts.starts[number] + parts.ends[number]) / 2]), np.zeros(1))[0][0]
        panel.figure.text((x, panel.box[1] - 4), name, 11, colour, "mb")


def _draw_borders(panel: Panel, phones: Tier) -> None:
    _, top, _, bottom = panel.box
    for phone in phones:
        x = panel.points(np.array([phone.start]), np.zeros(1))[0][0]
        panel.figure.line([(x, top), (x, bottom)], GRID)


def _openings(motion: SpeechMotion, phones: Tier, times: Floats) -> dict[str, Floats]:
    """Lip opening by the curves alone, and as performed, mm; none where the lips' middles are not known."""
    rows = {
        "influence curves alone": motion.space_.decode(motion.curves_.components(motion.curves_.place(phones, times))),
        "performed (network's share, size, edits, closures)": motion.mouth_.rows_from(motion.synthesise(phones, times)),
    }
    found = {name: motion.mouth_.opening_of(mouth) for name, mouth in rows.items()}
    return {name: opening for name, opening in found.items() if opening is not None}


def _draw_opening(figure: Figure, row: int, distances: dict[str, Floats], phones: Tier, times: Floats) -> None:
    """Lip opening, mm."""
    high = 1.1 * max(float(values.max()) for values in distances.values()) + 1e-6
    panel = _panel(figure, row, float(times[-1]) + _STEP, (0.0, high))
    step = tick_step(high, 4)
    panel.ticks_up([step * number for number in range(int(high / step) + 1)])
    panel.ticks_across([0.1 * number for number in range(int(times[-1] / 0.1) + 1)])
    _draw_borders(panel, phones)
    panel.frame()
    figure.text((_LEFT, panel.box[1] - 24), "lip opening, mm", 12, anchor="lb")
    colours: dict[str, Colour] = dict(zip(distances, (COLOURS[1], INK), strict=True))
    for name, values in distances.items():
        panel.curve(times, values, colours[name], 2)
    figure.legend((_LEFT, panel.box[1] - 10), colours, size=11)
