"""Takes of a corpus as motion of the speaker's own face."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mien.cli.main import main
from mien.core.errors import InputError
from mien.corpus.capturing import capture_corpus, people_of
from mien.corpus.importing import import_corpus
from mien.corpus.recordings import Corpus
from tests.corpus import recordings as made


@pytest.fixture(scope="module")
def corpus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("captured")
    for seed, name in enumerate(("a", "b")):
        made.write_npz(folder / "in", name, made.moving(seed))
        made.write_speech(folder / "in", name)
    import_corpus(folder / "in", folder / "out", workers=0)
    return folder / "out"


def test_an_import_ends_with_channels_of_every_take(corpus: Path) -> None:
    found = Corpus(corpus)
    for name in found.names:
        take = found.take(name)
        assert take.channels is not None
        assert take.captured
        assert len(take.channels) == len(take.markers)
        jaw = take.channels.channel("jawOpen") - take.channels.channel("mouthClose")
        assert np.corrcoef(jaw, made.opening())[0, 1] > 0.9
    assert people_of(found)[""].layout == "mpeg4-32"
    assert people_of(found)[""].source == "optical"


def test_what_was_captured_by_this_solver_is_left_alone(corpus: Path) -> None:
    before = {p.name: p.read_bytes() for p in (corpus / "channels").iterdir()}
    report = capture_corpus(Corpus(corpus), workers=0)
    assert (report.captured, report.kept) == ((), ("a", "b"))
    assert {p.name: p.read_bytes() for p in (corpus / "channels").iterdir()} == before


def test_an_old_corpus_is_upgraded_by_one_command(corpus: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kept = (corpus / "channels" / "a.npz").read_bytes()
    (corpus / "people.npz").unlink()
    for path in (corpus / "channels").iterdir():
        path.unlink()
    assert Corpus(corpus).take("a").channels is None
    assert main(["corpus", "upgrade", str(corpus), "--workers", "0"]) == 0
    assert "2 captured" in capsys.readouterr().out
    assert (corpus / "channels" / "a.npz").read_bytes() == kept


def test_captured_channels_do_not_become_recorded_ones(corpus: Path, tmp_path: Path) -> None:
    other = Corpus.create(tmp_path / "other", {"layout": "mpeg4-32"})
    other.add(Corpus(corpus).take("a"))
    assert not other.has_recorded_channels("a")


def test_recordings_of_channels_keep_their_own(tmp_path: Path) -> None:
    made.write_livelink(tmp_path / "in", "x")
    made.write_speech(tmp_path / "in", "x")
    found = import_corpus(tmp_path / "in", tmp_path / "out", workers=0).corpus
    take = found.take("x")
    assert take.channels is not None
    assert not take.captured
    assert take.channels.channel("jawOpen") == pytest.approx(made.opening() / 20.0, abs=1e-4)
    assert capture_corpus(found, workers=0).recorded == ("x",)


def test_damaged_files_are_one_line(corpus: Path, tmp_path: Path) -> None:
    (corpus / "channels" / "b.npz").write_bytes(b"nothing")
    with pytest.raises(InputError, match="run 'mien corpus upgrade'"):
        Corpus(corpus).take("b")
    assert capture_corpus(Corpus(corpus), workers=0).captured == ("b",)
    (corpus / "people.npz").write_bytes(b"nothing")
    with pytest.raises(InputError, match=r"people.npz: damaged"):
        capture_corpus(Corpus(corpus), workers=0)


def test_another_solver_captures_again(corpus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (corpus / "people.npz").unlink(missing_ok=True)
    capture_corpus(Corpus(corpus), workers=0)
    assert capture_corpus(Corpus(corpus), workers=0).captured == ()
    monkeypatch.setattr("mien.corpus.capturing._solver", lambda: "another")
    assert capture_corpus(Corpus(corpus), workers=0).captured == ("a", "b")
