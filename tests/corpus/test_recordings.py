from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.corpus.recordings import Corpus, digest_of, identity_of
from mien.corpus.take import Take
from mien.formats.textgrid import write_textgrid
from tests.utterances import utterance


def take(name: str = "one", seed: int = 1) -> Take:
    speech = utterance(("SIL", 0.2), ("M", 0.1), ("AA", 0.2), ("SIL", 0.2))
    random = np.random.default_rng(seed)
    positions = random.normal(0, 30, (18, 4, 3)).astype(np.float32)
    positions[3, 2] = np.nan
    return Take(
        name=name,
        audio=speech.audio,
        markers=MarkerTrack(("a", "b", "c", "d"), positions, FrameRate.of(25)),
        text="ma “quoted” – dash",
        words=speech.words,
        phones=speech.phones,
        layout="tiny",
        head=np.tile(np.eye(4), (18, 1, 1)),
        emotion="happy",
        sentence="ma",
        speaker="s1",
        source={"file": "a.c3d"},
    )


def test_a_take_comes_back_as_it_went_in(tmp_path: Path) -> None:
    corpus = Corpus.create(tmp_path / "corpus", {"layout": "tiny"})
    corpus.add(take())
    back = Corpus(tmp_path / "corpus").take("one")
    there = take()
    assert back.audio == there.audio
    assert back.markers == there.markers
    assert back.phones == there.phones
    assert back.words == there.words
    assert back.head is not None
    assert np.array_equal(back.head, np.tile(np.eye(4), (18, 1, 1)))
    for field in ("name", "text", "layout", "emotion", "sentence", "speaker", "source"):
        assert getattr(back, field) == getattr(there, field)


def test_the_identity_follows_the_content_and_not_the_name(tmp_path: Path) -> None:
    corpus = Corpus.create(tmp_path / "corpus", {"layout": "tiny"})
    for name, seed in (("one", 1), ("same", 1), ("other", 2)):
        corpus.add(take(name, seed))
    assert corpus.identity("one") == corpus.identity("same") != corpus.identity("other")


def test_the_manifest_is_plain_json_lines_in_order(tmp_path: Path) -> None:
    corpus = Corpus.create(tmp_path / "corpus", {"layout": "tiny"})
    corpus.add(take("b"))
    corpus.add(take("a", 2))
    lines = (tmp_path / "corpus" / "manifest.jsonl").read_text(encoding="utf-8").splitlines()
    assert [json.loads(line)["name"] for line in lines] == ["a", "b"]
    assert corpus.names == ("a", "b")
    assert [t.name for t in corpus] == ["a", "b"]


def test_what_is_no_corpus_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="mien corpus import"):
        Corpus(tmp_path)
    (tmp_path / "corpus.json").write_text('{"format": "mien-corpus", "version": 99}')
    with pytest.raises(InputError, match="version 1"):
        Corpus(tmp_path)


def test_a_damaged_take_is_named(tmp_path: Path) -> None:
    corpus = Corpus.create(tmp_path / "corpus", {"layout": "tiny"})
    corpus.add(take())
    motion = tmp_path / "corpus" / "motion" / "one.npz"
    motion.write_bytes(motion.read_bytes()[:100])
    with pytest.raises(InputError, match=r"one\.npz: missing or damaged"):
        corpus.take("one")
    with pytest.raises(InputError, match="no take 'two'"):
        corpus.take("two")


@pytest.mark.parametrize("name", ["", "../x", "a b", ".hidden", "a/b"])
def test_a_name_that_cannot_be_a_file_is_refused(name: str) -> None:
    with pytest.raises(InputError, match="a take's name"):
        take(name)


def test_a_recording_with_sound_is_known_however_its_motion_was_treated() -> None:
    one, other = (
        replace(take(seed=seed), audio=Audio(np.random.default_rng(7).uniform(-0.5, 0.5, 4000), 16000))
        for seed in (1, 2)
    )
    assert identity_of(one) == identity_of(other)
    assert digest_of(one) != digest_of(other)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"\xb8\x00\xff", "damaged or not readable"),
        (b"not json\n", "line 1: expected one take as JSON"),
        (b"5\n", "line 1: expected one take as JSON"),
        (b'{"name": "one"}\n', "line 1: expected one take, it lacks text"),
    ],
)
def test_a_damaged_manifest_is_one_line(tmp_path: Path, content: bytes, words: str) -> None:
    Corpus.create(tmp_path / "corpus", {"layout": "tiny"})
    (tmp_path / "corpus" / "manifest.jsonl").write_bytes(content)
    with pytest.raises(InputError, match=words) as caught:
        Corpus(tmp_path / "corpus")
    assert "\n" not in str(caught.value)


def test_a_textgrid_without_its_tiers_is_named(tmp_path: Path) -> None:
    corpus = Corpus.create(tmp_path / "corpus", {"layout": "tiny"})
    corpus.add(take())
    write_textgrid((), 1.0, tmp_path / "corpus" / "textgrid" / "one.TextGrid")
    with pytest.raises(InputError, match=r"one\.TextGrid: expected the tiers words and phones"):
        corpus.take("one")


def test_a_trackers_own_weights_in_an_older_grid_corpus_do_not_count_as_recorded(tmp_path: Path) -> None:
    one = take()
    weights = ChannelTrack(("jawOpen",), np.full((len(one.markers), 1), 0.5), one.markers.rate)
    for recipe, counts in (("grid", False), ("livelink", True)):
        corpus = Corpus.create(tmp_path / recipe, {"layout": "mpeg4-32", "recipe": recipe})
        corpus.add(replace(one, channels=weights))
        assert Corpus(tmp_path / recipe).has_recorded_channels("one") is counts
        assert (Corpus(tmp_path / recipe).take("one").channels is not None) is counts
