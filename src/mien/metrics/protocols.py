"""Training and scoring: every model on the same takes, each fold learned afresh.

What is scored is the mouth that the default face shows (`mien.metrics.shown_mouth`), a constant offset for each speaker
removed; models that give markers are scored on those beside, as the papers do, nothing removed.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mien.core.channels import ALL
from mien.core.errors import InputError, Note
from mien.core.tracks import ChannelTrack
from mien.core.utterance import Utterance
from mien.corpus.recordings import Corpus
from mien.metrics.baselines import Model
from mien.metrics.evaluation import MARKERS, CountedRows, Evaluation, names_of
from mien.metrics.fold_jobs import Answer, Away, answer_of, spoken
from mien.metrics.scored_takes import Recording, prepare
from mien.metrics.splits import Fold, check_names
from mien.motion.mouth.speech_model import SpeechModel
from mien.motion.performer import MouthModel

__all__ = ["evaluate_folds", "evaluate_performer", "recordings"]

Array = NDArray[np.float64]
Makers = Mapping[str, Callable[[], Model]]
Progress = Callable[[int, int, str], None]


def recordings(corpus: Corpus, names: Collection[str] | None = None) -> tuple[dict[str, Recording], tuple[Note, ...]]:
    """All takes of a corpus that can be scored, or those of ``names``, by name, and a note for each that cannot.

    Raises
    ------
    InputError
        If there is none, or a name is not in the corpus.
    """
    ready: dict[str, Recording] = {}
    faults: list[str] = []
    chosen = corpus.names if names is None else check_names(names, corpus.names)
    for take in map(corpus.take, chosen):
        try:
            ready[take.name] = prepare(take)
        except InputError as problem:
            faults.append(str(problem))
    if not ready:
        if corpus.unfinished:
            raise InputError(corpus.unfinished)
        reason = f"; the first says: {faults[0]}" if faults else ""
        raise InputError(f"{corpus.folder}: none of its {len(corpus)} takes can be scored{reason}")
    unfinished = (Note("warning", corpus.unfinished),) if corpus.unfinished else ()
    return ready, (*unfinished, *(Note("warning", f"left out: {fault}") for fault in faults))


def evaluate_folds(
    ready: Mapping[str, Recording],
    folds: Sequence[Fold],
    makers: Makers,
    *,
    seed: int = 0,
    notes: Sequence[Note] = (),
    progress: Progress | None = None,
    away: Away | None = None,
) -> Evaluation:
    """Learn every model afresh for each fold and score it on the fold's test.

    Parameters
    ----------
    ready : mapping of str to Recording
    folds : sequence of Fold
    makers : mapping of str to callable
        Each makes an untrained model.
    seed : int
        Of the bootstrap.
    notes : sequence of Note
        Carried over to the result.
    progress : callable (done, total, model) or None
    away : Away or None
        Learn in other processes or on a cluster; None learns here. The result is the same.

    Raises
    ------
    InputError
        If no frame is left to score, or learning failed elsewhere.
    """
    counts = CountedRows(ready, makers)
    here = _learned_here(ready, folds, makers) if away is None else away.learned(folds, tuple(makers))
    done = 0
    for number, fold in enumerate(folds):
        counted = {name: ready[name].inside(fold.words) for name in fold.test}
        counts.open({name: held for name, held in counted.items() if held.any()})
        for row in makers:
            if progress:
                progress(done, len(folds) * len(makers), row)
            answer = here(number, row)
            for name in counts.counted:
                counts.add(row, name, answer.moved, answer.motion[name])
            done += 1
        counts.close()
    return counts.finished(tuple(folds), seed, tuple(notes))


def _learned_here(
    ready: Mapping[str, Recording], folds: Sequence[Fold], makers: Makers
) -> Callable[[int, str], Answer]:
    def learned(number: int, row: str) -> Answer:
        fold = folds[number]
        return answer_of(makers[row](), [ready[name].take for name in fold.train], [ready[name] for name in fold.test])

    return learned


def evaluate_performer(
    name: str,
    mouths: Mapping[str, MouthModel],
    models: Mapping[str, SpeechModel],
    trained_on: Collection[str],
    corpus: Corpus,
    *,
    names: Collection[str] | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Evaluation:
    """Score a finished performer on takes that it has never met.

    Parameters
    ----------
    name : str
        Of the performer, for messages.
    mouths : mapping of str to MouthModel
        What performs, by the name of the row: scored as the face shows it.
    models : mapping of str to SpeechModel
        What it learned, by the name of the row: scored as shown, and on its markers if it gives markers.
    trained_on : collection of str
        Identities (`Corpus.identity`) of the takes that it was learned from.
    corpus : Corpus
        Whatever its own reference frame: what it differs by all the time is removed, and said.
    names : collection of str or None
        Only these takes of it.
    seed : int
        Of the bootstrap.
    progress : callable (done, total, take) or None

    Raises
    ------
    InputError
        If it was learned from a take of the corpus (known by its sound, whatever its name), it moves other markers,
        or nothing can be scored.
    """
    met = [take for take in (corpus.names if names is None else names) if corpus.identity(take) in trained_on]
    if met:
        more = f" and {len(met) - 3} more" if len(met) > 3 else ""
        raise InputError(
            f"{name} was learned from takes of {corpus.folder}: {', '.join(met[:3])}{more}; "
            "score it on takes that were held out of its learning"
        )
    ready, notes = recordings(corpus, names)
    counts = CountedRows(ready, (*mouths, *models))
    counts.open({take: recording.speech for take, recording in ready.items()})
    for number, (take, recording) in enumerate(ready.items()):
        if progress:
            progress(number, len(ready), take)
        for row, mouth in mouths.items():
            counts.show(row, take, _performed(mouth, recording))
        for row, model in models.items():
            motion = spoken(model, recording)
            if motion.ndim == MARKERS:
                motion = motion[:, _order(name, names_of(model), recording)]
            counts.add(row, take, names_of(model), motion)
    counts.close(brought_together=True)
    return counts.finished((), seed, notes)


def _performed(mouth: MouthModel, recording: Recording) -> ChannelTrack:
    """The channels with which a mouth performs a take, frame by frame with the recording."""
    take = recording.take
    speech = Utterance(take.text, take.audio, take.words, take.phones, "en-US", "aligned")
    values = mouth.perform(speech, take.markers.rate).values
    rows = np.minimum(np.arange(len(recording.times)), len(values) - 1)
    return ChannelTrack(ALL, values[rows], take.markers.rate)


def _order(name: str, markers: Sequence[str], recording: Recording) -> list[int]:
    """Places of the recorded markers among those that a performer moves."""
    places = {marker: place for place, marker in enumerate(markers)}
    missing = [marker for marker in recording.take.markers.names if marker not in places]
    if missing:
        raise InputError(
            f"{name} does not move {len(missing)} of the mouth markers of take {recording.take.name!r}, such as "
            f"{missing[0]}: score it on a corpus of the layout that it was learned from"
        )
    return [places[marker] for marker in recording.take.markers.names]
