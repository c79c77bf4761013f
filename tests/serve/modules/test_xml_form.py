from __future__ import annotations

import dataclasses

import pytest

from mien.core.errors import InputError
from mien.pipeline.speak import speak
from mien.pipeline.spoken import translate
from mien.serve.modules.messages import Message, Messages
from mien.serve.modules.xml_form import (
    element_of,
    one_line,
    read_script_element,
    read_spoken,
    script_element,
    spoken_element,
)
from mien.text.commands import shipped_library
from mien.text.script_reading import read_script
from tests.serve.modules.speaking import toy_voice
from tests.text.test_script_reading import BML, SSML

__all__ = ["toy_voice"]
TAGGED = """He said: "AT&T\t<3" & <HeadNod count="2"/> then\r\n<emotion name="sad" intensity="0.3">a\u2028b</emotion>
<pause seconds="0.333"/> <gaze target="left">that</gaze> <pose parameter="AU12L" value="0.7">is</pose>
<curve parameter="jawOpen" mode="set" fade="50" interp="spline">
<key at="0" value="0.1"/><key at="end" value="0.3"/></curve>
<phoneme alphabet="x-arpabet" ph="T AH0 M AA1 T OW0">tomato</phoneme> <prosody rate="fast" pitch="+1st">now</prosody>"""
CURVED = """<emotion name="happy" intensity="0.2@0,0.9@0.5">one <emotion name="sad" intensity="0@0%,1@33%,0@100%">two
</emotion> three</emotion>"""
WORKED = """<effort level="1.6">one <effort level="0.3@0%,1@100%">two</effort> three</effort> four"""
SCRIPTS = [TAGGED, CURVED, WORKED, SSML, BML, "Hello."]


@pytest.mark.parametrize("text", SCRIPTS)
def test_a_script_reads_back_equal(text: str) -> None:
    script = read_script(text)
    line = one_line(script_element(script, "1"))
    assert "\n" not in line
    again = read_script_element(element_of(line))
    assert again == script
    assert [c.command.where for c in again.commands] == [c.command.where for c in script.commands]


@pytest.mark.usefixtures("toy_voice")
@pytest.mark.parametrize("text", SCRIPTS)
def test_what_was_spoken_reads_back_equal(text: str) -> None:
    spoken = speak(read_script(text))
    for stage in (spoken, translate(spoken)):
        again = read_spoken(element_of(one_line(spoken_element(stage, "1"))))
        assert again == stage


def test_a_curve_of_intensity_reads_back_equal() -> None:
    from mien.serve.modules.xml_form import _emotion, _span_element
    from mien.text.intensity import IntensityCurve
    from mien.text.score import EmotionSpan

    for curve in (IntensityCurve((0.1, 1 / 3), (0.2, 0.7)), IntensityCurve((0.0, 1.0), (0.0, 1.0), "linear")):
        span = EmotionSpan("sad", curve, end=2.5)
        assert _emotion(element_of(one_line(_span_element("emotion", span, curve, name=span.name)))) == span


def test_an_effort_in_time_reads_back_equal() -> None:
    from mien.serve.modules.xml_form import _effort, _span_element
    from mien.text.effort_spans import EffortCurve, EffortSpan

    for span in (EffortSpan(1.4, 0.5), EffortSpan(EffortCurve((0.0, 2.0), (0.4, 1.7), "linear"), source="voice")):
        source = None if span.source == "asked" else span.source
        assert _effort(element_of(one_line(_span_element("effort", span, span.level, source=source)))) == span


def test_every_field_travels() -> None:
    """A field added to one of these types needs a place in the stream: add it there, then here."""
    from mien.core.utterance import Utterance
    from mien.pipeline.spoken import Spoken
    from mien.text.effort_spans import EffortSpan
    from mien.text.parameter_curves import ParameterCurve
    from mien.text.score import EmotionSpan
    from mien.text.script import DirectedEffort, DirectedEmotion, Script, Segment

    known = {
        Spoken: {"utterance", "emotions", "commands", "curves", "efforts"},
        Utterance: {
            "text",
            "audio",
            "words",
            "phones",
            "language",
            "timing",
            "notes",
            "native",
            "shapes",
            "sung",
        },
        EmotionSpan: {"name", "intensity", "start", "end"},
        EffortSpan: {"level", "start", "end", "source"},
        DirectedEffort: {"level", "start", "end", "keys"},
        DirectedEmotion: {"name", "intensity", "start", "end", "keys"},
        ParameterCurve: {"parameter", "keys", "interpolation", "mode", "fade", "tangents"},
        Segment: {"text", "silence", "start", "voice", "spellings"},
        Script: {
            "segments",
            "points",
            "prosody",
            "emotions",
            "commands",
            "curves",
            "voice",
            "language",
            "notes",
            "efforts",
        },
    }
    for kind, fields in known.items():
        assert {field.name for field in dataclasses.fields(kind)} == fields, kind


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<spoken", "not well-formed XML"),
        ("<spoken/>", "lacks <sound>"),
        ('<spoken><sound rate="x" samples="0"/></spoken>', "rate is a number, not 'x'"),
        ('<spoken><sound rate="8000" samples="2">AAAA</sound></spoken>', "the sound is not FLAC"),
        ('<spoken><sound rate="8000" samples="2">%%</sound></spoken>', "not base64"),
        ('<spoken timing="voice"><sound rate="8000" samples="0"/></spoken>', "lacks <words>"),
    ],
)
def test_a_damaged_message_is_refused(text: str, words: str) -> None:
    with pytest.raises(InputError) as problem:
        read_spoken(element_of(text))
    assert words in str(problem.value)


def cut(*lines: str, texts: bool = False) -> list[str]:
    messages = Messages(shipped_library().names, texts)
    found: list[Message] = []
    for line in lines:
        found += messages.take(line + "\n")
    return [message.text for message in found + messages.finish()]


def test_messages_are_lines() -> None:
    assert cut("<a/>", "", "<b>x</b>", "  ", "<c/>") == ["<a/>", "<b>x</b>", "<c/>"]


def test_messages_over_several_lines() -> None:
    assert cut("<a>", "<b/>", "</a>", "<c/>") == ["<a>\n<b/>\n</a>", "<c/>"]
    assert cut("<HeadNod>", '<key at="0" value="0"/>', "</HeadNod>") == [
        '<HeadNod>\n<key at="0" value="0"/>\n</HeadNod>'
    ]


def test_the_papers_open_commands_are_closed() -> None:
    assert cut('<HeadNod at="1000" amplitude="60"', 'count="2">') == ['<HeadNod at="1000" amplitude="60"\ncount="2"/>']
    assert cut('<HeadNod at="0">', '<Smile at="9">', "<b/>") == ['<HeadNod at="0"/>', '<Smile at="9"/>', "<b/>"]
    assert cut('<Smile at="0">', "</Smile>") == ['<Smile at="0">\n</Smile>']


def test_half_a_message_at_the_end_is_left_for_its_reader_to_refuse() -> None:
    assert cut("<spoken>", "<text>x</text>") == ["<spoken>\n<text>x</text>"]


def test_texts() -> None:
    lines = ["Hello.", '<HeadNod at="1"/>', "<emotion name='sad'>a</emotion> b", "That <HeadNod", 'count="2"/> is it.']
    assert cut(*lines, texts=True) == [*lines[:3], 'That <HeadNod\ncount="2"/> is it.']
    document = ['<?xml version="1.0"?>', "<speak>", "Hello", "</speak>"]
    assert cut(*document, "Bye.", texts=True) == ["\n".join(document), "Bye."]
