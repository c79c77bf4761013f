"""From folders of recordings to a corpus. Phones come from TextGrids here, so that nothing has to be aligned."""

from __future__ import annotations

import asyncio
import json
import shutil
import subprocess
import sys
import time
import types
from pathlib import Path

import numpy as np
import pytest

from mien.core.errors import InputError, OutputError
from mien.core.files import held_alone
from mien.corpus.importing import import_corpus
from mien.corpus.recipes import Recipe, load_recipe
from mien.corpus.recordings import Corpus
from mien.corpus.workers import _collected
from tests.corpus import recordings as made


def lip_opening(corpus: Corpus, name: str) -> made.Floats:
    markers = corpus.take(name).markers
    upper, lower = (markers.positions[:, markers.names.index(m)] for m in ("8.1", "8.2"))
    return np.asarray(np.linalg.norm(upper - lower, axis=1))


def session(folder: Path, names: tuple[str, ...] = ("a", "b", "c")) -> Path:
    """Takes of one speaker whose head moves differently in each."""
    for seed, name in enumerate(names):
        made.write_npz(folder, name, made.moving(seed))
        made.write_speech(folder, name)
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.suffix in (".npz", ".flac", ".TextGrid", ".jsonl")
    }


@pytest.fixture(scope="module")
def imported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with recordings in ``in`` and the corpus of them in ``out``."""
    folder = tmp_path_factory.mktemp("imported")
    import_corpus(session(folder / "in", ("a", "b")), folder / "out", workers=0)
    return folder


@pytest.fixture
def pair(imported: Path, tmp_path: Path) -> Path:
    """A copy of it of one's own."""
    shutil.copytree(imported, tmp_path / "pair")
    return tmp_path / "pair"


@pytest.mark.parametrize("kind", ["c3d", "csv", "npz", "analog"])
def test_recordings_become_takes_without_the_motion_of_the_head(tmp_path: Path, kind: str) -> None:
    source = tmp_path / "in"
    for seed, name in enumerate(("a", "b")):
        made.write_speech(source, name)
        if kind == "csv":
            made.write_csv(source, name, made.moving(seed))
        elif kind == "npz":
            made.write_npz(source, name, made.moving(seed))
        elif kind == "c3d":
            made.write_c3d(source, name, made.moving(seed))
        else:
            made.write_c3d(source, name, made.moving(seed), analog=made.sound().resampled(12_000))
            (source / f"{name}.wav").unlink()
    report = import_corpus(source, tmp_path / "out", workers=0)
    assert (report.imported, report.failed) == (("a", "b"), ())
    corpus = Corpus(tmp_path / "out")
    assert corpus.about["layout"] == "mpeg4-32"
    for name in ("a", "b"):
        take = corpus.take(name)
        assert np.abs(take.markers.positions - made.still()).max() < 1.5  # mm, in the axes of the default face
        rest = lip_opening(corpus, name)[0]
        assert np.abs(lip_opening(corpus, name) - rest - made.opening()).max() < 0.3
        assert (take.text, take.speaker, take.emotion) == ("bin ma", "", "neutral")
        assert [i.label for i in take.phones] == ["SIL", "B", "IH", "N", "M", "AA", "SIL"]
        assert take.head is not None
        nose = take.markers.names.index("9.3")
        back = (take.head @ np.append(take.markers.positions, np.ones((120, 32, 1)), 2).transpose(0, 2, 1))[:, :3, nose]
        assert np.abs(back - made.moving(0 if name == "a" else 1)[:, nose]).max() < 0.5


def test_the_same_bits_whatever_the_number_of_workers(tmp_path: Path) -> None:
    session(tmp_path / "in")
    for workers in (0, 2):
        import_corpus(tmp_path / "in", tmp_path / f"out{workers}", workers=workers)
    assert contents(tmp_path / "out0") == contents(tmp_path / "out2")


