from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mien.core.errors import InputError
from mien.text.script_reading import read_script, read_script_file
from mien.text.sync_points import Moment

SSML = """<?xml version="1.0" encoding="UTF-8"?>
<!DOCTYPE speak PUBLIC "-//W3C//DTD SYNTHESIS 1.0//EN" "http://www.w3.org/TR/speech-synthesis/synthesis.dtd">
<speak version="1.1" xmlns="http://www.w3.org/2001/10/synthesis"
       xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xml:lang="en-US">
  <metadata><title>not spoken</title></metadata>
  <p>
    <s>You have 4 new messages</s>
    <s>The first is from <emphasis level="strong">Stephanie</emphasis>
       and arrived at <break time="300ms"/> <say-as interpret-as="time" format="hms12">3:45pm</say-as>.</s>
    <s>The subject is <prosody rate="-20%" pitch="+2st" volume="soft">ski trip</prosody>,
       <sub alias="World Wide Web Consortium">W3C</sub>, <say-as interpret-as="characters">b2b</say-as>,
       <phoneme alphabet="ipa" ph="t&#x259;mei&#x325;&#x27E;ou&#x325;">tomato</phoneme></s>
  </p>
  <mark name="m1"/><mark name="end"/><audio src="beep.wav">a beep</audio> <HeadNod at="m1"/> done.
</speak>
"""

BML = """<?xml version="1.0"?>
<bml xmlns="http://www.bml-initiative.org/bml/bml-1.0" xmlns:x="http://example.org/x" id="bml1" character="Alice">
  <required>
    <speech id="speech1" start="0.5">
      <text>This is <sync id="tm1"/> an example <sync id="tm2"/> of speech.</text>
    </speech>
  </required>
  <head id="head1" lexeme="NOD" stroke="speech1:tm1" repetition="1" amount="0.5"/>
  <head id="head2" lexeme="SHAKE" start="head1:end + 0.25" end="bml1:speech1:end"/>
  <gaze id="gaze1" target="left" influence="HEAD" start="speech1:start" relax="speech1:tm2"/>
  <faceLexeme id="face1" lexeme="RAISE_BROWS" start="speech1:tm1-0.2" attackPeak="speech1:tm1" end="speech1:end"/>
  <faceLexeme id="face2" lexeme="SMILE" amount="1"/>
  <gesture id="g1" lexeme="BEAT" stroke="speech1:tm1"/>
  <constraint><synchronize ref="speech1:tm2"><sync ref="face2:attackPeak"/></synchronize></constraint>
</bml>
"""


@pytest.mark.parametrize(
    "text",
    [
        "I <3 you",
        "if a < b and c > d",
        "a <- b -> c",
        "x<y",
        "AT&T & Sons &c",
        "<>",
        "< HeadNod >",
        "5<6>4",
        "List<String> names",
        "(<_<)",
        "<",
        "end <",
        "<!-",
        "« <",
    ],
)
def test_text_that_is_no_tag_is_spoken_as_it_is(text: str) -> None:
    script = read_script(text)
    assert [segment.text for segment in script.segments] == [text]
    assert not script.commands


@given(
    st.text(st.characters(exclude_categories=["Cs", "Cc", "Cn"], exclude_characters="&"), max_size=30).filter(
        lambda t: t.strip()
    )
)
def test_any_text_is_read_or_refused_in_one_line(text: str) -> None:
    try:
        script = read_script(text)
    except InputError:
        assert "<" in text
        return
    if "<" not in text:
        assert script.text.strip() == text.strip()


