"""Learning a performer's speech from takes: one call, its progress, and what may be left out."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field

from mien.corpus.corpus import Corpus, identity_of
from mien.corpus.take import Take
from mien.errors import InputError
from mien.models.coarticulation import Coarticulation, CoarticulationSettings
from mien.models.curves import fitting_cost
from mien.models.performer_file import LearnedSpeech
from mien.models.speech_motion import SpeechMotion, SpeechMotionSettings

__all__ = ["LearningSettings", "Progress", "learn", "learn_corpus"]

Progress = Callable[[int, int, str], None]
"""Called with steps done, steps in all, and what is being done."""


@dataclass(frozen=True)
class LearningSettings:
    """What is learned, and how.

    Attributes
    ----------
    speech : SpeechMotionSettings
    paper : CoarticulationSettings
    """

    speech: SpeechMotionSettings = field(default_factory=SpeechMotionSettings)
    paper: CoarticulationSettings = field(default_factory=lambda: CoarticulationSettings(class_back_off=True))


def learn(
    takes: Sequence[Take],
    settings: LearningSettings | None = None,
    progress: Progress | None = None,
    *,
    name: str = "learned",
    about: Mapping[str, str] | None = None,
) -> LearnedSpeech:
    """Learn how a person speaks.

    Parameters
    ----------
    takes : sequence of Take
        Of one layout and frame rate.
    settings : LearningSettings or None
    progress : callable (done, total, what) or None
    name : str
        Of the performer.
    about : mapping of str to str
        Licence, attribution: kept in the file.

    Raises
    ------
    InputError
        If there is nothing to learn from.
    """
    settings = settings or LearningSettings()
    motion = SpeechMotion(settings.speech)
    total, done = motion.epochs + 1, 0

    def step(what: str) -> None:
        nonlocal done
        done += 1
        if progress:
            progress(done, total, what)

    motion.fit(takes, lambda: step("mouth"))
    paper = Coarticulation(settings.paper).fit(takes)
    cost = fitting_cost(paper.pairs_, settings.paper.least_pairs)
    step("curves")
    known = tuple(sorted(identity_of(take) for take in takes))
    return LearnedSpeech(name, motion, paper, cost, known, dict(about or {}))


def learn_corpus(
    corpus: Corpus,
    settings: LearningSettings | None = None,
    progress: Progress | None = None,
    *,
    name: str = "learned",
    exclude_words: Collection[str] = (),
    exclude_names: Collection[str] = (),
) -> LearnedSpeech:
    """Learn from the neutral takes of a corpus.

    Parameters
    ----------
    corpus : Corpus
    settings, progress, name
        As in `learn`.
    exclude_words : collection of str
        Takes in which one of these words is said are left out.
    exclude_names : collection of str
        Takes of these names are left out.

    Raises
    ------
    InputError
        If a name to leave out is not in the corpus, or no take is left.
    """
    unknown = sorted(set(exclude_names) - set(corpus.names))
    if unknown:
        raise InputError(f"{corpus.folder}: takes to leave out are not in this corpus: {', '.join(unknown[:5])}")
    words = {word.lower() for word in exclude_words}
    takes = [corpus.take(take) for take in corpus.names if take not in exclude_names and _is_neutral(corpus, take)]
    takes = [take for take in takes if words.isdisjoint(word.label.lower() for word in take.words)]
    if not takes:
        raise InputError(f"{corpus.folder}: no neutral take is left to learn from; leave out less")
    about = {key: str(value) for key, value in corpus.about.items() if key in ("licence", "citation")}
    return learn(takes, settings, progress, name=name, about=about)


def _is_neutral(corpus: Corpus, take: str) -> bool:
    return corpus.entries[take]["emotion"] in ("", "neutral")
