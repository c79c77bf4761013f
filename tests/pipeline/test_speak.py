from __future__ import annotations

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.pipeline.speak import speak, speak_over
from mien.pipeline.spoken import translate
from mien.speech.sound_reshaping import Change, reshape
from mien.text.intensity import IntensityCurve
from mien.text.score import EmotionSpan, Score
from mien.text.script_reading import read_script
from tests.serve.modules.speaking import toy_speech, toy_voice

__all__ = ["toy_voice"]
pytestmark = pytest.mark.usefixtures("toy_voice")


def spoken(text: str):
    return speak(read_script(text), voice_emotion=0.0)


def times(text: str) -> dict[str, tuple[str, ...]]:
    return {command.name: tuple(command.given.values()) for command in spoken(text).commands}


def test_plain_text_is_spoken_as_ever() -> None:
    assert spoken("That is true.").utterance == toy_speech("That is true.")


def test_a_command_fires_at_its_word() -> None:
    # that DH AE T, is IH Z, true T R UW: from 0.2 s on, a tenth of a second each
    assert times('That is <HeadNod count="2"/> true.') == {"HeadNod": ("2", "700")}


@pytest.mark.parametrize(
    ("at", "ms"),
    [
        ("1000", "1000"),
        ("0.25s", "250"),
        ("+50", "750"),
        ("-50", "650"),
        ("word.end", "1000"),
        ("word.2", "1000"),
        ("word.2.end+10", "1300"),
        ("phone.2", "800"),
        ("phone.UW", "900"),
        ("phone.uw.end", "1000"),
        ("start", "0"),
        ("end", "1500"),
        ("end-100", "1400"),
        ("m", "200"),
        ("m.word.3", "700"),
        ("0.5*m+0.5*here", "450"),
    ],
)
def test_times_words_and_phones(at: str, ms: str) -> None:
    # now N AW: 1.0..1.2, then 0.2 s of silence; the text ends at 1.5 s with the word "a" (AH)
    found = times(f'<mark name="m"/>That is <HeadNod at="{at}"/> true now a.')
    if at.startswith("word.2.end"):
        assert found == {"HeadNod": ("1210",)}
    else:
        assert found == {"HeadNod": (ms,)}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('Yes <HeadNod at="5000"/> no', "text, line 1: HeadNod: its time, 5 s, lies outside the sound"),
        ('Yes <HeadNod at="phone.4"/> no', "the word 'no' has 2 phones"),
        ('Yes <HeadNod at="phone.ZH"/> no', "no phone 'ZH' is said"),
        ('Yes <HeadNod at="word.2"/> no', "there are 1 words from there on"),
        ('<mark name="m"/> Yes <Smile until="m"/> no', "would end"),
        ('Yes <curve parameter="jawOpen" at="9000"><key at="0" value="1"/></curve> no', "outside the sound"),
        ("", "empty"),
        ("...", "can be spoken"),
    ],
)
def test_what_cannot_be_placed_is_refused(text: str, words: str) -> None:
    with pytest.raises(InputError) as problem:
        spoken(text)
    assert words in str(problem.value)


@pytest.mark.parametrize("seconds", [0.1, 0.4, 1.0, 2.5])
def test_a_pause_is_silence_of_its_length(seconds: float) -> None:
    said = spoken(f'Yes <pause seconds="{seconds}"/> no.').utterance
    yes, no = said.words
    assert no.start - yes.end == pytest.approx(seconds, abs=2e-4)
    inside = said.audio.samples[round((yes.end + 0.001) * 8000) : round((no.start - 0.001) * 8000)]
    assert not inside.any()
    assert said.phones.intervals[-1].end == pytest.approx(said.duration)


def test_pauses_at_both_ends() -> None:
    said = spoken('<pause ms="1500"/> Yes <pause ms="700"/><pause ms="300"/>').utterance
    assert said.words.intervals[0].start == pytest.approx(1.5)
    assert said.duration == pytest.approx(1.5 + 0.3 + 1.0)


def test_a_command_around_words_lasts_as_long() -> None:
    commands = {
        c.name: c.given for c in spoken("That <Smile>is true</Smile> <HeadNod count='2'>now now</HeadNod>").commands
    }
    assert commands["Smile"] == {"end": "500", "at": "500"}
    assert commands["HeadNod"] == {"count": "2", "period": "200", "at": "1000"}


