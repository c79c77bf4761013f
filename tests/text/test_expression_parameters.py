"""MPEG-4's expression parameter as emotions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.text.expression_parameters import read_expression_parameters

HEAD = "seconds,expression1,intensity1,expression2,intensity2\n"


def test_expressions_by_name_and_number(tmp_path: Path) -> None:
    path = tmp_path / "parameters.csv"
    path.write_text(HEAD + "0,joy,0,,\n1,joy,63,surprise,21\n2,4,63,0,\n")
    times = np.array([0.0, 0.5, 1.0, 2.0])
    spans = {span.name: span.intensity_at(times).round(3).tolist() for span in read_expression_parameters(path)}
    assert spans == {"happy": [0, 0.5, 1, 0], "surprised": [0, 0.167, 0.333, 0], "afraid": [0, 0, 0, 1]}


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("seconds,joy\n", "line 1: expected the headings"),
        (HEAD + "0,joy,64,,\n", "line 2: an intensity of MPEG-4 runs from 0 to 63, not 64"),
        (HEAD + "0,joyy,1,,\n", "line 2: .*did you mean 'joy'"),
        (HEAD + "0,7,1,,\n", "line 2: unknown expression of MPEG-4 '7'"),
        (HEAD + "0,joy,1\n", "line 2: expected 5 columns, got 3"),
        (HEAD + "1,joy,1,,\n0,joy,1,,\n", "line 3: 0 s does not come after 1 s"),
        (HEAD, "no line asks for an expression"),
        (HEAD + "0,joy,much,,\n", "line 2: could not convert"),
    ],
)
def test_mistakes_are_told_with_their_line(content: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "parameters.csv").write_text(content)
    with pytest.raises(InputError, match=said):
        read_expression_parameters(tmp_path / "parameters.csv")
