from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mien.core.audio import Audio
from mien.core.errors import OutputError
from mien.core.timeline import Interval, Tier
from mien.core.tracks import MarkerTrack
from mien.corpus.checking import check_corpus
from mien.corpus.importing import import_corpus
from mien.corpus.recordings import Corpus
from mien.corpus.take import Take
from mien.corpus.take_picture import draw_take
from tests.corpus import recordings as made


@pytest.fixture(scope="module")
def imported(tmp_path_factory: pytest.TempPathFactory) -> Corpus:
    folder = tmp_path_factory.mktemp("corpus")
    for seed, name in enumerate(("a", "b")):
        made.write_npz(folder / "in", name, made.moving(seed))
        made.write_speech(folder / "in", name)
    made.write_npz(folder / "in", "mute", made.moving())
    return import_corpus(folder / "in", folder / "out", workers=0, emotion="happy", speaker="anna").corpus


def test_the_table_counts_what_is_there(imported: Corpus) -> None:
    check = check_corpus(imported)
    rows = dict(check.rows())
    assert rows["sound"] == "0.1 minutes, 0.0 of them speech"
    assert rows["takes"] == "2 with 4 words and 10 phones"
    assert rows["phones"].startswith("5 of 39, none of AE")
    assert rows["diphones"] == "6 kinds, 0 of them five times or more"
    assert rows["triphones"] == "5 kinds, 0 of them five times or more"
    assert rows["gaps filled"] == "0 of 7680 positions (0.000%)"
    assert rows["emotions"] == "happy 2"
    assert rows["speakers"] == "anna 2"
    assert rows["alignment score"] == "nothing was aligned"


def test_what_was_refused_is_among_the_faults(imported: Corpus) -> None:
    check = check_corpus(imported)
    assert [(fault.name, fault.file, fault.sure) for fault in check.faults] == [("mute", "mute.npz", True)]
    assert "no transcript: expected mute.txt" in str(check)


def test_faults_name_file_and_frame(imported: Corpus, tmp_path: Path) -> None:
    corpus = Corpus.create(tmp_path / "bad", {"layout": "mpeg4-32"})
    take = imported.take("a")
    positions = take.markers.positions.copy()
    positions[40, 3] = np.nan
    positions[70, 5] += 60.0
    names, rate = take.markers.names, take.markers.rate
    corpus.add(replace(take, markers=MarkerTrack(names, positions, rate), source={"confidence": "-5.0"}))
    corpus.add(replace(take, name="twin"))
    corpus.add(replace(take, name="twin2", source={"warnings": "one | two"}))
    corpus.add(replace(take, name="long", markers=MarkerTrack(names, np.tile(take.markers.positions, (2, 1, 1)), rate)))
    corpus.add(replace(take, name="torn", text="torn"))
    (tmp_path / "bad" / "audio" / "torn.flac").unlink()
    said = [str(fault) for fault in check_corpus(Corpus(tmp_path / "bad")).faults]
    assert f"fault: motion/a.npz, frame 40: marker {names[3]} is missing (1 positions in all)" in said[0]
    assert f"fault: motion/a.npz, frame 70: marker {names[5]} jumps by 104 mm: a spike or a swap?" in said
    assert "fault: audio/a.flac: text and sound hardly fit (score -5.0): is this its text?" in said
    assert "fault: motion/long.npz: 4.00 s of motion, 2.00 s of sound" in said
    assert any(line.startswith("fault: motion/torn.npz: ") and "torn.flac: missing" in line for line in said)
    assert "fault: motion/twin2.npz: the same recording as twin; keep one" in said
    assert "doubt: audio/twin2.flac: two" in said
    assert len(said) == 8


def test_a_take_that_changed_on_disk_is_noticed(imported: Corpus, tmp_path: Path) -> None:
    corpus = Corpus.create(tmp_path / "c", {"layout": "mpeg4-32"})
    corpus.add(imported.take("a"))
    entry = corpus.entries["a"]
    entry["digest"] = "0" * 64
    assert any("changed since the import" in fault.message for fault in check_corpus(corpus).faults)


def test_the_picture_shows_sound_phones_and_motion(imported: Corpus, tmp_path: Path) -> None:
    take = imported.take("a")
    positions = take.markers.positions.copy()
    positions[:20, take.markers.names.index("8.1")] = np.nan
    draw_take(replace(take, markers=MarkerTrack(take.markers.names, positions, take.markers.rate)), tmp_path / "a.png")
    draw_take(take, tmp_path / "b.png")
    with Image.open(tmp_path / "a.png") as holed, Image.open(tmp_path / "b.png") as whole:
        assert whole.size == holed.size
        assert whole.width > 900
        plain, gap = np.asarray(whole.convert("RGB")).astype(int), np.asarray(holed.convert("RGB")).astype(int)
    blue = (np.abs(plain - [36, 99, 176]).sum(axis=2) < 30).sum(axis=0)
    blue_with_hole = (np.abs(gap - [36, 99, 176]).sum(axis=2) < 30).sum(axis=0)
    columns = slice(115, 240)  # of the first 20 frames
    assert blue[columns].sum() > 100
    assert blue_with_hole[columns].sum() < blue[columns].sum() / 4
    with pytest.raises(OutputError, match=r"is a \.png"):
        draw_take(take, tmp_path / "a.jpg")


def babble(name: str, seed: int, late: float) -> Take:
    """A take whose loudness is the opening of its lips, the motion ``late`` seconds behind."""
    random = np.random.default_rng(seed)
    knots = np.abs(random.normal(0, 6, 16))
    seconds = 4.0
    tone = np.arange(round(seconds * 16_000)) / 16_000
    loud = np.interp(tone, np.linspace(0, seconds, 16), knots)
    frames = np.arange(round(seconds * 60)) / 60 - late
    places = made.LAYOUT.places.copy()
    places[made.LAYOUT.index(["8.2"]), 1] = places[made.LAYOUT.index(["8.1"]), 1]
    positions = np.tile(places, (len(frames), 1, 1))
    positions[:, made.LAYOUT.index(["8.2"]), 1] -= np.interp(frames, np.linspace(0, seconds, 16), knots)[:, None]
    return Take(
        name=name,
        audio=Audio(loud / 40 * np.sin(2 * np.pi * 200 * tone), 16_000),
        markers=MarkerTrack(made.LAYOUT.markers, positions, made.RATE),
        text="a",
        words=Tier("words", ()),
        phones=Tier("phones", (Interval(0, seconds, "AA"),)),
        layout="mpeg4-32",
    )


@pytest.mark.parametrize(("late", "doubted"), [(0.12, True), (0.0, False)])
def test_motion_that_is_late_is_doubted(tmp_path: Path, late: float, doubted: bool) -> None:
    corpus = Corpus.create(tmp_path / "c", {"layout": "mpeg4-32"})
    for seed in range(6):
        corpus.add(babble(f"take{seed}", seed, late))
    check = check_corpus(corpus)
    assert check.lag is not None
    assert check.lag.seconds == pytest.approx(late, abs=0.015)
    assert any("did both start together?" in str(fault) for fault in check.faults) == doubted
