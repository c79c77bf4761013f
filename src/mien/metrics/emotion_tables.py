"""How well emotion is told from voices: Table I of Cao et al. 2005 on any labelled corpus, and stricter rows beside it.

The paper's table trains and tests on the same recordings, or on random halves, so that the same voices are on both
sides. Here stand beside it: speakers held out, other corpora, the features that mien uses, and whether probabilities
are true.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import Note
from mien.corpus.labelled_sounds import LabelledSounds
from mien.emotion.emotion_classifier import NEUTRAL, EmotionClassifier, default_classifier
from mien.emotion.emotion_samples import VOICE, EmotionSamples, emotion_samples
from mien.emotion.support_vectors import Kernel, SupportVectors, held_out_folds

__all__ = ["Judgement", "emotion_tables", "expected_calibration_error"]

COEFFICIENTS = (50, 100, 500, 1000)
KERNELS: tuple[Kernel, ...] = ("linear", "radial")
VARIATIONS = 4
PAPER_COST = 1.0
_BINS = 10
Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Judgement:
    """Figures of one classifier on recordings that it did not learn from.

    Attributes
    ----------
    accuracy : float
        Share of recordings whose likeliest emotion is theirs.
    balanced : float
        The mean of that over emotions (unweighted average recall).
    brier : float
        Mean of Σ (p - truth)² over emotions, 0 to 2.
    calibration : float
        `expected_calibration_error`.
    """

    accuracy: float
    balanced: float
    brier: float
    calibration: float


def judge(probabilities: NDArray[np.float64], classes: Sequence[str], truth: Sequence[str]) -> Judgement:
    """Compare probabilities, shape (samples, classes), with the true emotions."""
    names, wanted = np.array(classes), np.array(truth)
    right = names[probabilities.argmax(axis=1)] == wanted
    per_emotion = [right[wanted == name].mean() for name in np.unique(wanted)]
    brier = ((probabilities - (wanted[:, None] == names)) ** 2).sum(axis=1).mean()
    calibration = expected_calibration_error(probabilities.max(axis=1), right)
    return Judgement(float(right.mean()), float(np.mean(per_emotion)), float(brier), calibration)


def expected_calibration_error(sureness: NDArray[np.float64], right: NDArray[np.bool_]) -> float:
    """Mean distance between how sure and how often right, over ten bins of sureness (Guo et al. 2017, ECE).

    Examples
    --------
    >>> round(expected_calibration_error(np.array([0.75, 0.75, 0.75, 0.75]), np.array([True, True, True, False])), 3)
    0.0
    """
    bins = np.minimum((sureness * _BINS).astype(int), _BINS - 1)
    parts = [np.flatnonzero(bins == b) for b in range(_BINS)]
    return float(sum(len(p) * abs(sureness[p].mean() - right[p].mean()) for p in parts if len(p)) / len(right))


def emotion_tables(
    corpora: Sequence[LabelledSounds], seed: int = 0, workers: int | None = None, progress: Progress | None = None
) -> tuple[str, tuple[Note, ...]]:
    """All tables of some corpora as Markdown, and what was left out on the way."""
    paper, own = _read_all(corpora, seed, workers, progress)
    notes = tuple(note for samples in own for note in samples.notes)
    parts = [
        part
        for corpus, cepstra, voices in zip(corpora, paper, own, strict=True)
        for part in (_paper_table(corpus, cepstra, seed), _own_table(corpus, cepstra, voices))
    ]
    parts.append(_cross_table(corpora, own))
    return "\n\n".join(parts), notes


def _read_all(
    corpora: Sequence[LabelledSounds], seed: int, workers: int | None, progress: Progress | None
) -> tuple[list[EmotionSamples], list[EmotionSamples]]:
    sizes = [len(corpus.sounds) * part for corpus in corpora for part in (1, 1 + VARIATIONS)]
    found: list[EmotionSamples] = []
    for number in range(len(sizes)):
        corpus, is_paper = corpora[number // 2], number % 2 == 0

        def step(done: int, _: int, before: int = sum(sizes[:number])) -> None:
            if progress is not None:
                progress(before + done, sum(sizes))

        kind, variations = (f"cepstral:{max(COEFFICIENTS)}", 0) if is_paper else (VOICE, VARIATIONS)
        found.append(emotion_samples(corpus, kind, variations, seed, workers, step))
    return found[0::2], found[1::2]


def _paper_table(corpus: LabelledSounds, samples: EmotionSamples, seed: int) -> str:
    """Table I: share of recordings told right."""
    truth = np.array(samples.emotions)
    half = np.random.default_rng(seed).permutation(len(truth)) < len(truth) // 2
    everything = np.ones(len(truth), dtype=bool)
    folds = held_out_folds(truth, np.array(samples.speakers))
    lines = [
        f"## {corpus.name}: Table I of Cao et al. 2005",
        "",
        f"{len(truth)} recordings, {len(corpus.emotions)} emotions ({', '.join(corpus.emotions)}); mean, variance, "
        "RMS and cepstrum scaled to -1..1; share told right. The most frequent emotion alone: "
        f"{np.unique(truth, return_counts=True)[1].max() / len(truth):.2f}.",
        "",
        "| tested on | kernel | " + " | ".join(f"{n} coefficients" for n in COEFFICIENTS) + " |",
        "| --- | --- |" + " ---: |" * len(COEFFICIENTS),
    ]
    rows = (
        ("what it learned from", [(everything, everything)]),
        ("the other half, drawn at random", [(half, ~half)]),
        (_who(corpus), [(_mask(known, len(truth)), _mask(out, len(truth))) for known, out in folds]),
    )
    for title, splits in rows:
        for kernel in KERNELS:
            cells = [_share_right(samples.features[:, : 3 + n], truth, kernel, splits) for n in COEFFICIENTS]
            lines.append(f"| {title} | {kernel} | " + " | ".join(f"{value:.2f}" for value in cells) + " |")
    return "\n".join(lines)


def _who(corpus: LabelledSounds) -> str:
    return "speakers held out" if len(corpus.speakers) > 1 else "recordings held out (speakers not known)"


def _mask(index: NDArray[np.intp], length: int) -> NDArray[np.bool_]:
    mask = np.zeros(length, dtype=bool)
    mask[index] = True
    return mask


def _share_right(
    features: NDArray[np.float64],
    truth: NDArray[np.str_],
    kernel: Kernel,
    splits: Sequence[tuple[NDArray[np.bool_], NDArray[np.bool_]]],
) -> float:
    right = []
    for known, tested in splits:
        machine = SupportVectors(kernel, 1.0, "range", balanced=False).fit_vectors(features[known], truth[known])
        right += [a == b for a, b in zip(machine.votes(features[tested]), truth[tested], strict=True)]
    return float(np.mean(right))


def _own_table(corpus: LabelledSounds, cepstra: EmotionSamples, voices: EmotionSamples) -> str:
    """Speakers held out: the paper's features and ours, with the truth of the probabilities."""
    lines = [
        f"## {corpus.name}: {_who(corpus)}",
        "",
        "Probabilities come from classifiers that knew nothing of the speaker, not in calibration either. "
        "`varied`: the same recordings through other rooms, microphones and levels "
        f"({VARIATIONS} of each, made by mien).",
        "",
        "| features | tested on | told right | mean over emotions | Brier | ECE |",
        "| --- | --- | ---: | ---: | ---: | ---: |",
    ]
    for title, samples, learns in (
        ("Cao et al. 2005, 500 coefficients", cepstra, False),
        ("mien, learned without variations", voices, False),
        ("mien", voices, True),
    ):
        probabilities, classes, tested = _held_out(samples, learns)
        for what, rows in (("recordings", samples.variation == 0), ("varied", samples.variation > 0)):
            if (rows & tested).any():
                truth = [samples.emotions[i] for i in np.flatnonzero(rows & tested)]
                lines.append(f"| {title} | {what} | {_cells(judge(probabilities[rows & tested], classes, truth))} |")
    return "\n".join([*lines, "", *_threshold_lines(voices)])


