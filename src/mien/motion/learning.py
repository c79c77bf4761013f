"""Learning a performer's speech from takes: one call, its progress, and what may be left out."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any

from mien.core.errors import InputError, Note, unknown_name
from mien.core.one_thread import one_thread
from mien.corpus.recordings import Corpus, identity_of
from mien.corpus.take import Take
from mien.corpus.workers import each
from mien.motion.expression.recorded_expression import learn_expressions
from mien.motion.graph.combined_motion import learned_residuals
from mien.motion.graph.felt_takes import levelled
from mien.motion.graph.graph_file import RecordedSpeech
from mien.motion.graph.graph_motion import GraphMotion, GraphMotionSettings
from mien.motion.graph.weight_learning import TRIALS
from mien.motion.learning_judgement import judge
from mien.motion.maps.emotion_maps import learn_emotion_maps
from mien.motion.mouth.coarticulation import Coarticulation, CoarticulationSettings
from mien.motion.mouth.influence_curves import fitting_cost
from mien.motion.mouth.mouth_space import ChannelSpace, mouth_space_of
from mien.motion.mouth.speech_motion import SpeechMotion, SpeechMotionSettings
from mien.motion.performer_file import SPEECH_MODELS, LearnedSpeech

__all__ = ["Away", "LearningSettings", "Progress", "learn", "learn_corpus"]

Progress = Callable[[int, int, str], None]
"""Called with steps done, steps in all, and what is being done."""


@dataclass(frozen=True)
class LearningSettings:
    """What is learned, and how.

    Attributes
    ----------
    speech : SpeechMotionSettings
    paper : CoarticulationSettings
    graph : GraphMotionSettings
    speech_model : str
        ``coarticulation``: learned curves alone; ``graph``: recorded motion too, and it performs; ``both``: the curves
        are corrected by what was recorded, and that performs.
    learn_in : {"channels", "markers"} or None
        In what the mouth is learned; None: in channels where every take has them (`mien.motion.mouth.mouth_space`).
    """

    speech: SpeechMotionSettings = field(default_factory=SpeechMotionSettings)
    paper: CoarticulationSettings = field(default_factory=lambda: CoarticulationSettings(class_back_off=True))
    graph: GraphMotionSettings = field(default_factory=GraphMotionSettings)
    speech_model: str = "both"
    learn_in: str | None = None

    def __post_init__(self) -> None:
        if self.speech_model not in SPEECH_MODELS:
            raise unknown_name("speech model", self.speech_model, SPEECH_MODELS)

    def in_one_space(self, takes: Sequence[Take]) -> LearningSettings:
        """The same for models that all learn in the space that suits the takes."""
        space = mouth_space_of(takes, self.learn_in).kind
        return replace(
            self,
            speech=replace(self.speech, learn_in=space),
            paper=replace(self.paper, learn_in=space),
            graph=replace(self.graph, learn_in=space),
        )


@one_thread
def learn(
    takes: Sequence[Take],
    settings: LearningSettings | None = None,
    progress: Progress | None = None,
    *,
    name: str = "learned",
    about: Mapping[str, str] | None = None,
    felt: Sequence[Take] = (),
    away: Away | None = None,
    prior: LearnedSpeech | None = None,
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
    felt : sequence of Take
        Expressive takes: recorded motion that serves where their emotion is asked for (`felt_takes`).
    away : Away or None
        Learn the parts in other processes or on a cluster; None learns here. The result is the same.
    prior : LearnedSpeech or None
        A performer whose mouth is started from (`mien.motion.mouth.starting_point`): what is learned is how this person
        differs. Its takes then count as known, and ``about`` names it.

    Raises
    ------
    InputError
        If there is nothing to learn from.
    """
    settings = (settings or LearningSettings()).in_one_space([*takes, *felt])
    recorded = settings.speech_model != "coarticulation"
    known = tuple(sorted({*map(identity_of, takes), *(prior.trained_on if prior else ())}))
    about = dict(about or {}) | (_owed(prior) if prior else {})
    start = prior.motion if prior else None
    if away is not None:
        parts = away.learned(PARTS if recorded else PARTS[:2], takes, felt, settings, progress, start)
        motion, paper = parts[MOUTH], parts[CURVES]
        graph = _with_residuals(motion, parts[GRAPH], takes, felt, settings) if recorded else None
        cost = fitting_cost(paper.pairs_, settings.paper.least_pairs)
        return LearnedSpeech(name, motion, paper, cost, known, about, graph, settings.speech_model)
    motion = SpeechMotion(start.settings if start else settings.speech)
    trials = TRIALS if recorded and None in (settings.graph.weights, settings.graph.evenness) else 0
    total, done = motion.epochs + 1 + trials + int(recorded), 0

    def step(what: str) -> None:
        nonlocal done
        done += 1
        if progress:
            progress(done, total, what)

    motion.fit(takes, lambda: step("mouth"), start)
    paper = Coarticulation(settings.paper).fit(takes)
    cost = fitting_cost(paper.pairs_, settings.paper.least_pairs)
    step("curves")
    graph = None
    if recorded:
        searched = _graph(takes, felt, settings, lambda: step("graph"))
        graph = _with_residuals(motion, searched, takes, felt, settings)
        step("recordings")
    return LearnedSpeech(name, motion, paper, cost, known, about, graph, settings.speech_model)


