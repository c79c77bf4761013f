"""Training and scoring: every model on the same takes, each fold learned afresh."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError, Note
from mien.corpus.recordings import Corpus
from mien.metrics.baselines import Model
from mien.metrics.counts import Tally, tally
from mien.metrics.published import upper_face_dynamics_deviation
from mien.metrics.repetitions import Repetitions
from mien.metrics.scored_takes import Recording, prepare
from mien.metrics.scores import Score, score
from mien.metrics.splits import Fold
from mien.motion.mouth.speech_model import SpeechModel, synthesise

__all__ = [
    "RECORDING",
    "REPETITIONS",
    "YARDSTICKS",
    "Evaluation",
    "Trace",
    "evaluate_folds",
    "evaluate_performer",
    "recordings",
]

RECORDING = "recording"
"""Row in which the recording is scored against itself: the yardstick for closures and jitter."""
REPETITIONS = "other repetitions"
"""Row in which the words are told from the other takes that say them: a yardstick, though no bound."""
YARDSTICKS = (RECORDING, REPETITIONS)
ENOUGH_REPEATED = 0.9
"""Share of the scored takes whose words other takes must repeat for that row to mean anything."""
TRACES = 4
"""Takes whose trajectories are kept for a picture."""

Array = NDArray[np.float64]
Makers = Mapping[str, Callable[[], Model]]
Progress = Callable[[int, int, str], None]


@dataclass(frozen=True, eq=False)
class Trace:
    """Mouths of one take as recorded and as each model has it, for a picture."""

    recording: Recording
    mouths: Mapping[str, Array]


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Scores of models on held-out takes.

    Attributes
    ----------
    scores : mapping of str to mapping of str to Score
        By row and metric: first the `YARDSTICKS` (`REPETITIONS` only where words are repeated), then the models.
    pooled : bool
        Whether frames were pooled (unseen words) or takes averaged.
    folds : tuple of Fold
        Empty for a finished performer.
    takes, frames, bilabials : int
        Takes and frames that were scored, and bilabials that were asked for.
    upper_face : tuple of (float, float), or None
        Upper-face dynamics deviation, signed and absolute, of a face whose upper part does not move, mm: what every
        model of the mouth alone gets. None where no upper-face marker was recorded.
    traces : tuple of Trace
    notes : tuple of Note
    """

    scores: Mapping[str, Mapping[str, Score]]
    pooled: bool
    folds: tuple[Fold, ...]
    takes: int
    frames: int
    bilabials: int
    upper_face: tuple[float, float] | None
    traces: tuple[Trace, ...]
    notes: tuple[Note, ...] = ()


def recordings(corpus: Corpus) -> tuple[dict[str, Recording], tuple[Note, ...]]:
    """All takes of a corpus that can be scored, by name, and a note for each that cannot.

    Raises
    ------
    InputError
        If there is none.
    """
    ready: dict[str, Recording] = {}
    faults: list[str] = []
    for take in corpus:
        try:
            ready[take.name] = prepare(take)
        except InputError as problem:
            faults.append(str(problem))
    if not ready:
        reason = f"; the first says: {faults[0]}" if faults else ""
        raise InputError(f"{corpus.folder}: none of its {len(corpus)} takes can be scored{reason}")
    return ready, tuple(Note("warning", f"left out: {fault}") for fault in faults)


