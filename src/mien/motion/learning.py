"""Learning a performer's speech from takes: one call, its progress, and what may be left out."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from mien.core.errors import InputError, Note, unknown_name
from mien.corpus.recordings import Corpus, identity_of
from mien.corpus.take import Take
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
from mien.motion.mouth.mouth_space import mouth_space_of
from mien.motion.mouth.speech_motion import SpeechMotion, SpeechMotionSettings
from mien.motion.performer_file import SPEECH_MODELS, LearnedSpeech

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


def learn(
    takes: Sequence[Take],
    settings: LearningSettings | None = None,
    progress: Progress | None = None,
    *,
    name: str = "learned",
    about: Mapping[str, str] | None = None,
    felt: Sequence[Take] = (),
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

    Raises
    ------
    InputError
        If there is nothing to learn from.
    """
    settings = (settings or LearningSettings()).in_one_space([*takes, *felt])
    motion = SpeechMotion(settings.speech)
    recorded = settings.speech_model != "coarticulation"
    trials = TRIALS if recorded and None in (settings.graph.weights, settings.graph.evenness) else 0
    total, done = motion.epochs + 1 + trials + int(recorded), 0

    def step(what: str) -> None:
        nonlocal done
        done += 1
        if progress:
            progress(done, total, what)

    motion.fit(takes, lambda: step("mouth"))
    paper = Coarticulation(settings.paper).fit(takes)
    cost = fitting_cost(paper.pairs_, settings.paper.least_pairs)
    step("curves")
    graph = _recorded(motion, takes, felt, settings, lambda: step("graph")) if recorded else None
    if recorded:
        step("recordings")
    known = tuple(sorted(identity_of(take) for take in takes))
    return LearnedSpeech(name, motion, paper, cost, known, dict(about or {}), graph, settings.speech_model)


def _recorded(
    motion: SpeechMotion,
    takes: Sequence[Take],
    felt: Sequence[Take],
    settings: LearningSettings,
    after_trial: Callable[[], None],
) -> RecordedSpeech:
    """The graph of the takes, and for ``both`` what they did beside the learned curves."""
    felt = levelled(felt, takes, motion.mouth_)
    graph = GraphMotion(settings.graph).fit(takes, after_trial, felt)
    if settings.speech_model == "graph":
        return RecordedSpeech.of(graph, None)
    return RecordedSpeech.of(graph, learned_residuals(motion, graph.graph_, [*takes, *felt]))


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
    learned = learn(takes, settings, progress, name=name, about=about, felt=felt)
    known = tuple(sorted({*learned.trained_on, *map(identity_of, felt)}))
    return replace(learned, expressions=expressions, trained_on=known, emotion_maps=maps)


def _is_neutral(corpus: Corpus, take: str) -> bool:
    return corpus.entries[take]["emotion"] in ("", "neutral")