def _owed(prior: LearnedSpeech) -> dict[str, str]:
    """What a performer's file says of the one that it was started from."""
    terms = "; ".join(prior.about[key] for key in ("licence", "citation") if prior.about.get(key))
    return {"started from": f"{prior.name} ({terms})" if terms else prior.name}


def _graph(
    takes: Sequence[Take], felt: Sequence[Take], settings: LearningSettings, after_trial: Callable[[], None]
) -> GraphMotion:
    """The graph of the takes, those with an emotion levelled."""
    felt = levelled(felt, takes, mouth_space_of(takes, settings.graph.learn_in))
    return GraphMotion(settings.graph).fit(takes, after_trial, felt)


def _with_residuals(
    motion: SpeechMotion,
    graph: GraphMotion,
    takes: Sequence[Take],
    felt: Sequence[Take],
    settings: LearningSettings,
) -> RecordedSpeech:
    """The graph, and for ``both`` what its takes did beside the learned curves."""
    if settings.speech_model == "graph":
        return RecordedSpeech.of(graph, None)
    felt = levelled(felt, takes, motion.mouth_)
    return RecordedSpeech.of(graph, learned_residuals(motion, graph.graph_, [*takes, *felt]))


MOUTH, CURVES, GRAPH = PARTS = ("mouth", "curves", "graph")
"""Parts of a performer's speech that are learned from takes, none from another."""


@dataclass(frozen=True)
class _Part:
    what: str
    folder: str
    takes: tuple[str, ...]
    felt: tuple[str, ...]
    settings: LearningSettings
    start: SpeechMotion | None


@one_thread
def _learned_part(part: _Part) -> Any:
    corpus, settings = Corpus(part.folder), part.settings
    takes = [corpus.take(name) for name in part.takes]
    if part.what == MOUTH:
        return SpeechMotion(settings.speech).fit(takes, prior=part.start)
    if part.what == CURVES:
        return Coarticulation(settings.paper).fit(takes)
    return _graph(takes, [corpus.take(name) for name in part.felt], settings, lambda: None)


@dataclass(frozen=True)
class Away:
    """Where else the parts are learned: ``workers`` processes (None: one per core), or a Dask ``cluster``.

    ``folder``: of the corpus, under the same path on every machine.
    """

    folder: str
    workers: int | None = None
    cluster: str | None = None

    def learned(
        self,
        parts: Sequence[str],
        takes: Sequence[Take],
        felt: Sequence[Take],
        settings: LearningSettings,
        progress: Progress | None,
        start: SpeechMotion | None = None,
    ) -> dict[str, Any]:
        """Each part by its name."""
        plain, expressive = (tuple(take.name for take in some) for some in (takes, felt))
        jobs = [_Part(what, self.folder, plain, expressive, settings, start) for what in parts]
        found: dict[str, Any] = {}
        for job, result in each(_learned_part, jobs, self.workers, self.cluster):
            if isinstance(result, BaseException):
                raise InputError(f"learning the {job.what} failed: {result}") from result
            found[job.what] = result
            if progress:
                progress(len(found), len(jobs), job.what)
        return found


