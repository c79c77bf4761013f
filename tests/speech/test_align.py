from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from mien.core.audio import Audio
from mien.core.errors import AlignmentError, InputError
from mien.core.utterance import PAUSE
from mien.formats.sound_files import read_audio
from mien.speech import text_search
from mien.speech.align import align, align_words
from mien.text.normalisation import spoken_words
from mien.text.pronunciation import pronunciations

SENTENCE = ("dr1-mcpm0", "sx204")  # "Even I occasionally get the Monday blues."


def recording(shared_data: Path, speaker: str, sentence: str) -> tuple[Audio, str, list[tuple[float, str]]]:
    """A sound, its text, and the start of each word in seconds."""
    path = shared_data / "timit-sample" / speaker / f"{sentence}.flac"
    text = " ".join(path.with_suffix(".txt").read_text().split()[2:])
    lines = [line.split() for line in path.with_suffix(".wrd").read_text().splitlines()]
    return read_audio(path)[0], text, [(int(first) / 16_000, word) for first, _, word in lines]


@pytest.mark.data
def test_words_start_where_a_person_says_they_do(shared_data: Path) -> None:
    audio, text, labels = recording(shared_data, *SENTENCE)
    utterance = align(audio, text)
    assert utterance.timing == "aligned"
    assert utterance.notes == ()
    assert [word.label for word in utterance.words] == [word for _, word in labels]
    errors = [abs(word.start - start) for word, (start, _) in zip(utterance.words, labels, strict=True)]
    assert np.median(errors) < 0.025
    assert max(errors) < 0.06


@pytest.mark.data
def test_phones_cover_the_sound_without_gaps(shared_data: Path) -> None:
    audio, text, _ = recording(shared_data, *SENTENCE)
    utterance = align(audio, text)
    phones = utterance.phones.intervals
    assert phones[0].start == 0.0
    assert phones[-1].end == audio.duration
    assert all(before.end == after.start for before, after in pairwise(phones))
    assert phones[0].label == phones[-1].label == PAUSE
    assert not any(a.label == b.label == PAUSE for a, b in pairwise(phones))


@pytest.mark.data
def test_other_rates_and_numbers_in_the_text_work(shared_data: Path) -> None:
    path = shared_data / "grid-s1" / "audio" / "bbaf2n.flac"
    audio = read_audio(path)[0].resampled(44_100)
    utterance = align(audio, "Bin blue at F 2, now!")
    assert [word.label for word in utterance.words] == ["bin", "blue", "at", "f", "two", "now"]
    assert utterance.phones.intervals[-1].end == audio.duration


@pytest.mark.data
def test_the_same_input_gives_the_same_times(shared_data: Path) -> None:
    audio, text, _ = recording(shared_data, *SENTENCE)
    assert align(audio, text) == align(audio, text)


@pytest.mark.data
def test_a_long_sound_is_settled_as_it_goes(shared_data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = [("dr1-mcpm0", s) for s in ("sx204", "sa1", "sa2", "si1194", "sx24", "sx294", "sx384", "sx114", "si564")]
    parts = [recording(shared_data, *name) for name in names]
    audio = Audio.join([part[0] for part in parts])
    monkeypatch.setattr(text_search, "_SETTLE", 300)
    labels, offset = [], 0.0
    for sound, _, words in parts:
        labels += [(offset + start, word) for start, word in words]
        offset += sound.duration
    utterance = align(audio, " ".join(text for _, text, _ in parts))
    assert [word.label for word in utterance.words] == [word for _, word in labels]
    errors = [abs(word.start - start) for word, (start, _) in zip(utterance.words, labels, strict=True)]
    assert np.median(errors) < 0.025
    assert np.mean(np.array(errors) < 0.1) > 0.95


@pytest.mark.data
def test_a_text_that_is_not_said_gives_a_warning(shared_data: Path) -> None:
    audio, _, _ = recording(shared_data, *SENTENCE)
    utterance = align(audio, "She had your dark suit in greasy wash water all year.")
    assert any(note.kind == "warning" and "does not seem to fit" in note.message for note in utterance.notes)


@pytest.mark.data
def test_a_wrong_middle_is_named_in_the_warning(shared_data: Path) -> None:
    audio, _, _ = recording(shared_data, *SENTENCE)
    utterance = align(audio, "Even I occasionally get the seven purple mountain cats Monday blues.")
    (warning, *_) = [note.message for note in utterance.notes if note.kind == "warning"]
    assert "purple" in warning
    assert "Even" not in warning


def test_silence_is_not_aligned() -> None:
    utterance = align(Audio.silence(2.0, 22_050), "Hello there.")
    assert utterance.timing == "none"
    assert [(i.start, i.end, i.label) for i in utterance.phones] == [(0.0, 2.0, PAUSE)]
    assert len(utterance.words) == 0
    assert [note.kind for note in utterance.notes] == ["warning"]


def test_noise_still_gets_a_mouth_and_a_warning() -> None:
    noise = np.random.default_rng(1).normal(0, 0.1, 32_000)
    utterance = align(Audio(noise, 16_000), "hello there my friend")
    assert len(utterance.words) == len(spoken_words("hello there my friend").words)
    assert any(note.kind == "warning" for note in utterance.notes)


@pytest.mark.parametrize(
    ("seconds", "text", "language", "said"),
    [
        (1.0, "", "en-US", "at least one word"),
        (1.0, "Dia dhuit", "ga-IE", "unknown language .ga-IE."),
        (0.05, "hello", "en-US", "at least 0.1 s"),
    ],
)
def test_bad_input_is_refused(seconds: float, text: str, language: str, said: str) -> None:
    sound = Audio(np.full(round(seconds * 16_000), 0.1), 16_000)
    with pytest.raises(InputError, match=said):
        align(sound, text, language=language)


def test_more_words_than_frames_is_an_alignment_error() -> None:
    noise = Audio(np.random.default_rng(1).normal(0, 0.1, 3200), 16_000)
    words = ["seventeen"] * 30
    with pytest.raises(AlignmentError, match="check that the text"):
        align_words(noise, words, [pronunciations(word) for word in words])


@pytest.mark.data
def test_noise_is_named_and_not_blamed_on_the_text(shared_data: Path) -> None:
    audio, text, labels = recording(shared_data, *SENTENCE)
    hiss = np.random.default_rng(1).normal(0, audio.samples.std() * 10 ** (-8 / 20), len(audio.samples))
    utterance = align(Audio(audio.samples + hiss, audio.rate), text)
    (note,) = [note.message for note in utterance.notes]
    assert "noise lies about" in note
    errors = [abs(word.start - start) for word, (start, _) in zip(utterance.words, labels, strict=True)]
    assert np.median(errors) < 0.03


@pytest.mark.data
def test_words_left_out_of_the_text_are_noticed_and_do_not_move_the_others(shared_data: Path) -> None:
    audio, text, labels = recording(shared_data, *SENTENCE)
    kept = [*range(2), *range(3, len(labels))]
    utterance = align(audio, " ".join(text.split()[place] for place in kept))
    assert any("no words for" in note.message for note in utterance.notes)
    errors = [abs(word.start - labels[place][0]) for word, place in zip(utterance.words, kept, strict=True)]
    assert max(errors) < 0.1
