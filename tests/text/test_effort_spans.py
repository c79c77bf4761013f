from __future__ import annotations

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.text.effort_spans import EffortCurve, EffortSpan, effort_over, parse_effort
from mien.text.script_reading import read_script

TIMES = np.array([0.0, 1.0, 2.0])
ONE = np.ones(3)


def test_levels_and_points_are_read() -> None:
    assert parse_effort("1.4") == 1.4
    assert parse_effort("0.5@0,1.6@2") == EffortCurve((0.0, 2.0), (0.5, 1.6))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("2.5", "an effort runs from 0 to 2, not 2.5"),
        ("-1", "an effort runs from 0 to 2, not -1"),
        ("140", "did you mean 1.4?"),
        ("loud", "an effort is a number from 0 to 2"),
        ("1@0,3@2", "an effort runs from 0 to 2, not 3"),
        ("1@2,1@1", "times of an effort curve rise"),
        ("nan", "an effort runs from 0 to 2, not nan"),
    ],
)
def test_what_is_no_effort_is_refused(text: str, told: str) -> None:
    with pytest.raises(InputError, match=told.replace("?", r"\?")):
        parse_effort(text)


def test_a_file_of_points(tmp_path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "effort.csv"
    path.write_text("seconds,effort\n0,0.5\n2,1.9\n")
    found = parse_effort(str(path))
    assert isinstance(found, EffortCurve)
    assert found.at(np.array([1.0])) == pytest.approx(1.2)
    path.write_text("0,0.5\n2,2.9\n")
    with pytest.raises(InputError, match="line 2: an effort runs from 0 to 2"):
        parse_effort(str(path))


def test_a_later_span_takes_the_place_of_an_earlier_one_where_it_stands() -> None:
    spans = (EffortSpan(1.5), EffortSpan(0.5, 0.7, 1.3))
    assert effort_over(spans, ONE, np.zeros(3), TIMES) == pytest.approx([1.5, 0.5, 1.5])


def test_an_emotion_takes_the_place_of_the_voice_as_far_as_it_is_shown_and_by_hand_they_add_up() -> None:
    felt, shown = np.array([1.3, 0.9, 1.0]), np.array([1.0, 0.5, 0.0])
    voice, asked, off = (EffortSpan(1.2, source=source) for source in ("voice", "asked", "off"))
    assert effort_over((voice,), felt, shown, TIMES) == pytest.approx([1.3, 1.0, 1.2])
    assert effort_over((asked,), felt, shown, TIMES) == pytest.approx([1.5, 1.1, 1.2])
    assert effort_over((off,), felt, shown, TIMES) == pytest.approx([1.2, 1.2, 1.2])
    assert effort_over((), felt, shown, TIMES) == pytest.approx(felt)
    assert effort_over((EffortSpan(2.0),), felt, shown, TIMES).max() == 2


def test_tags_hold_levels_and_the_innermost_counts() -> None:
    script = read_script('<effort level="1.6">Get <effort level="0.3@0%,1@100%">out of</effort> here!</effort> Now.')
    outer, inner = script.efforts
    assert (outer.level, outer.keys) == (1.6, ())
    assert [value for _, value in inner.keys] == [0.3, 1.0]
    assert script.text.split() == ["Get", "out", "of", "here!", "Now."]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("<effort>a</effort>", "level= is missing"),
        ("<effort level='3'>a</effort>", "an effort runs from 0 to 2, not 3"),
        ("<effort level='1' intensity='1'>a</effort>", "intensity"),
        ("<effort level='1'>a", "never closed"),
    ],
)
def test_a_tag_that_does_not_fit_is_told_with_its_line(text: str, told: str) -> None:
    with pytest.raises(InputError, match=told) as caught:
        read_script("\n" + text)
    assert "line 2" in str(caught.value)
