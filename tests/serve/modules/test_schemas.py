from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

import pytest

from mien.pipeline.speak import speak
from mien.pipeline.spoken import translate
from mien.serve.modules.xml_form import curve_element, one_line, script_element, spoken_element
from mien.text.commands import Command, shipped_library
from mien.text.script_reading import read_script
from tests.serve.modules.speaking import toy_voice

__all__ = ["toy_voice"]
etree = pytest.importorskip("lxml.etree", reason="lxml checks the schemas (pip install lxml)")
PAGE = Path(__file__).parents[3] / "docs" / "script.md"
EXAMPLES = re.findall(r"```script\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def schema(name: str):
    text = files("mien").joinpath("assets", "schemas", name).read_bytes()
    return etree.RelaxNG(etree.fromstring(text))


def faults(name: str, text: str) -> str:
    checked = schema(name)
    return "" if checked.validate(etree.fromstring(text.encode())) else str(checked.error_log)


def test_there_are_examples() -> None:
    assert len(EXAMPLES) >= 4


@pytest.mark.usefixtures("toy_voice")
@pytest.mark.parametrize("text", EXAMPLES)
def test_every_example_of_the_page_is_read_spoken_and_translated(text: str) -> None:
    script = read_script(text)
    spoken = speak(script)
    directed = translate(spoken)
    assert directed.curves
    if text.lstrip().startswith("<?xml") and "<script" in text:
        assert not faults("script.rng", text)
    for element in (script_element(script, "1"), spoken_element(spoken, "1"), spoken_element(directed, "1")):
        assert not faults("stream.rng", one_line(element))


def test_commands_fit_the_schema_of_the_stream() -> None:
    (curve,) = shipped_library().translate(Command("HeadNod", (("at", "0"),))).curves
    assert not faults("stream.rng", one_line(curve_element(curve)))
    assert not faults("stream.rng", '<HeadNod at="1000" amplitude="60" count="2"/>')


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("script.rng", "<script><emotion>a</emotion></script>"),
        ("script.rng", "<script><emotion name='sad' intensity='7'>a</emotion></script>"),
        ("script.rng", "<script><emotion name='sad' intensity='0.5@'>a</emotion></script>"),
        ("script.rng", "<script><emotion name='sad' intensity='7@0'>a</emotion></script>"),
        ("script.rng", "<script><curve parameter='jawOpen'/></script>"),
        ("script.rng", "<script><key at='0' value='1'/></script>"),
        ("script.rng", "<speak>a</speak>"),
        ("stream.rng", "<spoken/>"),
        ("stream.rng", "<HeadNod><key at='x' value='1'/></HeadNod>"),
    ],
)
def test_what_does_not_fit_is_refused(name: str, text: str) -> None:
    assert faults(name, text)
