from __future__ import annotations

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from mien.core.audio import Audio
from mien.core.errors import AlignmentError, InputError, MissingPartError
from mien.core.utterance import PAUSE
from mien.formats.sound_files import read_audio
from mien.speech import decoder
from mien.speech import recognise as recognising
from mien.speech.recognise import Recogniser, recognise
from mien.text.phones import phone_table


@pytest.mark.data
@pytest.mark.parametrize("recogniser", ["hama", "pocketsphinx"])
def test_phones_are_found_without_a_text(shared_data: Path, recogniser: Recogniser) -> None:
    if recogniser == "hama":
        pytest.importorskip("hama")
    path = shared_data / "timit-sample" / "dr1-mcpm0" / "sa1.flac"
    audio, _ = read_audio(path)
    utterance = recognise(audio, recogniser=recogniser)
    assert utterance.timing == "recognised"
    assert [note.kind for note in utterance.notes] == ["note"]
    assert "approximate" in utterance.notes[0].message
    phones = utterance.phones.intervals
    assert phones[0].start == 0.0
    assert phones[-1].end == audio.duration
    assert {phone.label for phone in phones} <= set(phone_table()) | {PAUSE}
    assert {"dark", "suit", "water"} <= set(utterance.text.split())


@pytest.mark.data
def test_a_long_sound_is_heard_in_pieces(shared_data: Path) -> None:
    names = ("sa1", "sa2", "sx204", "sx24", "sx294", "sx384", "sx114")
    audio = Audio.join([read_audio(shared_data / "timit-sample" / "dr1-mcpm0" / f"{n}.flac")[0] for n in names])
    utterance = recognise(audio)
    assert audio.duration > 15.0
    assert utterance.phones.intervals[-1].end == audio.duration
    assert len(utterance.words) > 30
    assert {"dark", "suit"} <= set(utterance.text.split())


def test_silence_has_no_speech() -> None:
    utterance = recognise(Audio.silence(1.5, 16_000))
    assert utterance.timing == "none"
    assert utterance.text == ""
    assert [(i.start, i.end, i.label) for i in utterance.phones] == [(0.0, 1.5, PAUSE)]
    assert [note.kind for note in utterance.notes] == ["warning"]


def test_pieces_cover_a_long_sound_and_are_cut_where_it_is_quiet() -> None:
    samples = np.full(40 * 16_000, 1000, dtype=np.int16)
    samples[12 * 16_000 : 13 * 16_000] = 0
    pieces = recognising._quiet_cuts(samples)
    assert pieces[0].first == 0
    assert pieces[-1].last == len(samples)
    assert all(a.last == b.first for a, b in pairwise(pieces))
    assert 12.0 < pieces[0].last / 16_000 < 13.0


def test_every_ipa_sign_leads_to_known_phones() -> None:
    assert {phone for phones in recognising._ipa_table().values() for phone in phones} == set(phone_table())


def test_what_cannot_be_done_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    sound = Audio(np.full(8000, 0.1), 16_000)
    with pytest.raises(InputError, match="English"):
        recognise(sound, language="fi")
    with pytest.raises(InputError, match="'hama' or 'pocketsphinx'"):
        recognise(sound, recogniser="kaldi")  # type: ignore[arg-type]
    monkeypatch.setattr(recognising, "find_spec", lambda name: None)
    assert recognising.recogniser_at_hand() == "pocketsphinx"
    with pytest.raises(MissingPartError, match="pip install hama"):
        recognise(sound, recogniser="hama")


@pytest.mark.parametrize(
    ("program", "said"),
    [
        ("import os; os.kill(os.getpid(), 11)", "crashed"),
        ("raise SystemExit('broken')", "broken"),
        ("print('nothing')", "no answer"),
    ],
)
def test_a_crash_in_the_decoder_is_an_error_and_not_the_end(
    program: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(decoder, "_COMMAND", [sys.executable, "-c", program])
    noise = Audio(np.random.default_rng(1).normal(0, 0.1, 16_000), 16_000)
    with pytest.raises(AlignmentError, match=said):
        recognise(noise, recogniser="pocketsphinx")


def test_a_decoder_that_hangs_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(decoder, "_COMMAND", [sys.executable, "-c", "import time; time.sleep(600)"])
    monkeypatch.setattr(decoder, "_SECONDS_TO_START", 0.2)
    monkeypatch.setattr(decoder, "_SECONDS_PER_SECOND", 0.0)
    with pytest.raises(AlignmentError, match="longer than"):
        recognise(Audio(np.random.default_rng(1).normal(0, 0.1, 16_000), 16_000), recogniser="pocketsphinx")
