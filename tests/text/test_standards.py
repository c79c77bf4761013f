"""SSML 1.1 and BML 1.0 documents in the style of their specifications: read, and what is not followed is told."""

from __future__ import annotations

from pathlib import Path

import pytest

from mien.core.errors import InputError
from mien.pipeline.speak import speak
from mien.pipeline.spoken import translate
from mien.text.script_reading import read_script, read_script_file
from tests.serve.modules.speaking import toy_voice

__all__ = ["toy_voice"]
SPEAK = '<speak version="1.1" xmlns="http://www.w3.org/2001/10/synthesis" xml:lang="en-US"'

SSML = [
    (
        f"""<?xml version="1.0"?>
        {SPEAK} xml:base="http://www.example.com/base.ssml" startmark="m1" onlangfailure="processorchoice">
          <lexicon uri="http://www.example.com/lexicon.pls" xml:id="pharmacy" type="application/pls+xml"/>
          <meta name="seeAlso" content="http://example.com/my-ssml-metadata.xml"/>
          <metadata><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">not this</rdf:RDF></metadata>
          <lookup ref="pharmacy"><mark name="m1"/>Take aspirin</lookup> now.
        </speak>""",
        "Take aspirin now.",
        ["<lexicon>", "<meta>", "<metadata>", "lookup: lexicons", "startmark", "onlangfailure"],
    ),
    (
        f"""{SPEAK}>
          <voice gender="female" languages="en-US" required="gender">Mary had a lamb,</voice>
          <voice name="Mike Paul" onvoicefailure="priorityselect">it went with her,</voice>
          <voice age="6" variant="2" ordering="gender age">to school.</voice>
        </speak>""",
        "Mary had a lamb, it went with her, to school.",
        ["gender", "languages", "required", "onvoicefailure", "age", "variant", "ordering"],
    ),
    (
        f"""{SPEAK}>
          The price of XYZ is <prosody rate="-10%">$45</prosody>
          <prosody contour="(0%,+20Hz) (10%,+30%) (40%,+10Hz)" range="high" duration="3s">good morning</prosody>
          <prosody pitch="+20Hz" volume="+6dB">up</prosody> <prosody rate="700%" pitch="150Hz">on</prosody>
          <prosody volume="+10%" pitch="x-high" rate=" fast ">now</prosody>
        </speak>""",
        "The price of XYZ is $45 good morning up on now",
        ["contour", "range", "duration", "+20Hz", "700%", "150Hz", "+10%"],
    ),
    (
        f"""{SPEAK}>
          <p xml:lang="fr" onlangfailure="ignorelang"><s>Bonjour</s></p>
          <s xml:lang="en-GB">I saw <lang xml:lang="fr">Madame</lang> at <w role="ex:verb">home</w>
          <token>today</token></s>
        </speak>""",
        "Bonjour. I saw Madame at home today.",
        ["<p>: xml:lang='fr'", "<lang>: xml:lang='fr'", "w: role='ex:verb'"],
    ),
    (
        f"""{SPEAK} xmlns:mstts="https://www.w3.org/2001/mstts" xmlns:mien="https://mien.example/1">
          <mstts:express-as style="cheerful">Hello.</mstts:express-as>
          <amazon:effect name="whispered">psst</amazon:effect>
          <par><media><p>And</p></media></par> <mien:HeadNod/> yes <emphasis mstts:strength="2">now</emphasis>
        </speak>""",
        "Hello. psst And. yes now",
        ["<express-as>", "<effect>", "<par>", "<media>", "mstts:strength"],
    ),
    (
        f"""{SPEAK}>
          Please say <audio src="prompt.au" fetchtimeout="10s" repeatCount="2" soundLevel="+6dB">your
          <desc>a prompt</desc> name</audio> <phoneme alphabet="x-sampa" ph="d'lt@">delta</phoneme>
          <phoneme alphabet="ipa" type="ruby" ph="&#x2A7;i&#x2D0;z">cheese</phoneme>
          on <say-as interpret-as="date" format="mdy">2/10/04</say-as> <say-as interpret-as="vxml:boolean">yes</say-as>
          <break/><break strength="x-strong"/><break time="250ms"/> <mark name="go here"/> &amp; <![CDATA[a < b]]>
        </speak>""",
        "Please say your name delta cheese on 2/10/04 yes & a < b",
        ["'prompt.au'", "<desc>", "x-sampa", "type='ruby'", "format='mdy'", "vxml:boolean", "'go here'"],
    ),
]