def test_room_is_made_for_a_gesture_after_the_last_word() -> None:
    said = translate(spoken('Yes. <HeadNod count="2"/>'))
    assert said.utterance.duration == pytest.approx(said.curves[0].keys[-1][0] / 1000 + 0.1)
    assert not said.utterance.audio.samples[-4000:].any()


def test_gaze_holds_until_the_next() -> None:
    commands = spoken('<gaze target="left"/>That is <gaze target="camera"/> true.').commands
    assert [(c.given["yaw"], c.given["at"], c.given["end"]) for c in commands] == [
        ("22", "200", "500"),
        ("0", "700", "500"),
    ]


def test_intensities_get_times() -> None:
    (span,) = spoken('That <emotion name="sad" intensity="0.3@0,0.8@0.25">is</emotion> true').emotions
    assert isinstance(span.intensity, IntensityCurve)
    assert span.start is not None
    assert span.intensity.times == pytest.approx((span.start, span.start + 0.25), abs=1e-3)
    (share,) = spoken('That <emotion name="sad" intensity="0.3@0%,0.8@100%">is</emotion> true').emotions
    assert isinstance(share.intensity, IntensityCurve)
    assert share.intensity.times == (share.start, share.end)
    with pytest.raises(InputError, match="do not rise in time"):
        spoken('That <emotion name="sad" intensity="0.3@90s,0.8@100%">is</emotion> true')


def test_emotions_get_times() -> None:
    spans = spoken('That <emotion name="sad" intensity="0.3">is</emotion> true').emotions
    assert [(s.name, s.intensity, s.start, s.end) for s in spans] == [("sad", 0.3, 0.5, 0.7)]


def test_the_voice_goes_with_the_emotions_of_the_text_and_the_direction_with_the_words() -> None:
    text = "That <sad>is <HeadNod/> true now</sad> then.".replace("<sad>", '<emotion name="sad">')
    text = text.replace("</sad>", "</emotion>")
    plain, felt = spoken(text), speak(read_script(text))
    assert felt.utterance.duration > 1.1 * plain.utterance.duration
    words = felt.utterance.words.intervals
    (nod,), (span,) = felt.commands, felt.emotions
    assert float(nod.given["at"]) == pytest.approx(1000 * words[2].start, abs=1)
    assert (span.start, span.end) == pytest.approx((words[1].start, words[3].end), abs=2e-3)
    before = round(0.3 * felt.utterance.audio.rate)
    assert np.allclose(felt.utterance.audio.samples[:before], plain.utterance.audio.samples[:before], atol=2e-3)


def test_prosody_that_the_user_sets_wins_over_the_emotion() -> None:
    marked = '<emotion name="sad"><prosody rate="1.25">That is true now.</prosody></emotion>'
    alone = speak(read_script('<prosody rate="1.25">That is true now.</prosody>')).utterance
    both = speak(read_script(marked)).utterance
    inside = [word.duration for word in both.words]
    assert inside == pytest.approx([word.duration for word in alone.words], rel=0.02)
    assert np.abs(both.audio.samples).max() < 0.8 * np.abs(alone.audio.samples).max()


def test_even_prosody_that_asks_for_the_usual_wins() -> None:
    marked = '<emotion name="sad"><prosody rate="medium">That is true now.</prosody></emotion>'
    plain, both = (speak(read_script(text)).utterance for text in ("That is true now.", marked))
    assert [word.duration for word in both.words] == pytest.approx([word.duration for word in plain.words], rel=0.02)


def test_emotions_for_the_whole_are_in_seconds_of_the_result() -> None:
    script = read_script("That is true now a that is true now.")
    score = Score((EmotionSpan("sad", 1.0, start=1.5),))
    felt, plain = speak(script, score=score).utterance, speak(script).utterance
    early = [word for word in felt.words if word.end < 1.2]
    assert early == list(plain.words.intervals[: len(early)])
    assert felt.words.intervals[-1].duration > 1.1 * plain.words.intervals[-1].duration


def test_a_command_without_words_makes_silence() -> None:
    said = spoken('<HeadNod at="1000" amplitude="60" count="2"/>')
    assert said.utterance.duration == 2.0
    assert not said.utterance.audio.samples.any()