def evaluate_folds(
    ready: Mapping[str, Recording],
    folds: Sequence[Fold],
    makers: Makers,
    *,
    seed: int = 0,
    notes: Sequence[Note] = (),
    progress: Progress | None = None,
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

    Raises
    ------
    InputError
        If no frame is left to score.
    """
    tallies: dict[str, dict[str, Tally]] = {name: {} for name in (*YARDSTICKS, *makers)}
    traces: list[Trace] = []
    total = len(folds) * len(makers)
    every = Repetitions(ready.values())
    for number, fold in enumerate(folds):
        counted = {name: ready[name].inside(fold.words) for name in fold.test}
        test = [name for name in fold.test if counted[name].any()]
        mouths = {name: _yardsticks(ready[name], every, counted[name]) for name in test}
        for place, (model_name, make) in enumerate(makers.items()):
            if progress:
                progress(number * len(makers) + place, total, model_name)
            model = make().fit([ready[name].take for name in fold.train])
            for name in test:
                mouths[name][model_name] = _spoken(model, ready[name])
        for name in test:
            for row, mouth in mouths[name].items():
                _add(tallies[row], name, tally(ready[name], mouth, counted[name]))
        if not traces:
            traces = [Trace(ready[name], mouths[name]) for name in test[:: max(1, len(test) // TRACES)][:TRACES]]
    return _finished(ready, tallies, traces, tuple(folds), seed, tuple(notes))


def evaluate_performer(
    name: str,
    models: Mapping[str, SpeechModel],
    trained_on: Collection[str],
    corpus: Corpus,
    *,
    seed: int = 0,
) -> Evaluation:
    """Score a finished performer on takes that it has never met.

    Parameters
    ----------
    name : str
        Of the performer, for messages.
    models : mapping of str to SpeechModel
        By the name of the row.
    trained_on : collection of str
        Identities (`Corpus.identity`) of the takes that it was learned from.
    corpus : Corpus
    seed : int
        Of the bootstrap.

    Raises
    ------
    InputError
        If it was learned from a take of the corpus (told by its sound, whatever its name), it moves other markers,
        or nothing can be scored.
    """
    met = [take for take in corpus.names if corpus.identity(take) in trained_on]
    if met:
        more = f" and {len(met) - 3} more" if len(met) > 3 else ""
        raise InputError(
            f"{name} was learned from takes of {corpus.folder}: {', '.join(met[:3])}{more}; "
            "score it on takes that were held out of its learning"
        )
    ready, notes = recordings(corpus)
    tallies: dict[str, dict[str, Tally]] = {row: {} for row in (*YARDSTICKS, *models)}
    traces: list[Trace] = []
    every = Repetitions(ready.values())
    kept = sorted(ready)[:: max(1, len(ready) // TRACES)][:TRACES]
    for take, recording in ready.items():
        mouths = _yardsticks(recording, every, recording.speech)
        for row, model in models.items():
            order = _order(name, model.markers_, recording)
            mouths[row] = _spoken(model, recording)[:, order]
        for row, mouth in mouths.items():
            tallies[row][take] = tally(recording, mouth, recording.speech)
        traces += [Trace(recording, mouths)] if take in kept else []
    return _finished(ready, tallies, traces, (), seed, notes)


def _spoken(model: Model | SpeechModel, recording: Recording) -> Array:
    """The mouth as a model has it; one that listens hears the take."""
    return synthesise(model, recording.take.phones, recording.times, recording.take.audio)


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


def _add(tallies: dict[str, Tally], name: str, new: Tally) -> None:
    """A take tested in several folds (other words each time) counts once, with the frames of all."""
    old = tallies.get(name)
    tallies[name] = new if old is None else {family: old[family] + new[family] for family in new}


def _yardsticks(recording: Recording, every: Repetitions, counted: NDArray[np.bool_]) -> dict[str, Array]:
    """The recording itself, and the other repetitions of its words if they say all that is scored."""
    mouths = {RECORDING: _filled(recording)}
    repeated, known = every.mouth(recording)
    if known[counted].all():
        mouths[REPETITIONS] = repeated
    return mouths


def _finished(
    ready: Mapping[str, Recording],
    tallies: Mapping[str, dict[str, Tally]],
    traces: Sequence[Trace],
    folds: tuple[Fold, ...],
    seed: int,
    notes: tuple[Note, ...],
) -> Evaluation:
    rows = tallies[RECORDING]
    if not rows:
        raise InputError("the test set is empty: none of its takes has a frame to score; give other names or words")
    pooled = any(fold.words for fold in folds)
    shown = dict(tallies)
    if len(tallies[REPETITIONS]) < ENOUGH_REPEATED * len(rows):
        del shown[REPETITIONS]
    return Evaluation(
        scores={
            model: score([by_take[name] for name in sorted(by_take)], pooled=pooled, random=np.random.default_rng(seed))
            for model, by_take in shown.items()
        },
        pooled=pooled,
        folds=folds,
        takes=len(rows),
        frames=int(sum(t["lips"][1] for t in rows.values())),
        bilabials=int(sum(t["closure"][0] for t in rows.values())),
        upper_face=_still_upper_face([ready[name] for name in sorted(rows)]),
        traces=tuple(traces),
        notes=notes,
    )


def _filled(recording: Recording) -> Array:
    """The recorded mouth; frames in which a marker was not seen are bridged by straight lines (they are not scored)."""
    seen = np.asarray(np.isfinite(recording.positions).all(axis=(1, 2)))
    if seen.all():
        return recording.positions
    flat = recording.positions.reshape(len(seen), -1)
    columns = [np.interp(recording.times, recording.times[seen], column[seen]) for column in flat.T]
    return np.stack(columns, axis=1).reshape(recording.positions.shape)


def _still_upper_face(scored: Sequence[Recording]) -> tuple[float, float] | None:
    """Upper-face dynamics deviation of a still face, mean over takes; rest is the mean of the scored frames."""
    pairs = []
    for recording in scored:
        held = recording.speech & np.isfinite(recording.upper).all(axis=(1, 2))
        if recording.upper.shape[1] and held.sum() > 1:
            rest = recording.upper[held].mean(axis=0)
            still = np.broadcast_to(rest, recording.upper[held].shape)
            pairs.append(upper_face_dynamics_deviation(recording.upper[held], still, rest))
    if not pairs:
        return None
    signed, absolute = np.mean(pairs, axis=0)
    return float(signed), float(absolute)