@pytest.mark.usefixtures("toy_voice")
@pytest.mark.parametrize(("text", "spoken", "told"), SSML, ids=range(len(SSML)))
def test_ssml(text: str, spoken: str, told: list[str]) -> None:
    script = read_script(text)
    assert " ".join(script.text.split()) == spoken
    notes = " | ".join(note.message for note in script.notes)
    assert [word for word in told if word not in notes] == []
    assert all("text, line " in note.message for note in script.notes)
    if not any(char.isdigit() for char in spoken):
        assert translate(speak(script)).utterance.words.intervals


@pytest.mark.usefixtures("toy_voice")
def test_a_voice_that_is_not_there_is_told_in_ssml_and_an_error_in_a_script() -> None:
    spoken = speak(read_script(f'{SPEAK}><voice name="Mike kokoro-haert">Oh dear.</voice></speak>'))
    (note,) = [note.message for note in spoken.utterance.notes if "usual voice" in note.message]
    assert "'Mike'" in note
    assert "did you mean 'kokoro-heart'" in note
    with pytest.raises(InputError, match="unknown voice 'Mike'"):
        speak(read_script('<script><voice name="Mike Paul">Oh dear.</voice></script>'))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (f"{SPEAK}><emphasys>a</emphasys></speak>", "did you mean <emphasis>"),
        (f'{SPEAK}><prosody rate="warp">a</prosody></speak>', "a rate is such as"),
        (f'{SPEAK}>\n<emphasis level="huge">a</emphasis></speak>', "line 2: unknown level of emphasis 'huge'"),
        (f"{SPEAK}>\n<p>a</speak>", "line 2: not well-formed XML"),
        ('<!DOCTYPE speak SYSTEM "x.dtd"><speak>a &nosuch; b</speak>', "the entity &nosuch; is not known"),
    ],
)
def test_slips_of_the_pen_are_errors(text: str, words: str) -> None:
    with pytest.raises(InputError) as problem:
        read_script(text)
    assert words in str(problem.value)


def test_the_encoding_that_a_document_declares(tmp_path: Path) -> None:
    text = '<?xml version="1.0" encoding="{}"?>\n<speak>caf\u00e9</speak>'
    for encoding in ("ISO-8859-1", "utf-8", "UTF-16"):
        path = tmp_path / f"{encoding}.ssml"
        path.write_bytes(text.format(encoding).encode(encoding))
        assert read_script_file(path).text == "caf\u00e9", encoding
    (tmp_path / "x.ssml").write_bytes(text.format("klingon").encode())
    with pytest.raises(InputError, match="encoding 'klingon' is not known"):
        read_script_file(tmp_path / "x.ssml")


def block(content: str, attributes: str = 'id="bml1"') -> str:
    return f"""<?xml version="1.0"?>
<bml xmlns="http://www.bml-initiative.org/bml/bml-1.0" xmlns:ext="http://www.example.org/ext" {attributes}>
{content}
</bml>"""


SPEECH = """<speech id="speech_1">
  <text>This is a <sync id="s1"/> complete <sync id="s-2"/> core <sync id="s3"/>speech.</text></speech>"""

