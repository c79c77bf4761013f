from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mien
from mien.cli.main import main
from mien.core.errors import InputError
from mien.formats.native import read_native
from mien.pipeline.options import score_of, with_heard_effort
from mien.pipeline.spoken import Spoken
from mien.text.effort_spans import EffortSpan, effort_over
from tests.serve.modules.speaking import toy_voice  # noqa: F401 - a fixture
from tests.utterances import utterance


@pytest.mark.usefixtures("toy_voice")
def test_say_takes_effort_and_writes_it(tmp_path) -> None:  # type: ignore[no-untyped-def]
    jaws = []
    for given in ([], ["--effort", "1.8"], ["--effort", "0.3@0,0.3@9"]):
        out = tmp_path / f"{len(jaws)}.json"
        assert main(["say", "I never said that.", *given, "-o", str(out), "--quiet"]) == 0
        animation = read_native(out)
        jaws.append(animation.channels.channel("jawOpen").mean())
    assert jaws[2] < 0.8 * jaws[0] < jaws[0] < jaws[1] / 1.2
    assert read_native(tmp_path / "1.json").score.efforts == (EffortSpan(1.8),)


@pytest.mark.usefixtures("toy_voice")
@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("3", "an effort runs from 0 to 2, not 3"),
        ("auto", "a synthetic one has none"),
        ("shout", "an effort is a number from 0 to 2"),
        ("gone.csv", "gone.csv: no such file"),
    ],
)
def test_what_is_no_effort_is_one_line(given: str, told: str, tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    assert main(["say", "Hello.", "--effort", given, "-o", str(tmp_path / "x.json")]) == 2
    error = capsys.readouterr().err
    assert told in error
    assert error.count("\n") == 1
    assert not (tmp_path / "x.json").exists()


@pytest.mark.usefixtures("toy_voice")
def test_effort_in_python() -> None:
    plain, more = (mien.say("Good morning.", effort=effort) for effort in (None, 1.6))
    assert more.channels.channel("jawOpen").mean() > 1.15 * plain.channels.channel("jawOpen").mean()
    assert (mien.say("Good morning.", effort="off").channels.values == plain.channels.values).all()
    for wrong in (True, [1.0], np.array([1.0, 2.0])):
        with pytest.raises(InputError, match="an effort is"):
            mien.say("Good morning.", effort=wrong)  # type: ignore[arg-type]


def test_an_effort_read_by_name_wins_over_an_emotions() -> None:
    line = Spoken(utterance(("M", 0.3), ("AA", 0.6)))
    sad = score_of("sad")
    (plain, a), (felt, b), (asked, c) = (
        with_heard_effort(score, line, by_name)
        for score, by_name in ((score_of(None), False), (sad, False), (sad, True))
    )
    told = [one.utterance.notes[-1].message for one in (a, b, c)]
    assert told[1] == told[0] + "; not used: the emotion sad sets it (--effort auto keeps the voice's)"
    assert told[2] == told[0]
    assert plain.efforts[0].level == asked.efforts[0].level
    one, own = np.ones(1), np.full(1, 0.7)
    loud = [replace(score.efforts[0], level=1.9) for score in (felt, asked)]
    assert effort_over(loud[:1], own, one, one) == pytest.approx(0.7)
    assert effort_over(loud[1:], own, one, one) == pytest.approx(1.9)