def test_the_same_on_a_dask_cluster(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    session(tmp_path / "in", ("a", "b"))
    made.write_npz(tmp_path / "in", "broken", made.moving() * np.nan)
    made.write_speech(tmp_path / "in", "broken")
    import_corpus(tmp_path / "in", tmp_path / "here", workers=0)
    with distributed.LocalCluster(n_workers=1, processes=False, dashboard_address=None) as cluster:
        report = import_corpus(tmp_path / "in", tmp_path / "there", workers=0, cluster=cluster.scheduler_address)
    assert report.imported == ("a", "b")
    assert [failure.name for failure in report.failed] == ["broken"]
    assert contents(tmp_path / "here") == contents(tmp_path / "there")


def test_no_cluster_at_the_address_is_one_line(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    session(tmp_path / "in", ("a",))
    with pytest.raises(InputError, match="no Dask scheduler answers at 'nonsense://x'"):
        import_corpus(tmp_path / "in", tmp_path / "out", workers=0, cluster="nonsense://x")


def test_a_stopped_run_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source, out = session(tmp_path / "in"), tmp_path / "out"
    seen: list[tuple[int, int]] = []

    def stop_after_two(done: int, total: int) -> None:
        seen.append((done, total))
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        import_corpus(source, out, workers=0, progress=stop_after_two)
    assert seen == [(1, 3), (2, 3)]
    journal = out / "importing.jsonl"
    assert len(journal.read_text().splitlines()) == 2
    journal.write_text(journal.read_text() + '{"name": "c", "text": "cut off in the mid')
    report = import_corpus(source, out, workers=0)
    assert (report.kept, report.imported) == (("a", "b"), ("c",))
    assert not journal.exists()
    import_corpus(source, tmp_path / "at_once", workers=0)
    assert contents(out) == contents(tmp_path / "at_once")
    monkeypatch.setattr("mien.corpus.importing.prepare_and_write", None)  # nothing is made again
    assert import_corpus(source, out, workers=0).kept == ("a", "b", "c")


def test_a_killed_run_leaves_no_process_and_goes_on(tmp_path: Path) -> None:
    names = tuple("abcde")
    source, out = session(tmp_path / "in", names), tmp_path / "out"
    command = [sys.executable, "-m", "mien", "corpus", "import", str(source), "-o", str(out), "--workers", "1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as run:
        journal = out / "importing.jsonl"
        while run.poll() is None and not (journal.exists() and journal.read_text(encoding="utf-8").count("\n") >= 2):
            time.sleep(0.01)
        run.kill()
        run.communicate()  # ends only when no worker holds the pipes any more
    report = import_corpus(source, out, workers=0)
    assert len(report.kept) >= 2
    assert sorted(report.kept + report.imported) == list(names)
    import_corpus(source, tmp_path / "at_once", workers=0)
    assert contents(out) == contents(tmp_path / "at_once")


def test_a_take_is_made_again_when_its_files_or_settings_change(tmp_path: Path) -> None:
    source, out = session(tmp_path / "in"), tmp_path / "out"
    import_corpus(source, out, workers=0)
    (source / "b.TextGrid").write_text(
        (source / "b.TextGrid").read_text(encoding="utf-8").replace('"bin"', '"been"'), encoding="utf-8"
    )
    (out / "audio" / "c.flac").unlink()
    report = import_corpus(source, out, workers=0)
    assert (report.kept, report.imported) == (("a",), ("b", "c"))
    assert Corpus(out).take("b").text == "been ma"
    assert import_corpus(source, out, workers=0, emotion="happy").kept == ()


def test_one_broken_recording_never_stops_the_others(tmp_path: Path) -> None:
    source = session(tmp_path / "in", ("good",))
    made.write_npz(source, "wordless", made.moving())
    made.sound().write(source / "wordless.wav")
    made.write_npz(source, "silent", made.moving())
    (source / "silent.txt").write_text("bin ma")
    made.write_npz(source, "short", made.moving()[:30])
    made.write_speech(source, "short")
    made.write_npz(source, "blind", made.moving() * np.nan)
    made.write_speech(source, "blind")
    made.write_npz(source, "huge", made.moving() * 7.0)
    made.write_speech(source, "huge")
    report = import_corpus(source, tmp_path / "out", workers=0)
    assert report.imported == ("good",)
    reasons = {failure.name: failure.reason for failure in report.failed}
    assert set(reasons) == {"wordless", "silent", "short", "blind", "huge"}
    assert "no transcript: expected wordless.txt" in reasons["wordless"]
    assert "no sound in it or beside it" in reasons["silent"]
    assert "0.50 s" in reasons["short"]
    assert "2.00 s" in reasons["short"]
    assert "no marker is seen in any frame" in reasons["blind"]
    assert "units large" in reasons["huge"]
    for name, reason in reasons.items():
        assert f"{name}.npz" in reason
        assert "\n" not in reason
    refused = (tmp_path / "out" / "refused.jsonl").read_text().splitlines()
    assert [json.loads(line)["name"] for line in refused] == sorted(reasons)


def test_a_process_that_dies_costs_one_take() -> None:
    from mien.corpus.workers import each
    from tests.corpus import crashing

    results = dict(each(crashing.double_or_die, [1, 2, 13, 4, 5, 6, 7, 8, 9, 10], workers=2))
    assert {job: r for job, r in results.items() if job != 13} == {j: 2 * j for j in (1, 2, 4, 5, 6, 7, 8, 9, 10)}
    assert "ended without a word" in str(results[13])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda p: p / 1000.0, "metres to millimetres"),
        (lambda p: p[:, :, [0, 2, 1]] * [1, -1, 1], "axes"),
        (lambda p: p * [-1.0, 1.0, 1.0], "axes"),
    ],
)
def test_wrong_units_and_axes_are_put_right_and_said(tmp_path: Path, change: object, said: str) -> None:
    positions = made.still() + np.array([3.0, -4.0, 5.0])
    made.write_npz(tmp_path / "in", "a", change(positions))  # type: ignore[operator]
    made.write_speech(tmp_path / "in", "a")
    import_corpus(tmp_path / "in", tmp_path / "out", workers=0)
    take = Corpus(tmp_path / "out").take("a")
    assert np.abs(take.markers.positions - made.still()).max() < 1.5
    assert said in take.source["notes"]


