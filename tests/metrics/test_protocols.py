from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mien.core.channels import ALL
from mien.core.errors import InputError, OutputError
from mien.corpus.recordings import Corpus
from mien.metrics.baselines import Cosine
from mien.metrics.compared_models import contenders
from mien.metrics.evaluation import CAPTURED, RECORDING, REPETITIONS, Evaluation
from mien.metrics.fold_jobs import Away
from mien.metrics.plot import draw_trajectories, write_trajectories
from mien.metrics.protocols import evaluate_folds, evaluate_performer, recordings
from mien.metrics.results_report import markdown, put_section
from mien.metrics.splits import Fold, named_fold, words_fold
from mien.motion.mouth.hand_made_mouth import MouthMotion
from tests.metrics.synthetic import MOUTH, corpus, keyed_opening, spoken

QUICK = contenders(["mean pose", "cosine", "ridge"])


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Corpus:
    return corpus(tmp_path_factory.mktemp("corpus") / "c")


@pytest.fixture(scope="module")
def random_evaluation(made: Corpus) -> Evaluation:
    ready, _ = recordings(made)
    return evaluate_folds(ready, [named_fold([r.take for r in ready.values()], ["take03", "take07"])], QUICK)


def test_models_are_ranked_as_the_motion_was_made(random_evaluation: Evaluation) -> None:
    scores = random_evaluation.marker_scores
    assert list(scores) == [RECORDING, REPETITIONS, "mean pose", "cosine", "ridge"]
    assert scores["cosine"]["rms"].value < scores["ridge"]["rms"].value < scores["mean pose"]["rms"].value
    assert scores["cosine"]["opening_r"].value > 0.98
    assert (random_evaluation.takes, random_evaluation.pooled) == (2, False)


def test_every_row_is_scored_as_the_face_shows_it(random_evaluation: Evaluation) -> None:
    scores = random_evaluation.scores
    assert list(scores) == [RECORDING, CAPTURED, REPETITIONS, "mean pose", "cosine", "ridge"]
    assert scores[CAPTURED]["opening_r"].value > 0.98
    assert scores["cosine"]["opening_r"].value > 0.97
    assert scores["mean pose"]["opening_spread"].value == 0.0
    assert scores[RECORDING]["median_bilabial"].value < scores[RECORDING]["median_open"].value
    assert set(random_evaluation.offsets) == {*scores} - {RECORDING}


class Moved(Cosine):
    """A model whose markers are those of the corpus, moved: as if it came from a corpus imported apart."""

    markers_ = MOUTH

    def synthesise(self, phones, times):  # type: ignore[no-untyped-def]
        return super().synthesise(phones, times) + np.array([0.0, 4.4, 0.0])


class Jaw:
    """A mouth that performs in channels."""

    def perform(self, utterance, rate):  # type: ignore[no-untyped-def]
        times = rate.times(rate.frames_covering(utterance.duration))
        values = np.zeros((len(times), len(ALL)))
        values[:, ALL.index("jawOpen")] = keyed_opening(utterance.phones, times) / 40
        return MouthMotion(values, np.zeros(len(times)))


def test_a_performer_of_a_corpus_imported_apart_is_brought_to_its_reference(made: Corpus) -> None:
    model = Moved().fit([made.take(name) for name in made.names])
    evaluation = evaluate_performer("anna", {"jaw": Jaw()}, {"hers": model}, (), made)
    assert evaluation.marker_scores["hers"]["rms"].value < 0.5
    assert evaluation.offsets["hers, markers"][""][1] == pytest.approx(4.4, abs=0.05)
    assert evaluation.scores["jaw"]["opening_r"].value > 0.95
    assert evaluation.scores["hers"]["opening_r"].value > 0.95
    assert "hers, markers: the speaker +0.0 +4.4" in markdown(evaluation, "#").replace("-0.0", "+0.0")


def test_unseen_words_are_scored_inside_themselves_and_pooled(made: Corpus) -> None:
    ready, _ = recordings(made)
    fold = words_fold([r.take for r in ready.values()], ["tea"])
    evaluation = evaluate_folds(ready, [fold], QUICK)
    assert evaluation.pooled
    assert evaluation.frames == sum(int(ready[name].inside({"tea"}).sum()) for name in fold.test)


def test_models_learn_from_the_training_takes_alone(made: Corpus) -> None:
    met: list[str] = []

    class Spy(Cosine):
        def fit(self, takes):  # type: ignore[no-untyped-def]
            met.extend(take.name for take in takes)
            return super().fit(takes)

    ready, _ = recordings(made)
    fold = Fold(("take00", "take01"), ("take02",))
    evaluate_folds(ready, [fold], {"spy": Spy})
    assert met == ["take00", "take01"]


def test_the_same_seed_gives_the_same_evaluation(made: Corpus, random_evaluation: Evaluation) -> None:
    ready, _ = recordings(made)
    again = evaluate_folds(ready, random_evaluation.folds, QUICK)
    assert markdown(again, "#") == markdown(random_evaluation, "#")