def _held_out(
    samples: EmotionSamples, learn_variations: bool
) -> tuple[NDArray[np.float64], tuple[str, ...], NDArray[np.bool_]]:
    """Probabilities of every sample by a classifier that did not know its speaker, nested calibration included."""
    truth = np.array(samples.emotions)
    classes = tuple(str(name) for name in np.unique(truth))
    if samples.kind != VOICE:
        samples = _first_coefficients(samples, 500)
    probabilities, tested = np.zeros((len(truth), len(classes))), np.zeros(len(truth), dtype=bool)
    for known, out in held_out_folds(truth, np.array(samples.speakers)):
        learned_from = samples.where(_mask(known, len(truth)) & (learn_variations | (samples.variation == 0)))
        if set(learned_from.emotions) != set(classes):
            continue
        cost = None if samples.kind == VOICE else PAPER_COST
        learned = EmotionClassifier(samples.kind, cost=cost).fit(learned_from)
        probabilities[out], tested[out] = learned.probabilities(samples.features[out]), True
    return probabilities, classes, tested


def _first_coefficients(samples: EmotionSamples, count: int) -> EmotionSamples:
    from dataclasses import replace

    return replace(samples, features=samples.features[:, : 3 + count], kind=f"cepstral:{count}")


def _cells(figures: Judgement) -> str:
    return " | ".join(
        f"{value:.2f}" for value in (figures.accuracy, figures.balanced, figures.brier, figures.calibration)
    )


