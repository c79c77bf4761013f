"""An animation as a table, and in a notebook."""

from __future__ import annotations

import mien.api.notebook as notebook
from mien.animation.animation import Animation
from tests.faces import tiny_animation


def test_it_is_a_table_of_channels_over_seconds() -> None:
    animation = tiny_animation(6)
    frame = animation.to_frame()
    assert frame.shape == animation.channels.values.shape
    assert list(frame.columns) == list(animation.channels.names)
    assert frame.index.name == "seconds"
    assert frame.index[3] == animation.rate.times(4)[3]
    assert (frame["jawOpen"].to_numpy() == animation.channels.select(("jawOpen",)).values[:, 0]).all()


def test_it_shows_itself_with_its_sound(monkeypatch) -> None:
    monkeypatch.setattr(notebook, "WIDTH", 64)
    monkeypatch.setattr(notebook, "HEIGHT", 64)
    shown = tiny_animation(3)._repr_html_()
    assert shown is not None
    assert shown.startswith("<video controls")
    assert "data:video/mp4;base64," in shown


def test_a_long_one_is_a_sheet_and_a_sound(monkeypatch) -> None:
    monkeypatch.setattr(notebook, "LONGEST", 0.0)
    shown = tiny_animation(3)._repr_html_()
    assert shown is not None
    assert "data:image/png;base64," in shown
    assert "<audio controls" in shown


def test_without_the_calls_it_is_plain(monkeypatch) -> None:
    monkeypatch.setattr(Animation, "html_of", None)
    assert tiny_animation(3)._repr_html_() is None