def test_gaps_are_filled_and_lost_markers_told(tmp_path: Path) -> None:
    positions = made.moving()
    positions[40:43, 5] = np.nan
    positions[:, made.LAYOUT.index(["5.3"])] = np.nan
    made.write_npz(tmp_path / "in", "a", positions)
    made.write_speech(tmp_path / "in", "a")
    import_corpus(tmp_path / "in", tmp_path / "out", workers=0)
    take = Corpus(tmp_path / "out").take("a")
    assert (take.source["filled"], take.source["dropped"]) == ("3", "5.3")
    missing = np.isnan(take.markers.positions).any(axis=2)
    assert missing.all(axis=0).tolist() == [name == "5.3" for name in take.markers.names]
    assert int(missing.sum()) == 120
    assert np.abs(take.markers.positions[40:43, 5] - made.still()[40:43, 5]).max() < 1.5


def test_names_emotions_and_sentences_by_table_and_pattern(tmp_path: Path) -> None:
    source = tmp_path / "in"
    for name in ("s1-H-one", "s2-N-one", "odd"):
        made.write_npz(source, name, made.moving())
        made.write_speech(source, name)
    table = tmp_path / "t.tsv"
    table.write_text("name\temotion\tspeaker\ns2-N-one\tA\t\nnone such\tA\t\n")
    recipe = Recipe(**{**load_recipe("tracks").__dict__, "emotions": {"H": "happy", "N": "neutral", "A": "angry"}})
    report = import_corpus(
        source,
        tmp_path / "out",
        recipe=recipe,
        table=table,
        name_pattern="(?P<speaker>s.)-(?P<emotion>.)-(?P<sentence>.+)",
        workers=0,
    )
    first, second = Corpus(tmp_path / "out")
    assert (first.name, first.emotion, first.sentence, first.speaker) == ("s1-H-one", "happy", "one", "s1")
    assert (second.name, second.emotion, second.sentence, second.speaker) == ("s2-N-one", "angry", "one", "s2")
    assert "odd: does not fit the name pattern" in report.failed[0].reason
    assert "1 lines of the table name no recording, first 'none such'" in report.notes[0].message


def test_names_that_repeat_get_their_folder_in_front(tmp_path: Path) -> None:
    for folder in ("s1", "s2"):
        session(tmp_path / "in" / folder, ("a", "b c"))
    report = import_corpus(tmp_path / "in", tmp_path / "out", workers=0)
    assert report.imported == ("s1-a", "s1-b_c", "s2-a", "s2-b_c")
    assert any("names repeat" in note.message for note in report.notes)
    made.write_npz(tmp_path / "in" / "s1", "b_c", made.moving())
    made.write_npz(tmp_path / "in" / "s2" / "s1", "b_c", made.moving())
    report = import_corpus(tmp_path / "in", tmp_path / "again", workers=0)
    assert any("is that of" in failure.reason and "rename one" in failure.reason for failure in report.failed)


def test_live_link_becomes_takes(tmp_path: Path) -> None:
    made.write_livelink(tmp_path / "in", "a")
    made.write_speech(tmp_path / "in", "a")
    report = import_corpus(tmp_path / "in", tmp_path / "out", workers=0)
    take = report.corpus.take("a")
    assert take.layout == "face-102"
    assert take.channels is not None
    assert np.abs(take.channels.channel("jawOpen") - made.opening() / 20).max() < 1e-6
    assert np.corrcoef(lip_opening(report.corpus, "a"), made.opening())[0, 1] > 0.99