BML = [
    (
        block(
            SPEECH
            + """
            <gesture id="beat_1" lexeme="BEAT" mode="BOTH_HANDS" stroke="speech_1:s1"/>
            <head id="nod_1" lexeme="NOD" start="beat_1:strokeStart" end="beat_1:end+0.2"/>
            <constraint id="c1">
              <synchronize ref="speech_1:s3">
                <sync ref="beat_1:stroke:2"/><sync ref="nod_1:stroke"/>
              </synchronize>
              <after ref="speech_1:start"><sync ref="gaze_1:start"/></after>
              <before ref="nod_1:stroke"><sync ref="gaze_1:end"/></before>
            </constraint>
            <gaze id="gaze_1" target="AUDIENCE" influence="WAIST"/>"""
        ),
        ["<gesture> cannot be shown", "the repetition 2", "'AUDIENCE'", "influence='WAIST'", "has a time already"],
        2,
    ),
    (
        block(
            """<required><gesture id="g1" lexeme="WAVE"/>
            <head id="h1" lexeme="SHAKE" repetition="2" amount="1"/></required>
            <posture id="p1"><stance type="SITTING"/><pose part="ARMS" lexeme="ARMS_CROSSED"/></posture>
            <postureShift id="p2"/><locomotion id="l1" target="door"/><pointing id="q1" target="door"/>
            <wait id="w1" duration="1.5"/><head id="h2" lexeme="NOD" start="w1:end"/>
            <ext:animation id="x1" start="h2:end"/><blink id="b1"/>""",
            'id="bml1" composition="APPEND" characterId="Alice" ext:priority="2"',
        ),
        [
            "<gesture> cannot be shown by a head and is left out, although it is required",
            "<posture>",
            "<postureShift>",
            "<locomotion>",
            "<pointing>",
            "<wait>",
            "<animation>",
            "<blink>",
            "composition='APPEND'",
            "characterId='Alice'",
            "ext:priority",
        ],
        2,
    ),
    (
        block(
            SPEECH
            + """
            <faceLexeme id="f1" lexeme="RAISE_LEFT_BROW" amount="0.8" start="speech_1:s-2" overshoot="0.2"/>
            <faceLexeme id="f2" lexeme="LOWER_RIGHT_MOUTH_CORNER" attackPeak="speech_1:s1"/>
            <faceFacs id="f3" au="1" side="LEFT" amount="0.3" start="bml1:speech_1:start" end="bml1:end"/>
            <face id="f4" start="speech_1:s3 - 0.1"><faceLexeme lexeme="OPEN_LIPS"/><faceFacs au="6"/><viseme/></face>
            <faceShift id="f5" lexeme="RAISE_MOUTH_CORNERS" start="bml1:start+0.1"/>
            <headDirectionShift id="d1" target="left" start="speech_1:s1"/>
            <gazeShift id="g1" target="right" influence="HEAD" start="bml2:speech_1:s3" ready="speech_1:end"/>
            <faceLexeme id="f6" lexeme="XENOMORPH"/>"""
        ),
        ["overshoot='0.2'", "<viseme> in <face>", "no other block", "the lexeme 'XENOMORPH' is not known"],
        1,
    ),
    (
        block(
            """<speech id="s"><description priority="1" type="application/ssml+xml"><speak>Hello
            <mark name="m"/> <emphasis>world</emphasis></speak></description></speech>
            <head id="h" lexeme="NOD" stroke="s:m" mode="x"/>
            <constraint><synchronize><sync ref="s:end"/><sync ref="f:end"/></synchronize></constraint>
            <faceLexeme id="f" lexeme="SMILE"/>"""
        ),
        ["commands and prosody inside", "mode='x'"],
        1,
    ),
]


@pytest.mark.usefixtures("toy_voice")
@pytest.mark.parametrize(("text", "told", "commands"), BML, ids=range(len(BML)))
def test_bml(text: str, told: list[str], commands: int) -> None:
    script = read_script(text)
    notes = " | ".join(note.message for note in script.notes)
    assert [word for word in told if word not in notes] == []
    assert len(script.commands) == commands
    assert translate(speak(script)).curves


def test_what_is_not_shown_keeps_its_time() -> None:
    script = read_script(BML[1][0])
    assert [item.at.offset for item in script.commands] == [0.0, 1500.0]
    script = read_script(BML[0][0])
    assert str(script.commands[0].at).startswith("speech_1:s1")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ('<head id="h" lexeme="NODD"/>', "did you mean 'NOD'"),
        ('<head id="h"/>', "needs lexeme="),
        ('<faceFacs id="f"/>', "needs au="),
        ('<faceFacs id="f" au="99"/>', "no action unit of this face"),
        ('<wait id="w" duration="soon"/>', "duration is seconds"),
        ("<constraint><synchronize/></constraint>", "needs ref="),
        ('<head id="h" lexeme="NOD" start="a:b:c:d:e"/>', "a sync reference is seconds"),
        ('<head id="h" lexeme="NOD" start="x:end"/>', "unknown behaviour 'x'"),
    ],
)
def test_faults_in_bml_name_their_line(content: str, words: str) -> None:
    with pytest.raises(InputError) as problem:
        read_script(block(content))
    assert str(problem.value).startswith("text, line 3: ")
    assert words in str(problem.value)