def test_other_processes_learn_the_same(made: Corpus, random_evaluation: Evaluation) -> None:
    ready, _ = recordings(made)
    away = Away(str(made.folder), False, workers=1)
    again = evaluate_folds(ready, random_evaluation.folds, QUICK, away=away)
    assert markdown(again, "#") == markdown(random_evaluation, "#")


class Finished(Cosine):
    """A fitted model that gives its markers in another order than the corpus keeps them."""

    markers_ = tuple(reversed(MOUTH))

    def synthesise(self, phones, times):  # type: ignore[no-untyped-def]
        return super().synthesise(phones, times)[:, ::-1]


def test_a_performer_of_another_layout_is_refused(made: Corpus) -> None:
    model = Finished().fit([made.take("take00")])
    model.markers_ = MOUTH[1:]
    with pytest.raises(InputError, match=rf"anna does not move 1 of the mouth markers .* such as {MOUTH[0]}"):
        evaluate_performer("anna", {}, {"hers": model}, (), made)


def test_a_performer_is_refused_the_takes_it_was_learned_from(made: Corpus, tmp_path: Path) -> None:
    ready, _ = recordings(made)
    model = Finished().fit([r.take for r in ready.values()])
    digests = {made.identity("take04")}
    with pytest.raises(InputError, match=r"anna was learned from takes of .*: take04; score it on takes"):
        evaluate_performer("anna", {}, {"hers": model}, digests, made)
    other = Corpus.create(tmp_path / "other", {"layout": "mediapipe-218"})
    other.add(spoken("new", ("ma", "tea"), noise=0.05, seed=99))
    evaluation = evaluate_performer("anna", {}, {"hers": model}, digests, other)
    assert evaluation.marker_scores["hers"]["opening_r"].value > 0.98
    renamed = Corpus.create(tmp_path / "renamed", {"layout": "mediapipe-218"})
    take = made.take("take04")
    object.__setattr__(take, "name", "innocent")
    renamed.add(take)
    with pytest.raises(InputError, match="innocent"):
        evaluate_performer("anna", {}, {"hers": model}, digests, renamed)


def test_takes_that_cannot_be_scored_are_left_out_and_told(tmp_path: Path) -> None:
    made = corpus(tmp_path / "c", 2)
    silent = spoken("silent", ("ma",))
    object.__setattr__(silent, "phones", type(silent.phones)("phones", ()))
    made.add(silent)
    ready, notes = recordings(made)
    assert list(ready) == ["take00", "take01"]
    assert [note.kind for note in notes] == ["warning"]
    assert "take 'silent' holds no speech" in notes[0].message
    empty = Corpus.create(tmp_path / "empty", {"layout": "mediapipe-218"})
    with pytest.raises(InputError, match="none of its 0 takes can be scored"):
        recordings(empty)


def test_the_table_names_rows_units_and_what_cannot_be_told(random_evaluation: Evaluation) -> None:
    text = markdown(random_evaluation, "### Unseen takes")
    rows = [line for line in text.splitlines() if line.startswith("| mean pose |")]
    assert rows[0].split(" | ")[1] == "–"
    assert "| model | RMS (mm) | opening r |" in text
    assert text.index("As the default face shows it") < text.index("On markers")
    assert "Learned from 14 takes, scored on 2." in text
    own = random_evaluation.scores[RECORDING]["closure_f1"].value
    asked = f"Closures: {random_evaluation.bilabials} bilabials asked for"
    assert f"{asked}; F1 as a share of the recording's own ({own:.2f}): recording, captured " in text


def test_a_section_is_replaced_in_place_and_the_rest_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "results.md"
    path.write_text("# Results\n\nText by hand.\n")
    put_section(path, "one", "old")
    put_section(path, "two", "kept \\1")
    put_section(path, "one", "new \\g<0>")
    text = path.read_text()
    assert text.startswith("# Results\n\nText by hand.\n\n<!-- begin one -->\nnew \\g<0>\n<!-- end one -->")
    assert "kept \\1" in text
    assert "old" not in text
    with pytest.raises(OutputError, match=r"--report NAME\.md"):
        put_section(tmp_path / "results.txt", "one", "text")


def test_the_picture_shows_the_recording_and_every_model(random_evaluation: Evaluation, tmp_path: Path) -> None:
    path = tmp_path / "t.png"
    write_trajectories(path, random_evaluation.traces, ["cosine", "ridge"])
    pixels = np.asarray(Image.open(path).convert("RGB")).reshape(-1, 3).astype(int)
    for colour in ((20, 20, 20), (213, 94, 0), (0, 114, 178)):
        assert (np.abs(pixels - colour).max(axis=1) < 12).sum() > 200
    assert (np.abs(pixels - (0, 158, 115)).max(axis=1) < 12).sum() == 0
    with pytest.raises(InputError, match="needs a take and 1 to 6 models"):
        draw_trajectories((), ["cosine"])