def test_grid_arrays_are_laid_on_the_first_frame(tmp_path: Path) -> None:
    source = made.write_grid(tmp_path / "in", ("bbaf2n", "bbaf3s"))
    for name in ("bbaf2n", "bbaf3s"):
        made.write_speech(source / "audio", name)
    report = import_corpus(source, tmp_path / "out", workers=0)
    assert report.corpus.about["licence"] == "CC BY 4.0"
    take = report.corpus.take("bbaf2n")
    right, left = (take.markers.positions[0, take.markers.names.index(m)] for m in ("3.12", "3.7"))
    assert np.linalg.norm(left - right) == pytest.approx(90.0, abs=1e-4)
    assert left[0] > 0 > right[0]
    assert take.speaker == "s1"


def test_a_corpus_of_another_recipe_is_not_mixed_up(pair: Path) -> None:
    shutil.rmtree(pair / "in")
    made.write_c3d(pair / "in", "b")
    with pytest.raises(InputError, match="holds takes of recipe 'tracks', not 'c3d'"):
        import_corpus(pair / "in", pair / "out", workers=0)


def test_an_empty_source_is_refused(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    with pytest.raises(InputError, match="no recording found that mien knows"):
        import_corpus(tmp_path / "in", tmp_path / "out")
    with pytest.raises(InputError, match="expected C3D files"):
        import_corpus(tmp_path / "in", tmp_path / "out", recipe="c3d")
    with pytest.raises(InputError, match="unknown recipe 'c4d': did you mean 'c3d'"):
        import_corpus(tmp_path / "in", tmp_path / "out", recipe="c4d")


def test_jobs_say_what_they_are(imported: Path) -> None:
    entry = Corpus(imported / "out").entries["a"]
    assert entry["source"]["file"] == "a.npz"
    assert str(imported) not in json.dumps(entry)
    assert len(entry["source"]["fingerprint"]) == 16


@pytest.mark.parametrize("hurt", ["empty", "cut", "flipped", "other", "gone"])
@pytest.mark.parametrize("part", [0, 1, 2])
def test_a_take_that_was_hurt_is_made_again(pair: Path, part: int, hurt: str) -> None:
    corpus = Corpus(pair / "out")
    before, path, twin = contents(pair / "out"), corpus.files_of("a")[part], corpus.files_of("b")[part]
    content = bytearray(path.read_bytes())
    if hurt == "gone":
        path.unlink()
    elif hurt == "other":
        path.write_bytes(twin.read_bytes())
    else:
        content[len(content) // 2] ^= 0xFF
        path.write_bytes(b"" if hurt == "empty" else content[: len(content) // 2] if hurt == "cut" else content)
    report = import_corpus(pair / "in", pair / "out", workers=0)
    if part != 1 and hurt == "other":
        return  # the sounds are the same here, and a TextGrid that reads is a person's to correct
    if part == 2 and hurt == "flipped":
        return
    assert (report.imported, report.kept) == (("a",), ("b",))
    assert "1 takes were changed, damaged or gone, and are made again: a" in [note.message for note in report.notes]
    assert contents(pair / "out") == before


def test_a_second_import_into_the_same_corpus_is_refused(pair: Path) -> None:
    out = pair / "out"
    with held_alone(out / ".importing", "held"), pytest.raises(OutputError, match="another import"):
        import_corpus(pair / "in", out, workers=0)
    import_corpus(pair / "in", out, workers=0)
    assert not (out / ".importing").exists()


def test_a_scheduler_that_is_lost_is_one_line() -> None:
    class Future:
        def __init__(self, key: int) -> None:
            self.key = key

        def exception(self) -> None:
            if self.key == 1:
                raise asyncio.CancelledError

        def result(self) -> int:
            return self.key

        def release(self) -> None:
            pass

    class Client:
        def __enter__(self) -> Client:
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def map(self, function: object, jobs: list, **_: object) -> list[Future]:
            return [Future(number) for number in range(len(jobs))]

    dask = types.SimpleNamespace(as_completed=iter)
    with pytest.raises(InputError, match=r"was lost after 1 of 3 jobs .*run the same command again"):
        list(_collected(dask, Client(), str, ["a", "b", "c"], "tcp://x:1"))