def learn_corpus(
    corpus: Corpus,
    settings: LearningSettings | None = None,
    progress: Progress | None = None,
    *,
    name: str = "learned",
    exclude_words: Collection[str] = (),
    exclude_names: Collection[str] = (),
    speakers: str = "one",
    tell: Callable[[Note], None] = lambda note: None,
    workers: int | None = 0,
    cluster: str | None = None,
    prior: LearnedSpeech | None = None,
) -> LearnedSpeech:
    """Learn speech from the neutral takes of a corpus, expressions and emotional speech from those with an emotion.

    Without a neutral take all are learned as speech, and no expression.

    Parameters
    ----------
    corpus : Corpus
    settings, progress, name
        As in `learn`.
    exclude_words : collection of str
        Takes in which one of these words is said are left out.
    exclude_names : collection of str
        Takes of these names are left out.
    speakers : str
        As in `mien.motion.learning_judgement.judge`, which says what is there, what is left out, and what is missing.
    tell : callable
        Takes each note as soon as it is known, before anything is learned.
    workers : int or None
        Processes that learn; 0: this one, None: one per core. The result is the same.
    cluster : str or None
        Address of a Dask scheduler, on whose workers is learned.
    prior : LearnedSpeech or None
        As in `learn`; left aside, with a note, where it was learned from takes of this corpus (it would know what is
        held out), where there are no captured channels, or where the mouth is to be learned in markers.

    Raises
    ------
    InputError
        If a name to leave out is not in the corpus, no take is left, or several people would share one mouth.
    """
    unknown = sorted(set(exclude_names) - set(corpus.names))
    if unknown:
        raise InputError(f"{corpus.folder}: takes to leave out are not in this corpus: {', '.join(unknown[:5])}")
    words = {word.lower() for word in exclude_words}
    takes = [corpus.take(take) for take in corpus.names if take not in exclude_names and _is_neutral(corpus, take)]
    takes = [take for take in takes if words.isdisjoint(word.label.lower() for word in take.words)]
    if corpus.unfinished:
        tell(Note("warning", corpus.unfinished))
    about = {key: str(value) for key, value in corpus.about.items() if key in ("licence", "citation")}
    felt = [corpus.take(take) for take in corpus.names if take not in exclude_names and not _is_neutral(corpus, take)]
    felt = [take for take in felt if words.isdisjoint(word.label.lower() for word in take.words)]
    if not takes and not felt:
        raise InputError(corpus.unfinished or f"{corpus.folder}: no take is left to learn from; leave out less")
    judgement = judge(takes, felt, speakers=speakers)
    for note in judgement.notes:
        tell(note)
    takes, felt, twins = list(judgement.takes), list(judgement.felt), list(judgement.twins)
    bare = sum(take.channels is None for take in (*takes, *felt))
    if bare and (settings is None or settings.learn_in is None):
        told = f"the mouth is learned in markers: {bare} takes have no captured channels"
        tell(Note("warning", f"{told}; run: mien corpus upgrade {corpus.folder}"))
    expressions = learn_expressions([*takes, *twins]) if twins else None  # first: it is quick, and may refuse
    maps = learn_emotion_maps([*takes, *twins]) if twins else None
    if not takes:  # nobody was recorded neutral: how they speak is learned from what there is
        takes, felt = felt, []
    prior = _usable(prior, corpus, [*takes, *felt], settings, tell)
    away = Away(str(corpus.folder), workers, cluster) if workers != 0 or cluster is not None else None
    learned = learn(takes, settings, progress, name=name, about=about, felt=felt, away=away, prior=prior)
    known = tuple(sorted({*learned.trained_on, *map(identity_of, felt)}))
    return replace(learned, expressions=expressions, trained_on=known, emotion_maps=maps)


def _usable(
    prior: LearnedSpeech | None,
    corpus: Corpus,
    takes: Sequence[Take],
    settings: LearningSettings | None,
    tell: Callable[[Note], None],
) -> LearnedSpeech | None:
    """The performer to start from, or None and why not."""
    if prior is None:
        return None
    why, seen = "", {take.name for take in takes}
    others = (corpus.identity(name) for name in corpus.names if name not in seen)
    if (settings is not None and settings.learn_in == "markers") or any(take.channels is None for take in takes):
        why = "the mouth is learned in markers"
    elif not isinstance(prior.motion.mouth_, ChannelSpace):
        why = "it was learned in markers"
    elif any(one in prior.trained_on for one in chain(map(identity_of, takes), others)):
        why = "it was learned from takes of this corpus and would know what is held out"
    if why:
        tell(Note("warning", f"not started from {prior.name}: {why}"))
    return None if why else prior


def _is_neutral(corpus: Corpus, take: str) -> bool:
    return corpus.entries[take]["emotion"] in ("", "neutral")
