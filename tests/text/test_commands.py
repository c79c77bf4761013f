from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mien.core import channels
from mien.core.errors import InputError
from mien.text.commands import Command, CommandLibrary, shipped_library
from mien.text.library_file import parse_library
from mien.text.parameter_curves import ParameterCurve, lay_over

PAPERS = """$command = HeadNod
$mandatory = at
$optional = amplitude=100, count=1,
period=500,
frequency=1, end=1000
$interp = linear
amplitude = 0,0; 333,0.15; 666,0;
833,-0.025; 1000,0
$proc = periodic
"""


def keys(library: CommandLibrary, name: str, **given: str) -> tuple[tuple[float, float], ...]:
    (curve,) = library.translate(Command(name, tuple(given.items()))).curves
    return curve.keys


def test_the_papers_nod_comes_out_number_for_number() -> None:
    for library in (CommandLibrary(parse_library(PAPERS)), shipped_library()):
        assert keys(library, "HeadNod", at="1000", amplitude="60", count="2") == (
            (1000, 0), (1166.5, 0.09), (1333, 0), (1416.5, -0.015), (1500, 0),
            (1666.5, 0.09), (1833, 0), (1916.5, -0.015), (2000, 0),
        )  # fmt: skip


def lasts(**given: str) -> float:
    nod = keys(shipped_library(), "HeadNod", at="0", **given)
    return nod[-1][0]


def test_what_is_given_beats_defaults_period_beats_frequency_and_count_beats_end() -> None:
    assert lasts() == 500  # default period beats default frequency, default count beats default end
    assert lasts(frequency="4") == 250  # given beats default
    assert lasts(frequency="4", period="300") == 300
    assert lasts(end="1600") == 1500  # as many whole nods as fit
    assert lasts(end="100") == 500  # at least one
    assert lasts(end="1600", count="2") == 1000


def test_a_parameter_that_does_not_count_is_told() -> None:
    command = Command("HeadNod", (("at", "0"), ("count", "2"), ("end", "900")), "talk.txt, line 3")
    (note,) = shipped_library().translate(command).notes
    assert note.message == "talk.txt, line 3: HeadNod: count was given, so end does not count"


@pytest.mark.parametrize(
    ("name", "given", "words"),
    [
        ("HeadNodd", {"at": "0"}, "did you mean 'HeadNod'"),
        ("HeadNod", {}, "needs at="),
        ("HeadNod", {"at": "0", "cuont": "2"}, "did you mean 'count'"),
        ("HeadNod", {"at": "soon"}, "at is a number, not 'soon'"),
        ("HeadNod", {"at": "0", "count": "2.5"}, "whole number"),
        ("HeadNod", {"at": "0", "count": "0"}, "1 or more"),
        ("HeadNod", {"at": "0", "count": "1e9"}, "at most 10000"),
        ("HeadNod", {"at": "0", "period": "-5"}, "above 0"),
        ("HeadNod", {"at": "0", "frequency": "0"}, "above 0"),
        ("HeadNod", {"at": "nan"}, "at is a number"),
    ],
)
def test_a_wrong_command_is_refused_with_its_place(name: str, given: dict[str, str], words: str) -> None:
    with pytest.raises(InputError) as problem:
        shipped_library().translate(Command(name, tuple(given.items()), "talk.txt, line 7"))
    assert words in str(problem.value)
    assert str(problem.value).startswith("talk.txt, line 7: ")


@pytest.mark.parametrize(
    ("change", "line", "words"),
    [
        (("$mandatory", "$mandatry"), "line 2", "did you mean '$mandatory'"),
        (("$interp = linear", "$interp = linaer"), "line 6", "did you mean 'linear'"),
        (("$proc = periodic", "$proc = peroidic"), "line 9", "did you mean 'periodic'"),
        (("count=1,\n", "count=1\n"), "lines 4 to 5", "does the line before lack a ','"),
        (("count=1", "count=one"), "lines 3 to 5", "expected a number, got 'one'"),
        (("count=1", "conut=1"), "line 1", "does nothing"),
        (("333,0.15", "333;0.15"), "lines 7 to 8", "expected a pair time,value"),
        (("666,0;", "66,0;"), "lines 7 to 8", "run backwards"),
        (("amplitude = 0", "jawOpn = 0"), "lines 7 to 8", "did you mean 'jawOpen'"),
        (("amplitude = 0", "wobble stuff\namplitude = 0"), "line 7", "got 'wobble stuff'"),
        (("$proc = periodic", ""), "line 1", "lacks '$proc"),
        (("amplitude = 0,0; 333,0.15; 666,0;\n833,-0.025; 1000,0", ""), "line 1", "moves nothing"),
        (("$command = HeadNod", "$interp = linear"), "line 1", "expected '$command"),
        (("$interp = linear", "$interp = linear\n$interp = smooth"), "line 7", "stands there twice"),
        (("333,0.15", "333,size"), "line 1", "unknown parameter in the lists of HeadNod 'size'"),
    ],
)
def test_a_typing_error_in_a_library_names_file_line_and_what_was_expected(
    tmp_path: Path, change: tuple[str, str], line: str, words: str
) -> None:
    assert change[0] in PAPERS
    path = tmp_path / "nods.txt"
    path.write_text(PAPERS.replace(*change))
    with pytest.raises(InputError) as problem:
        CommandLibrary.of(tmp_path)
    assert str(problem.value).startswith(f"{path}, {line}: "), problem.value
    assert words in str(problem.value)


