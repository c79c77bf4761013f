"""Learning the rows of a table for each fold: here, in other processes or on a cluster, with the same result."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.one_thread import one_thread
from mien.corpus.recordings import Corpus
from mien.corpus.take import Take
from mien.corpus.workers import each
from mien.metrics.baselines import Model
from mien.metrics.compared_models import OF_ONE_LEARNING, contenders
from mien.metrics.evaluation import names_of
from mien.metrics.scored_takes import Recording, prepare
from mien.metrics.splits import Fold
from mien.motion.mouth.speech_model import SpeechModel, synthesise

__all__ = ["Answer", "Away", "answer_of", "spoken"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Answer:
    """What a model gave for the takes of a test, and the channels or markers that it moves."""

    moved: tuple[str, ...]
    motion: dict[str, Array]


def spoken(model: Model | SpeechModel, recording: Recording) -> Array:
    """The mouth as a model has it; one that listens hears the take."""
    return synthesise(model, recording.take.phones, recording.times, recording.take.audio)


@one_thread
def answer_of(model: Model, train: Sequence[Take], test: Sequence[Recording]) -> Answer:
    """Learn from takes and perform others."""
    learned = model.fit(train)
    return Answer(names_of(learned), {recording.take.name: spoken(learned, recording) for recording in test})


@dataclass(frozen=True)
class _Job:
    folder: str
    number: int
    rows: tuple[str, ...]
    train: tuple[str, ...]
    test: tuple[str, ...]
    unseen_words: bool


def _learned(job: _Job) -> dict[str, Answer]:
    corpus = Corpus(job.folder)
    train = [prepare(corpus.take(name)).take for name in job.train]
    test = [prepare(corpus.take(name)) for name in job.test]
    makers = contenders(job.rows, unseen_words=job.unseen_words)
    return {row: answer_of(make(), train, test) for row, make in makers.items()}


@dataclass(frozen=True)
class Away:
    """Where else models are learned.

    Attributes
    ----------
    folder : str
        Of the corpus, under the same path on every machine.
    unseen_words : bool
        As `mien.metrics.compared_models.contenders` has it.
    workers : int or None
        Processes; None: one per core.
    cluster : str or None
        Address of a Dask scheduler.
    """

    folder: str
    unseen_words: bool
    workers: int | None = None
    cluster: str | None = None

    def learned(self, folds: Sequence[Fold], rows: Sequence[str]) -> Callable[[int, str], Answer]:
        """Start learning; what is returned waits for the row of a fold that it is asked for."""
        together = tuple(row for row in rows if row in OF_ONE_LEARNING)
        # those that take longest stand last in a table
        groups: list[tuple[str, ...]] = [(row,) for row in reversed(rows) if row not in together]
        groups = [*([together] if together else []), *groups]
        jobs = [
            _Job(self.folder, number, group, fold.train, fold.test, self.unseen_words)
            for number, fold in enumerate(folds)
            for group in groups
        ]
        running = each(_learned, jobs, self.workers, self.cluster)
        found: dict[tuple[int, str], Answer] = {}

        def answer(number: int, row: str) -> Answer:
            while (number, row) not in found:
                job, result = next(running)
                if isinstance(result, BaseException):
                    raise InputError(f"learning {', '.join(job.rows)} failed: {result}") from result
                found.update({(job.number, name): given for name, given in result.items()})
            return found.pop((number, row))

        return answer