def test_entities_stand_for_their_signs() -> None:
    assert read_script("3 &lt; 4 &amp; &#x3c;HeadNod/&gt;").text == "3 < 4 & <HeadNod/>"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("One.\nTwo <HeadNodd/> three", "text, line 2: unknown tag <HeadNodd>: did you mean <HeadNod>"),
        ("<smile/>", "did you mean <Smile>"),
        ("<emotion name='sad'>\nTwo\n", "line 1: <emotion> is never closed: expected </emotion>"),
        ("One </emotion> two", "line 1: </emotion> closes nothing"),
        ("\n<HeadNod count=2/> two", "line 2: the tag '<HeadNod count=2/> two' is not well formed"),
        ("<emotion name='sad'>a<emphasis>b</emotion>c</emphasis>", "<emphasis> of line 1 is open"),
        ("<emotion>a</emotion>", "name= is missing"),
        ("<emotion name='sad' intensity='40'>a</emotion>", "did you mean 0.4"),
        ("<emotion name='sad' inten='1'>a</emotion>", "did you mean 'intensity'"),
        ("a <HeadNod cuont='2'/>", "did you mean 'count'"),
        ("a <HeadNod at='hree'/> <mark name='here1'/>", "unknown mark 'hree': did you mean 'here1'"),
        ("a <HeadNod at='5 apples'/>", "a time is milliseconds"),
        ("a <pause seconds='-1'/>", "a pause is such as"),
        ("a <break strength='huge'/>", "unknown strength"),
        ("a <gaze target='lefft'/>", "did you mean 'left'"),
        ("a <curve parameter='jawOpn'><key at='0' value='1'/></curve>", "did you mean 'jawOpen'"),
        ("a <curve parameter='jawOpen'></curve>", "at least one <key"),
        ("a <key at='0' value='1'/>", "stands in a <curve>"),
        ("<prosody rate='warp'>a</prosody>", "a rate is such as"),
        ("<phoneme alphabet='x-arpabet' ph='QQ'>a</phoneme>", "unknown ARPAbet phone 'QQ'"),
        ("<mark name='m'/>a<mark name='m'/>", "stands there twice"),
        ("<?xml version='1.0'?>\n<script>\n<emotion name='sad'>\n</script>", "line 4: not well-formed XML"),
        ("<?xml version='1.0'?>\n<html>hello</html>", "not <html>"),
        ("<script><!DOCTYPE x [<!ENTITY a 'b'>]></script>", "not well-formed"),
    ],
)
def test_a_fault_names_its_line_and_what_was_expected(text: str, words: str) -> None:
    with pytest.raises(InputError) as problem:
        read_script(text)
    assert words in str(problem.value)
    assert str(problem.value).startswith("text")


def test_own_entities_cannot_blow_up() -> None:
    bomb = '<?xml version="1.0"?><!DOCTYPE script [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><script>&b;</script>'
    with pytest.raises(InputError, match="own entities are not read"):
        read_script(bomb)


def test_the_papers_open_tag_is_accepted_and_closed() -> None:
    (item,) = read_script('Well <HeadNod at="1000" amplitude="60"\ncount="2"> then').commands
    assert item.at == Moment((), 1000.0)
    assert item.until is None
    assert item.command.given == {"amplitude": "60", "count": "2"}


def test_an_intensity_changes_inside_a_tag() -> None:
    script = read_script(
        '<emotion name="happy" intensity="0.2@0,0.9@1.5">a <emotion name="sad">b</emotion> c</emotion> d '
        '<emotion name="angry" intensity=".1@0%, 1@50%">e f</emotion>'
    )
    happy, sad, again, angry = script.emotions
    begins = str(happy.start)
    assert (happy.name, sad.name, again.name, sad.keys) == ("happy", "sad", "happy", ())
    # Both pieces keep the clock of the tag.
    assert happy.keys == again.keys
    assert [(str(moment), value) for moment, value in happy.keys] == [(begins, 0.2), (f"{begins}+1500", 0.9)]
    assert [(str(moment), value) for moment, value in angry.keys] == [
        (str(angry.start), 0.1),
        (f"0.5*{angry.start}+0.5*{angry.end}", 1.0),
    ]


@pytest.mark.parametrize(
    ("intensity", "told"),
    [
        ("0.2@0,0.9", "VALUE@SECOND or VALUE@PERCENT%"),
        ("0.2@1,0.9@0.5", "'0.9@0.5' does not come after"),
        ("0.2@0%,0.9@120%", "between 0% and 100%"),
        ("0.2@0,9@1", "from 0 to 1, not 9"),
        ("much", "points such as 0.2@0"),
        ("nan", "from 0 to 1"),
        ("0.2@-1", "VALUE@SECOND"),
    ],
)
def test_a_wrong_intensity_is_told(intensity: str, told: str) -> None:
    with pytest.raises(InputError, match=re.escape(told)) as problem:
        read_script(f"\n<emotion name='sad' intensity='{intensity}'>a</emotion>")
    assert "line 2" in str(problem.value)


def test_the_innermost_emotion_counts_and_the_outer_goes_on_after_it() -> None:
    script = read_script('<emotion name="happy" intensity="0.6">a <emotion name="sad">b</emotion> c</emotion> d')
    assert [(e.name, e.intensity, str(e.start), str(e.end)) for e in script.emotions] == [
        ("happy", 0.6, "_1", "_2"),
        ("sad", 1.0, "_2", "_3"),
        ("happy", 0.6, "_3", "_4"),
    ]


