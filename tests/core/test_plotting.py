from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mien.core.plotting import COLOURS, PAPER, Figure, Panel, tick_step, write_png


def test_a_curve_is_drawn_where_its_values_are():
    figure = Figure(120, 120)
    Panel(figure, (10, 10, 110, 110), (0, 1), (0, 10)).curve(np.array([0.0, 1.0]), np.array([2.0, 2.0]), COLOURS[1], 3)
    picture = np.asarray(figure.finished()).astype(int)
    assert np.abs(picture[90, 60] - COLOURS[1]).max() < 10
    assert (picture[80, 60] == PAPER).all()
    assert (picture[100, 60] == PAPER).all()


def test_values_out_of_range_stay_on_the_edge():
    panel = Panel(Figure(20, 20), (0, 0, 10, 10), (0, 1), (-1, 1))
    assert panel.points(np.array([0.0, 1.0]), np.array([-7.0, 7.0])) == [(0.0, 10.0), (10.0, 0.0)]


@pytest.mark.parametrize("span", [1e-3, 0.7, 1.0, 9.99, 10.0, 4321.0])
def test_ticks_are_round_and_few(span: float):
    step = tick_step(span)
    assert span / step <= 6 + 1e-9
    assert span / step > 2
    assert f"{step:.0e}"[0] in "125"


def test_pictures_are_the_same_bytes_each_time(tmp_path: Path):
    for name in ("one.png", "two.png"):
        figure = Figure(60, 40)
        figure.legend((4, 20), {"a": COLOURS[0]})
        write_png(figure.finished(), tmp_path / name)
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()