def _threshold_lines(voices: EmotionSamples) -> list[str]:
    """What the rule "not sure, so neutral" does to speakers held out."""
    if NEUTRAL not in voices.emotions:
        return []
    learned = EmotionClassifier().fit(voices)
    probabilities, truth = learned.machine_.held_out_probabilities_, np.array(voices.emotions)
    best = np.array(learned.emotions)[probabilities.argmax(axis=1)]
    least = np.array([learned.thresholds_[name] for name in best])
    acts = (probabilities.max(axis=1) >= least) & (best != NEUTRAL)
    neutral = truth == NEUTRAL
    return [
        f"Not sure, so neutral (thresholds chosen on the same speakers held out, recordings and variations, who are "
        f"judged against their own means): {(~acts)[neutral].mean():.0%} of neutral speech stays neutral; of other "
        "speech "
        f"{(acts & (best == truth))[~neutral].mean():.0%} gets its emotion, "
        f"{(acts & (best != truth))[~neutral].mean():.0%} another, {(~acts)[~neutral].mean():.0%} none.",
    ]


def _cross_table(corpora: Sequence[LabelledSounds], own: Sequence[EmotionSamples]) -> str:
    """Learned from one corpus, tested on another, on the emotions that both hold."""
    lines = [
        "## Across corpora",
        "",
        "Only emotions that both sides know are tested. `default` is the classifier that ships; on the corpus that it "
        "was learned from its row says nothing. `together`: all recordings of a speaker judged beside one another.",
        "",
        "| learned from | tested on | recordings | told right | mean over emotions | together | Brier | ECE |",
        "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    learned = [("default", default_classifier())]
    if len(corpora) > 1:
        learned += [(c.name, EmotionClassifier().fit(s)) for c, s in zip(corpora, own, strict=True)]
    for name, classifier in learned:
        for corpus, samples in zip(corpora, own, strict=True):
            if name != corpus.name:
                lines.append(_cross_row(name, classifier, corpus.name, samples))
    return "\n".join(lines)


def _cross_row(name: str, classifier: EmotionClassifier, corpus: str, samples: EmotionSamples) -> str:
    shared = [emotion for emotion in classifier.emotions if emotion in samples.emotions]
    tested = samples.where(samples.variation == 0).of_emotions(shared)
    if not len(tested):
        return f"| {name} | {corpus} | 0 | – | – | – | – | – |"
    columns = [classifier.emotions.index(emotion) for emotion in shared]

    def figures(baseline: NDArray[np.float64]) -> Judgement:
        kept = classifier.probabilities(tested.features, baseline)[:, columns]
        return judge(kept / np.maximum(kept.sum(axis=1, keepdims=True), 1e-9), shared, tested.emotions)

    speakers = np.array(tested.speakers)
    beside = np.array([
        classifier.baseline_of(tested.features[(speakers == speaker) & (np.arange(len(tested)) != row)])
        for row, speaker in enumerate(speakers)
    ])  # fmt: skip
    alone = figures(classifier.usual_)
    return (
        f"| {name} | {corpus} | {len(tested)} | {alone.accuracy:.2f} | {alone.balanced:.2f} | "
        f"{figures(beside).accuracy:.2f} | {alone.brier:.2f} | {alone.calibration:.2f} |"
    )