def test_direction_over_a_recording() -> None:
    script = read_script('That is <pause seconds="1"/> <HeadNod/> true.')
    said = speak_over(script, lambda text, language, spellings: toy_speech(text))
    assert said.utterance.text.split() == ["That", "is", "true."]
    assert [c.given["at"] for c in said.commands] == ["700"]
    assert "the recording has its own" in said.utterance.notes[0].message


def test_rate_pitch_and_volume_over_a_stretch() -> None:
    said = toy_speech("now now now now now now")
    slow = reshape(said, [Change(0.4, 0.8, rate=0.5)])
    assert slow.duration == pytest.approx(said.duration + 0.4, abs=2e-4)
    assert [w.start for w in slow.words] == pytest.approx([0.2, 0.4, 0.8, 1.2, 1.4, 1.6])
    high = reshape(said, [Change(0.2, 1.4, pitch=12.0)])
    assert len(high.audio) == len(said.audio)

    def tone(sound: np.ndarray) -> float:
        middle = sound[4000:8000]
        return float(np.argmax(np.abs(np.fft.rfft(middle * np.hanning(len(middle))))) * 8000 / len(middle))

    assert tone(slow.audio.samples) == pytest.approx(200, abs=4)
    assert tone(high.audio.samples) == pytest.approx(400, abs=6)
    soft = reshape(said, [Change(0.5, 1.0, volume=-6.0)]).audio.samples
    level = np.abs(soft[5000:7000]).max() / np.abs(said.audio.samples[5000:7000]).max()
    assert level == pytest.approx(10 ** (-6 / 20), rel=1e-3)
    np.testing.assert_array_equal(soft[:3800], said.audio.samples[:3800])


def test_stretching_keeps_what_is_not_stretched() -> None:
    rng = np.random.default_rng(3)
    said = toy_speech("now now now now now now now now")
    noise = type(said)(**(vars(said) | {"audio": type(said.audio)(0.1 * rng.standard_normal(len(said.audio)), 8000)}))
    slow = reshape(noise, [Change(1.2, 1.4, rate=0.8)])
    np.testing.assert_allclose(slow.audio.samples[:8000], noise.audio.samples[:8000], atol=1e-6)


def test_prosody_in_a_script_moves_words_and_commands() -> None:
    said = spoken('That <prosody rate="50%">is</prosody> <HeadNod/> true.')
    assert said.commands[0].given["at"] == "900"
    assert [word.label for word in said.utterance.words] == ["that", "is", "true"]


@pytest.mark.parametrize(
    ("text", "times"),
    [
        ("<pause ms='600'/><HeadNod/><pause ms='400'/>", [600]),
        ("<Blink/><pause ms='300'/><Blink/><pause ms='300'/><Blink/>", [0, 300, 600]),
        ("ah <pause ms='500'/> <Blink/> <pause ms='300'/> <Blink/> ah", [800, 1100]),
        ("ah <pause ms='500'/> <Blink/>", [800]),
    ],
)
@pytest.mark.usefixtures("toy_voice")
def test_a_command_between_pauses_comes_after_those_before_it(text: str, times: list[float]) -> None:
    assert [float(command.given["at"]) for command in speak(read_script(text)).commands] == pytest.approx(times)


def test_an_emotion_over_silence_lasts_as_long_as_its_pauses() -> None:
    text = "<pause ms='500'/><emotion name='sad'><pause ms='1900'/></emotion><pause ms='100'/>"
    spoken = speak(read_script(text))
    assert spoken.utterance.duration == pytest.approx(2.5)
    assert [(span.name, span.start, span.end) for span in spoken.emotions] == [("sad", 0.5, 2.4)]


def test_pronunciations_reach_the_recording() -> None:
    script = read_script('My <phoneme alphabet="x-arpabet" ph="V AO S">voice</phoneme>. <break time="1s"/> '
                         '<phoneme alphabet="x-arpabet" ph="T R UW">true</phoneme>')  # fmt: skip
    asked = []

    def listen(text, language, spellings):
        asked.extend((text[start:end], phones) for start, end, phones in spellings)
        return toy_speech(text)

    speak_over(script, listen)
    assert asked == [("voice", ("V", "AO", "S")), ("true", ("T", "R", "UW"))]
