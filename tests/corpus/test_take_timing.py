"""Words and phones of takes in other languages than English."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mien.cli import main
from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.corpus.importing import import_corpus
from mien.corpus.recipes import Recipe
from mien.corpus.take_timing import timed
from mien.corpus.transcripts import Transcript
from mien.formats.sound_files import read_audio
from mien.speech.aligned_phone import AlignedPhone
from tests.corpus import recordings as made

FINNISH = Recipe("mine", "", "npz", language="fi")


def evenly(audio: Audio, words: list[str], choices: list[list[tuple[str, ...]]]) -> list[AlignedPhone]:
    """A stand-in for the aligner: a pause, then every phone for a tenth of a second."""
    found, now = [AlignedPhone("SIL", 0.0, 0.2, -1, -0.2)], 0.2
    for number, ways in enumerate(choices):
        for label in ways[0]:
            found.append(AlignedPhone(label, now, now + 0.1, number, -0.5))
            now += 0.1
    return [*found, AlignedPhone("SIL", now, audio.duration, -1, -0.2)]


def noise(seconds: float) -> Audio:
    return Audio(0.1 * np.random.default_rng(0).standard_normal(round(16_000 * seconds)), 16_000)


def test_finnish_is_read_by_its_letters_and_kept_in_english_phones(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mien.corpus.take_timing.align_words", evenly)
    found = timed(noise(3.0), Transcript("hyvää yötä"), FINNISH, "a")
    assert [word.label for word in found.words] == ["hyvää", "yötä"]
    said = [phone.label for phone in found.phones if phone.label != "SIL"]
    assert said[0] == "HH"
    assert all(label.isalpha() and label.isupper() for label in said)
    assert found.confidence == pytest.approx(-0.5)
    own = replace(FINNISH, pronunciations={"hyvää": ["HH Y"]})
    assert "for English, not Finnish" in timed(noise(3.0), Transcript("hyvää"), own, "a").notes[-1].message


def test_a_language_that_is_not_known_is_told_before_anything_is_read(tmp_path: Path) -> None:
    made.write_npz(tmp_path / "in", "a", made.moving(0))
    made.write_speech(tmp_path / "in", "a")
    with pytest.raises(InputError, match="unknown language 'fin': did you mean 'fi'"):
        import_corpus(tmp_path / "in", tmp_path / "out", language="fin", workers=0)
    assert main(["corpus", "import", str(tmp_path / "in"), "-o", str(tmp_path / "out"), "--language", "xx"]) == 2


@pytest.mark.data
def test_german_speech_of_a_person(shared_data: Path) -> None:
    pytest.importorskip("espeakng_loader")
    audio = read_audio(shared_data / "emodb" / "audio" / "03a02Nc.flac")[0]
    found = timed(audio, Transcript("Das will sie am Mittwoch abgeben."), replace(FINNISH, language="de"), "a")
    assert [word.label.lower() for word in found.words] == ["das", "will", "sie", "am", "mittwoch", "abgeben"]
    assert found.confidence is not None
    assert found.confidence > -3