def test_a_folder_of_the_users_own_adds_and_replaces(tmp_path: Path) -> None:
    text = (
        PAPERS.replace("0.15", "0.3")
        + "\n# mine\n"
        + PAPERS.replace("= HeadNod", "= Doze").replace("amplitude = 0", "eyeBlink = 0")
    )
    (tmp_path / "mine.txt").write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    library = CommandLibrary.of(tmp_path)
    assert keys(library, "HeadNod", at="0")[1][1] == 0.3
    assert keys(library, "Doze", at="0")[1] == (166.5, 0.15)
    assert "Smile" in library


def test_values_by_parameter() -> None:
    curves = shipped_library().translate(Command("LookAt", (("at", "0"), ("yaw", "-14"), ("pitch", "5")))).curves
    assert {curve.parameter: curve.keys[0][1] for curve in curves} == {"GazeSide": -14, "GazeHeight": 5}
    assert all(curve.mode == "set" for curve in curves)


@pytest.mark.parametrize("name", shipped_library().names)
def test_every_shipped_command_moves_something_and_comes_to_rest(name: str) -> None:
    given = (("at", "500"), ("yaw", "9")) if name == "LookAt" else (("at", "500"),)
    curves = shipped_library().translate(Command(name, given)).curves
    times = np.arange(0, 8, 1 / 60)
    values = lay_over(np.zeros((len(times), len(channels.ALL))), channels.ALL, curves, times)
    assert np.abs(values).max() > 0.1
    assert not values[-1].any()
    assert not values[0].any()
    weights = values[:, : len(channels.ARKIT)]
    assert np.abs(np.diff(weights, axis=0)).max() < 0.3  # nothing jumps
    assert shipped_library()[name].about


@given(
    st.sampled_from(shipped_library().names),
    st.integers(0, 5000),
    st.floats(0, 300),
    st.sampled_from(["count", "end", "period", "duration", "peak"]),
    st.integers(1, 3000),
)
def test_keys_never_run_backwards(name: str, at: int, amplitude: float, extra: str, value: int) -> None:
    asked = [("at", str(at)), ("amplitude", repr(amplitude))]
    if extra in shipped_library()[name].parameters:
        asked.append((extra, str(min(value, 40) if extra == "count" else value)))
    try:
        curves = shipped_library().translate(Command(name, tuple(asked))).curves
    except InputError:
        assert extra == "peak"
        return
    for curve in curves:
        assert curve.keys[0][0] >= at
        assert all(b[0] >= a[0] for a, b in zip(curve.keys, curve.keys[1:], strict=False))


def test_held_lasts_until_its_end() -> None:
    smile = shipped_library().translate(Command("Smile", (("at", "100"), ("end", "3000")))).curves[0]
    assert smile.keys == ((100, 0), (550, 0.7), (2450, 0.7), (3100, 0))
    hurried = shipped_library().translate(Command("Smile", (("at", "100"), ("end", "550")))).curves[0]
    assert hurried.keys[-1] == (650, 0)


def test_set_takes_the_place_of_motion_and_fades() -> None:
    motion = np.full((5, len(channels.ALL)), 0.5)
    times = np.array([0.0, 0.95, 1.0, 1.5, 2.2])
    curve = ParameterCurve("jawOpen", ((1000, 0.2), (2000, 0.4)), mode="set", fade=100)
    jaw = lay_over(motion, channels.ALL, [curve], times)[:, channels.ALL.index("jawOpen")]
    np.testing.assert_allclose(jaw, [0.5, 0.35, 0.2, 0.3, 0.5])
    assert (motion == 0.5).all()


@pytest.mark.parametrize(
    ("interpolation", "middle"), [("linear", 0.25), ("hold", 0.0), ("smooth", 0.146447), ("spline", 0.25)]
)
def test_interpolations(interpolation: str, middle: float) -> None:
    curve = ParameterCurve("jawOpen", ((0, 0), (1000, 1)), interpolation)
    assert curve.values_at(np.array([0.25]))[0] == pytest.approx(middle, abs=1e-6)
    assert curve.values_at(np.array([1.0]))[0] == 1.0


def test_a_jump_shows_its_later_value() -> None:
    curve = ParameterCurve("jawOpen", ((0, 0), (500, 0), (500, 1), (1000, 1)))
    assert curve.values_at(np.array([0.499, 0.5])).tolist() == [0.0, 1.0]
