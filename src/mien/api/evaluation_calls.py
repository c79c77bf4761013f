"""`evaluate`: models learned afresh and scored on what was held out, or a finished performer on takes it never met."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from pathlib import Path

import numpy as np

from mien.core.errors import InputError
from mien.corpus.recordings import Corpus
from mien.corpus.take import Take
from mien.metrics import splits
from mien.metrics.compared_models import contenders
from mien.metrics.evaluation import Evaluation
from mien.metrics.fold_jobs import Away
from mien.metrics.protocols import evaluate_folds, evaluate_performer, recordings
from mien.motion.mouth.learned_mouth import LearnedMouth
from mien.motion.mouth.speech_model import SpeechModel
from mien.motion.performer import MouthModel
from mien.motion.performers import FORMER_NAME, HAND_MADE, known_performers, load_learned_performer, load_performer

__all__ = ["HARDEST", "PROTOCOLS", "evaluate", "is_performer"]

PROTOCOLS = ("random", "leave-words-out")
"""What is held out: takes, or words."""
HARDEST = "hardest"
"""As words: those that the other words say least about."""
Named = str | Path | Sequence[str] | None
Progress = Callable[[int, int, str], None]


def evaluate(
    subject: str | Path | Corpus,
    heldout: str | Path | Corpus | None = None,
    *,
    protocol: str | None = None,
    words: Named = None,
    test_names: Named = None,
    folds: int | None = None,
    models: Sequence[str] | None = None,
    seed: int = 0,
    progress: Progress | None = None,
    workers: int | None = 0,
    cluster: str | None = None,
) -> Evaluation:
    """Score models on the mouth that the default face shows (``docs/metrics.md``).

    Parameters
    ----------
    subject : str, Path or Corpus
        A corpus: every model is learned afresh for each fold. Or a performer (``"default"``, ``"x.mien"``).
    heldout : str, Path, Corpus or None
        The corpus to score a performer on.
    protocol : {"random", "leave-words-out"} or None
        What is held out of a corpus.
    words : str, Path, sequence of str or None
        Words to leave out and to score, or a file of them; ``"hardest"``: those that the other words say least about.
    test_names : str, Path, sequence of str or None
        Takes to hold out (of a performer: takes of ``heldout``) and to score, or a file of them.
    folds : int or None
        How many of the 8 parts are tested in turn; None: one.
    models : sequence of str or None
        Only these rows.
    seed : int
        Of the split and the bootstrap.
    progress : callable (done, total, what) or None
    workers : int or None
        Processes in which models are learned; 0: in this one, None: one per core. The result is the same.
    cluster : str or None
        Address of a Dask scheduler, on whose workers models are learned.

    Returns
    -------
    Evaluation
        ``scores[row][metric].value``; `mien.metrics.results_report.markdown` makes the tables.

    Raises
    ------
    InputError
        If options do not go together, the performer was learned from the takes, or nothing can be scored.
    """
    if seed < 0:
        raise InputError(f"a seed is a whole number, 0 or more, not {seed}")
    given = {"protocol": protocol, "words": words, "folds": folds, "models": models}
    if is_performer(subject):
        for name, value in given.items():
            if value is not None:
                raise InputError(f"--{name} is for learning afresh from a corpus; {subject} is learned already")
        if heldout is None:
            raise InputError(f"name the corpus of held-out takes too: mien evaluate {subject} HELDOUT")
        return _of_performer(str(subject), heldout, test_names, seed, progress)
    if heldout is not None:
        raise InputError(f"{heldout}: a second corpus is for a performer, 'mien evaluate PERFORMER HELDOUT'")
    _check_protocol(protocol, words, test_names, folds)
    unseen = protocol == PROTOCOLS[1]
    makers = contenders(models, unseen_words=unseen)
    corpus = _opened(subject)
    ready, notes = recordings(corpus)
    parts = _folds([r.take for r in ready.values()], protocol, words, test_names, folds, np.random.default_rng(seed))
    away = Away(str(corpus.folder), unseen, workers, cluster) if workers != 0 or cluster is not None else None
    return evaluate_folds(ready, parts, makers, seed=seed, notes=notes, progress=progress, away=away)


def is_performer(subject: str | Path | Corpus) -> bool:
    """A ``.mien`` file, or a name of a performer that comes with mien and of no folder here."""
    if isinstance(subject, Corpus):
        return False
    name = str(subject)
    return name.lower().endswith(".mien") or (name in (*known_performers(), FORMER_NAME) and not Path(name).is_dir())


def _opened(corpus: str | Path | Corpus) -> Corpus:
    return corpus if isinstance(corpus, Corpus) else Corpus(corpus)


def _of_performer(
    subject: str, heldout: str | Path | Corpus, test_names: Named, seed: int, progress: Progress | None
) -> Evaluation:
    mouths: dict[str, MouthModel] = {}
    models: dict[str, SpeechModel] = {}
    known: Collection[str] = ()
    if subject == HAND_MADE:
        mouths = {"hand-made": load_performer(HAND_MADE).mouth}
    else:
        learned = load_learned_performer(subject)
        known = learned.trained_on
        mouths = {f"performs: {kind}": LearnedMouth(learned, speech_model=kind) for kind in learned.speech_models}
        models = {"speech motion": learned.motion, "paper's curves": learned.coarticulation}
    names = _listed(test_names, "takes") if test_names else None
    return evaluate_performer(
        subject, mouths, models, known, _opened(heldout), names=names, seed=seed, progress=progress
    )


def _check_protocol(protocol: str | None, words: Named, test_names: Named, folds: int | None) -> None:
    """Options that do not go together are refused, none is passed over."""
    if protocol not in PROTOCOLS:
        raise InputError(f"learning afresh needs --protocol {' or --protocol '.join(PROTOCOLS)}")
    if words and protocol == "random":
        raise InputError("--words is for --protocol leave-words-out; name the takes of a random split by --test-names")
    if test_names and protocol == "leave-words-out":
        raise InputError("--test-names is for --protocol random; name the words that are left out by --words")
    if folds is not None and (words or test_names):
        raise InputError("--folds deals the test at random; with --words or --test-names there is one fold, the named")


def _folds(
    takes: Sequence[Take],
    protocol: str | None,
    words: Named,
    test_names: Named,
    folds: int | None,
    random: np.random.Generator,
) -> list[splits.Fold]:
    if words == HARDEST:
        return [splits.words_fold(takes, splits.hardest_words(takes))]
    if words:
        return [splits.words_fold(takes, _listed(words, "words"))]
    if test_names:
        return [splits.named_fold(takes, _listed(test_names, "takes"))]
    deal = splits.words_folds if protocol == "leave-words-out" else splits.random_folds
    return deal(takes, folds if folds is not None else 1, random)


def _listed(names: str | Path | Sequence[str], what: str) -> Sequence[str]:
    return splits.read_list(names, what) if isinstance(names, (str, Path)) else names
