"""Words and phones at times that a person has given."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.core.timeline import Interval, Tier
from mien.core.utterance import PAUSE
from mien.speech.given_times import spoken_as_given


@pytest.fixture
def sound() -> Audio:
    return Audio(np.random.default_rng(1).normal(0, 0.05, 16_000), 16_000)


def tier(name: str, *intervals: tuple[float, float, str]) -> Tier:
    return Tier(name, tuple(Interval(*interval) for interval in intervals))


WORDS = tier("words", (0.2, 0.5, "never"), (0.6, 0.9, "said"))


def test_phones_are_taken_as_they_are_and_pauses_filled(sound: Audio) -> None:
    phones = tier("phones", (0.2, 0.3, "N"), (0.3, 0.5, "EH1"), (0.5, 0.6, "sp"), (0.6, 0.9, "S"))
    spoken = spoken_as_given(sound, [WORDS, phones])
    assert [(p.start, p.end, p.label) for p in spoken.phones] == [
        (0.0, 0.2, PAUSE), (0.2, 0.3, "N"), (0.3, 0.5, "EH"), (0.5, 0.6, PAUSE), (0.6, 0.9, "S"), (0.9, 1.0, PAUSE),
    ]  # fmt: skip
    assert spoken.words == WORDS
    assert spoken.timing == "given"


def test_ipa_is_understood(sound: Audio) -> None:
    spoken = spoken_as_given(sound, [tier("Anna - phones", (0.0, 0.4, "aɪ"), (0.4, 1.0, "ˈʃ"))])
    assert [phone.label for phone in spoken.phones] == ["AY", "SH"]
    assert not len(spoken.words)


def test_other_languages_keep_their_own_signs(sound: Audio) -> None:
    spoken = spoken_as_given(sound, [tier("phones", (0.0, 0.5, "yː"), (0.5, 1.0, "t"))], language="fi")
    assert [phone.label for phone in spoken.phones] == ["UW", "T"]
    assert [phone.label for phone in spoken.spelled_phones] == ["yː", "t"]
    assert spoken.shapes[0] == ("front_round",)


def test_tiers_are_chosen_by_name(sound: Audio) -> None:
    phones = tier("hand", (0.0, 1.0, "AA"))
    other = tier("phones", (0.0, 1.0, "M"))
    spoken = spoken_as_given(sound, [WORDS, other, phones], names=("words", "hand"))
    assert [phone.label for phone in spoken.phones] == ["AA"]


@pytest.mark.parametrize(
    ("tiers", "names", "said"),
    [
        ([tier("f0", (0, 1, "x"))], (), "--tiers WORDS,PHONES"),
        ([WORDS], ("wrds",), "did you mean 'words'"),
        ([tier("phones", (0.0, 0.5, "qqq"))], (), "'qqq' at 0.000 s"),
        ([tier("phones", (3.0, 3.5, "AA"))], (), "another recording"),
        ([tier("words")], (), "holds no word"),
        ([], (), "no tier"),
    ],
)
def test_what_cannot_be_taken_is_named(sound: Audio, tiers: list[Tier], names: tuple[str, ...], said: str) -> None:
    with pytest.raises(InputError, match=said):
        spoken_as_given(sound, tiers, names=names)


@pytest.mark.data
def test_phones_of_words_alone_are_aligned_inside_them(shared_data: Path) -> None:
    from mien.formats.sound_files import read_audio

    audio, _ = read_audio(shared_data / "grid-s1" / "audio" / "bbaf2n.flac")
    lines = [line.split() for line in (shared_data / "grid-s1" / "words" / "bbaf2n.align").read_text().splitlines()]
    words = tier("words", *((int(a) / 25_000 + 0.02, int(b) / 25_000 + 0.02, w) for a, b, w in lines if w != "sil"))
    spoken = spoken_as_given(audio, [words])
    assert spoken.words == words
    for word in words:
        inside = [p for p in spoken.phones if p.start > word.start - 1e-6 and p.end < word.end + 1e-6]
        assert inside
        assert abs(sum(p.duration for p in inside) - word.duration) < 0.02
    assert spoken.phones.intervals[-1].end == pytest.approx(audio.duration)
