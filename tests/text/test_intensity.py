"""Intensity curves: what is written is what is meant, values stay in range, mistakes are told with their place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mien.core.errors import InputError
from mien.text.intensity import IntensityCurve, parse_intensity, read_intensity
from mien.text.score import EmotionSpan


@given(
    st.lists(st.tuples(st.floats(0, 100), st.floats(0, 1)), min_size=1, max_size=8, unique_by=lambda point: point[0]),
    st.sampled_from(["smooth", "linear"]),
)
def test_a_curve_goes_through_its_points_and_never_leaves_0_to_1(
    points: list[tuple[float, float]], interpolation: str
) -> None:
    points = [(round(time, 3), value) for time, value in sorted(points)]
    if len({time for time, _ in points}) < len(points):
        return
    times, values = zip(*points, strict=True)
    curve = IntensityCurve(times, values, interpolation)  # type: ignore[arg-type]
    np.testing.assert_allclose(curve.at(np.array(times)), values, atol=1e-9)
    dense = curve.at(np.linspace(-10, 110, 500))
    assert dense.min() >= min(values) - 1e-9
    assert dense.max() <= max(values) + 1e-9


@pytest.mark.parametrize(
    ("written", "span"),
    [
        ("Happy", EmotionSpan("happy")),
        ("happy:0.6", EmotionSpan("happy", 0.6)),
        ("happy[1-2.5]:.6", EmotionSpan("happy", 0.6, 1.0, 2.5)),
        ("happy[-2]", EmotionSpan("happy", 1.0, None, 2.0)),
        ("happy[ 1 - ]", EmotionSpan("happy", 1.0, 1.0, None)),
        ("happy:0@0,1@1.5,0@2", EmotionSpan("happy", IntensityCurve((0.0, 1.5, 2.0), (0.0, 1.0, 0.0)))),
    ],
)
def test_spans_as_written(written: str, span: EmotionSpan) -> None:
    assert EmotionSpan.parse(written) == span


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("happy:60", "did you mean 0.6"),
        ("happy:7", r"did you mean 0\.7"),
        ("happy:very", "points such as 0.2@0"),
        ("happy:0.2@0,0.9", "points such as 0.2@0"),
        ("happy:0.2@1,0.9@1", "times of an intensity curve rise"),
        ("happy:1.2@0", "runs from 0 to 1, not 1.2"),
        ("happy[2-1]", "before it starts"),
        ("happy[a-b]", "NAME"),
        ("", "NAME"),
        ("happy:nan", "runs from 0 to 1"),
        ("happy:nowhere.csv", "nowhere.csv: no such file"),
    ],
)
def test_mistakes_are_told(written: str, said: str) -> None:
    with pytest.raises(InputError, match=said.replace("[", r"\[")):
        EmotionSpan.parse(written)


def test_a_curve_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "curve.csv"
    path.write_text("seconds,intensity\n0,0\n# a pause\n1.0, 0.5\n\n2,1\n")
    curve = parse_intensity(str(path))
    assert curve == IntensityCurve((0.0, 1.0, 2.0), (0.0, 0.5, 1.0), "linear")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("time,value\n", "found none"),
        ("0,0\n1\n", r"line 2: expected seconds and an intensity, got '1'"),
        ("0,0\n1,x\n", "line 2"),
        ("0,0\n1,50\n", "line 2: an intensity runs from 0 to 1, not 50: did you mean 0.5"),
        ("1,0\n0.5,1\n", "line 2: 0.5 s does not come after 1 s"),
    ],
)
def test_a_file_with_a_mistake_names_the_line(content: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "curve.csv").write_text(content)
    with pytest.raises(InputError, match=said):
        read_intensity(tmp_path / "curve.csv")