def test_a_command_around_words_lasts_as_long_as_they_do() -> None:
    (item,) = read_script("a <Smile>b c</Smile> d").commands
    assert (str(item.at), str(item.until)) == ("_1", "_2")


def test_ssml_in_the_style_of_its_specification() -> None:
    script = read_script(SSML)
    assert script.language == "en-US"
    assert [segment.silence for segment in script.segments] == [None, 300.0]
    assert (
        script.segments[0].text.strip().startswith("You have 4 new messages. The first is from Stephanie and arrived")
    )
    assert "World Wide Web Consortium, B. 2 B., tomato." in script.segments[1].text
    assert script.segments[1].spellings[0].phones[:3] == ("T", "AH", "M")
    assert [(p.rate, p.pitch, p.volume) for p in script.prosody] == [(0.8, 1.5, 4.0), (0.8, 2.0, -6.0)]
    assert [str(item.at) for item in script.commands] == ["m1"]
    told = " ".join(note.message for note in script.notes)
    assert "not spoken" not in script.text
    for word in ("<metadata>", "format='hms12'", "'beep.wav'", "called 'end'"):
        assert word in told


def test_bml_in_the_style_of_its_specification() -> None:
    script = read_script(BML)
    assert script.text == "This is an example of speech."
    assert script.segments[0].start == Moment((), 500.0)
    nod, shake, look = script.commands
    assert str(nod.at) == "speech1:tm1-198"  # the stroke of a nod lies a third of 0.6 s after its start
    assert str(shake.at) == "speech1:tm1+652"
    assert str(shake.until) == "speech1:end"
    assert look.command.name == "LookAt"
    by_parameter = {curve.parameter: curve for curve in script.curves}
    brows = by_parameter["browInnerUp"].keys
    assert [str(moment) for moment, _ in brows][:2] == ["speech1:tm1-200", "speech1:tm1"]
    assert str(brows[2][0]) == "0.375*speech1:tm1+0.625*speech1:end"
    assert str(by_parameter["mouthSmile"].keys[1][0]) == "speech1:tm2"
    assert by_parameter["mouthSmile"].keys[1][1] == pytest.approx(1.05)
    told = " ".join(note.message for note in script.notes)
    assert "<gesture> cannot be shown" in told
    assert "character='Alice'" in told


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("speech1:tm1-0.2", "speech2:tm1", "unknown behaviour 'speech2': did you mean 'speech1'"),
        ("speech1:tm1-0.2", "speech1:tm3", "unknown sync point of speech1 'tm3': did you mean"),
        ("speech1:tm1-0.2", "soon", "a sync reference is seconds"),
        ('lexeme="NOD"', 'lexeme="NODD"', "did you mean 'NOD'"),
        ('repetition="1"', 'repetition="x"', "whole number"),
        ('amount="0.5"', 'amount="5"', "from 0 to 1"),
        ('stroke="speech1:tm1" rep', 'stroke="head2:start" rep', "in a circle"),
        ('id="head2"', 'id="head1"', "stands there twice"),
    ],
)
def test_a_fault_in_bml_names_its_line(old: str, new: str, words: str) -> None:
    assert old in BML
    with pytest.raises(InputError) as problem:
        read_script(BML.replace(old, new))
    assert words in str(problem.value)
    assert str(problem.value).startswith("text, line ")


def test_files(tmp_path: Path) -> None:
    (tmp_path / "a.ssml").write_text(SSML, encoding="utf-8")
    assert read_script_file(tmp_path / "a.ssml").segments
    for name, words in (("b.ssml", "no such script"), ("c.pdf", "a script is a file .txt")):
        with pytest.raises(InputError, match=words):
            read_script_file(tmp_path / name)
    (tmp_path / "d.txt").write_bytes(b"caf\xe9")
    script = read_script_file(tmp_path / "d.txt")
    assert script.text == "café"
    assert [note.message for note in script.notes] == ["d.txt is not in UTF-8: read as Windows-1252 (Western European)"]
    (tmp_path / "e.xml").write_bytes(
        "<?xml version='1.0' encoding='iso-8859-2'?><speak>Łódź</speak>".encode("iso-8859-2")
    )
    assert read_script_file(tmp_path / "e.xml").text == "Łódź"


@given(
    st.lists(
        st.tuples(st.sampled_from(["a", "m1", "s:tm"]), st.floats(0.01, 1).map(lambda x: round(x, 3))), max_size=3
    ),
    st.integers(-5000, 5000),
)
def test_moments_read_back(terms: list[tuple[str, float]], offset: int) -> None:
    moment = Moment(tuple(terms), float(offset))
    assert Moment.parse(str(moment)) == moment
