"""Which emotion is in a voice (Cao et al. 2005): a support vector machine on features of the sound, with probabilities.

Cao et al. 2005, section 6, on features that mean the same under other microphones (`mien.speech.voice_features`);
the paper's own are an option. The default classifier is learned from acted German sentences
(``docs/tables/emotion.md``). It knows neither "surprised" nor "frustrated" nor "contempt" and never returns them.

A classifier file is an ``.npz`` of plain arrays and one JSON text; nothing in it is code.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset
from mien.core.audio import Audio
from mien.core.border import reading
from mien.core.emotions import emotions as emotion_tables
from mien.core.errors import InputError
from mien.core.files import replace_when_complete
from mien.core.limits import load_arrays, read_bytes, read_member
from mien.core.plain_text import parsed_json
from mien.emotion.emotion_samples import VOICE, EmotionSamples, feature_names, features_of
from mien.emotion.support_vectors import Kernel, SupportVectors
from mien.speech.voice_features import STEP, SpeechFrames, analyse

__all__ = ["NEUTRAL", "EmotionClassifier", "EmotionReading", "default_classifier", "load_classifier"]

NEUTRAL = "neutral"
FORMAT, VERSION = "mien-emotion-classifier", 2
LONGEST_WHOLE = 3.5
"""Seconds of speech that are looked at as a whole; more is looked at in windows."""
WINDOW, WINDOW_STEP = 2.5, 0.5
LEAST_SPEECH = 0.4
"""Seconds with speech below which nothing is said about a voice."""
FEW_TOGETHER = 3
"""As many other sounds of a speaker move the baseline half as far as a great many would."""
FROM_NEUTRAL = 0.4
"""How far the middle of a speaker's moods lies from neutral on the way to the mean of all emotions. Set by hand."""
MOST_NEUTRAL_WRONG, MOST_WRONG = 0.004, 0.1
"""Of neutral recordings of speakers held out so many at most get an emotion; of what gets it so many may be another."""
_CEPSTRUM = "mfcc"
"""Features with this in their names are left out: they tell speakers, rooms and languages better than moods."""
COSTS = {"linear": 0.003, "radial": 0.5}
WEAKER = 0.5
"""Actors of a corpus act hard: every recording is learned a second time at so much of its way from neutral."""
_GRID = np.linspace(0.3, 0.99, 70).round(3)
_RIDGE = 100.0
_Array = NDArray[np.float64]
_DATE = (1980, 1, 1, 0, 0, 0)


@dataclass(frozen=True)
class EmotionReading:
    """What was read from a voice.

    Attributes
    ----------
    probabilities : mapping of str to float
        Of every emotion that the classifier knows; they sum to one.
    threshold : float
        The least probability at which a face acts on an emotion.
    activation : float
        How stirred the voice is, 0 (flat, slow, soft) to 1.
    seconds : float
        How much speech it rests on.
    """

    probabilities: Mapping[str, float]
    threshold: float
    activation: float
    seconds: float

    @property
    def most_likely(self) -> str:
        """The emotion of the highest probability, however low that is."""
        return max(self.probabilities, key=lambda name: self.probabilities[name])

    @property
    def is_sure(self) -> bool:
        """Whether the most likely emotion reaches the threshold."""
        return self.seconds >= LEAST_SPEECH and self.probabilities[self.most_likely] >= self.threshold

    @property
    def emotion(self) -> str:
        """The most likely emotion; neutral where that is not sure."""
        return self.most_likely if self.is_sure else NEUTRAL

    @property
    def intensity(self) -> float:
        """How strongly a face should show it, 0.4 to 1; 0 for neutral.

        Rises with the activation; for an emotion of little activation (sad) it falls with it. A rule, not learned.
        """
        if self.emotion == NEUTRAL:
            return 0.0
        quiet = emotion_tables()[self.emotion]["arousal"] < emotion_tables()[NEUTRAL]["arousal"]
        return 0.4 + 0.6 * (1 - self.activation if quiet else self.activation)


class EmotionClassifier:
    """Emotion from the voice, judged against what is usual for its speaker.

    A voice is looked at as its distance from a baseline: the middle of the speaker's moods, as far as it is known, and
    the usual voice of all speakers that were learned from, for the rest (`baseline_of`).

    Parameters
    ----------
    features : str
        `mien.emotion.emotion_samples.VOICE`, or ``"cepstral:500"`` (the paper's; it knows no baseline).
    kernel : {"radial", "linear"}, optional
        Left out: linear for voices (a plane carries over to other corpora where a curved border does not).
    cost : float, optional
        libsvm's C; `COSTS` without.

    Attributes
    ----------
    machine_ : SupportVectors
        On the distances from the baseline.
    columns_ : ndarray of int, shape (used,)
        Which features it looks at.
    usual_ : ndarray, shape (features,)
        The baseline of a speaker of whom nothing else was heard.
    from_neutral_ : ndarray, shape (features,)
        From neutral to the mean of all emotions.
    activation_ : ndarray, shape (used + 1,)
        Linear weights of the activation on scaled features, and a constant.
    thresholds_ : dict of str to float
        Of each emotion, chosen on held-out speakers, see `fit`.
    about_ : mapping of str to str
        What it was learned from.
    """

    def __init__(self, features: str = VOICE, kernel: Kernel | None = None, cost: float | None = None) -> None:
        self.features = features
        self.kernel: Kernel = kernel or ("linear" if features == VOICE else "radial")
        self.cost = cost if cost is not None else COSTS[self.kernel]

    def fit(self, samples: EmotionSamples, about: Mapping[str, str] | None = None) -> Self:
        """Learn from samples of several speakers, each less the mean of its speaker's emotions, and again weaker.

        A wrong face is worse than none: an emotion's threshold is the lowest at which few enough neutral recordings of
        speakers held out get it (`MOST_NEUTRAL_WRONG`), and few enough of those that get it have another
        (`MOST_WRONG`).

        Raises
        ------
        InputError
            If the samples hold fewer than two emotions, or other features than the classifier's.
        """
        if samples.kind != self.features:
            raise InputError(f"a classifier of {self.features!r} features cannot learn from {samples.kind!r} ones")
        own = self.features == VOICE
        names = feature_names() if own else ("",) * samples.features.shape[1]
        self.columns_ = np.flatnonzero([_CEPSTRUM not in name for name in names])
        self.usual_, distances = _beside_speakers(samples) if own else (np.zeros(len(names)), samples.features)
        neutral = np.array(samples.emotions) == NEUTRAL
        self.from_neutral_ = -distances[neutral].mean(axis=0) if own and neutral.any() else np.zeros(len(names))
        self.machine_ = SupportVectors(self.kernel, self.cost, "spread" if own else "range", balanced=own)
        taught = _with_weaker(samples, distances) if own else (distances, samples.emotions, samples.speakers)
        self.machine_.fit(taught[0][:, self.columns_], *taught[1:])
        self.machine_.held_out_probabilities_ = self.machine_.held_out_probabilities_[: len(samples)]
        self.thresholds_ = _thresholds(self.machine_, samples.emotions)
        scaled = self.machine_.scaled(distances[:, self.columns_])
        self.activation_ = _activation_weights(scaled, samples.emotions)
        self.about_ = dict(about or {})
        return self

    @property
    def emotions(self) -> tuple[str, ...]:
        """The emotions it tells apart, sorted."""
        return self.machine_.classes_

    def baseline_of(self, others: _Array, neutral: bool = False, weight: float | None = None) -> _Array:
        """What is usual for a speaker, from other sounds of theirs; shape (features,).

        Parameters
        ----------
        others : ndarray, shape (sounds, features)
            In any moods; or all without emotion, with ``neutral``.
        weight : float, optional
            As how many sounds they count; by default as many as they are.
        """
        weight = len(others) if weight is None else weight
        if not len(others) or self.features != VOICE:
            return self.usual_
        middle = others.mean(axis=0) + (FROM_NEUTRAL * self.from_neutral_ if neutral else 0.0)
        return np.asarray((weight * middle + FEW_TOGETHER * self.usual_) / (weight + FEW_TOGETHER))

    def probabilities(self, features: _Array, baseline: _Array | None = None) -> _Array:
        """Of every emotion, shape (sounds, emotions), from features (sounds, features) and a baseline.

        The baseline has the shape (features,), or one row for each sound; None: `usual_`.
        """
        return self.machine_.probabilities(self._distances(features, baseline))

    def activations(self, features: _Array, baseline: _Array | None = None) -> _Array:
        """How stirred voices are, 0 to 1, shape (sounds,); arguments as for `probabilities`."""
        scaled = self.machine_.scaled(self._distances(features, baseline))
        return np.asarray(np.clip(scaled @ self.activation_[:-1] + self.activation_[-1], 0.0, 1.0))

    def _distances(self, features: _Array, baseline: _Array | None) -> _Array:
        return np.asarray((features - (self.usual_ if baseline is None else baseline))[:, self.columns_])

    def read(self, audio: Audio, baseline: Sequence[Audio] = ()) -> EmotionReading:
        """What emotion is in a sound, as a whole.

        A sound with more than a few seconds of speech is read in windows, whose probabilities are averaged.

        Parameters
        ----------
        audio : Audio
        baseline : sequence of Audio
            Recordings of the same speaker without emotion.

        Examples
        --------
        >>> reading = default_classifier().read(Audio.silence(1.0, 16_000))
        >>> reading.emotion, reading.is_sure
        ('neutral', False)
        """
        return self._read(audio, self.neutral_baseline(baseline))

    def neutral_baseline(self, sounds: Sequence[Audio]) -> _Array:
        """The baseline of a speaker from recordings without emotion; those without speech do not count."""
        found = [features for features, spoken in map(self._heard, sounds) if spoken >= LEAST_SPEECH]
        return self.baseline_of(np.array(found), neutral=True)

    def read_together(self, sounds: Sequence[Audio]) -> list[EmotionReading]:
        """What emotion is in each of several sounds of one speaker, each judged beside the others.

        The mean of the others is taken for what is usual, the more the more there are. With sounds of a single mood
        this goes wrong.
        """
        found = [self._heard(sound) for sound in sounds]
        heard = [features for features, spoken in found if spoken >= LEAST_SPEECH]
        readings, number = [], 0
        for sound, (_, spoken) in zip(sounds, found, strict=True):
            others = heard[:number] + heard[number + 1 :] if spoken >= LEAST_SPEECH else heard
            number += spoken >= LEAST_SPEECH
            readings.append(self._read(sound, self.baseline_of(np.array(others))))
        return readings

    def _heard(self, audio: Audio) -> tuple[_Array, float]:
        """Features of a whole sound, and its seconds of speech."""
        frames = analyse(audio)
        return features_of(frames if self.features == VOICE else audio, self.features), frames.seconds_of_speech

    def _read(self, audio: Audio, baseline: _Array) -> EmotionReading:
        frames = analyse(audio)
        spoken = frames.seconds_of_speech
        if spoken < LEAST_SPEECH:
            silent = np.array([[float(name == NEUTRAL) for name in self.emotions]])
            return self.reading(silent, np.zeros(1), spoken)
        if self.features != VOICE:
            features = features_of(audio, self.features)[None]
        else:
            pieces = [frames] if spoken <= LONGEST_WHOLE else [piece for _, piece in windows(frames)]
            features = np.array([features_of(piece, VOICE) for piece in pieces])
        return self.reading(self.probabilities(features, baseline), self.activations(features, baseline), spoken)

    def reading(self, probabilities: _Array, activation: _Array, spoken: float) -> EmotionReading:
        """The mean of what was found in pieces of one voice.

        Parameters
        ----------
        probabilities : ndarray, shape (pieces, emotions)
        activation : ndarray, shape (pieces,)
        spoken : float
            Seconds of speech.
        """
        mean = probabilities.mean(axis=0)
        mean = mean if mean.sum() > 0 else np.ones(len(mean))  # nothing heard by a classifier that knows no neutral
        named = {name: float(p) for name, p in zip(self.emotions, mean / mean.sum(), strict=True)}
        threshold = self.thresholds_[max(named, key=lambda name: named[name])]
        return EmotionReading(named, threshold, float(activation.mean()), spoken)

    def save(self, path: str | Path) -> None:
        """Write the classifier; the same classifier gives the same bytes.

        Raises
        ------
        OutputError
            If it cannot be written.
        """
        head = {
            "format": FORMAT,
            "version": VERSION,
            "features": self.features,
            "kernel": self.kernel,
            "cost": self.cost,
            "thresholds": self.thresholds_,
            "about": self.about_,
        }
        arrays = {
            **self.machine_.to_arrays(),
            "activation": self.activation_,
            "columns": self.columns_.astype(np.int32),
            "usual": self.usual_,
            "from_neutral": self.from_neutral_,
        }
        with (
            replace_when_complete(path) as unfinished,
            zipfile.ZipFile(unfinished, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive,
        ):
            archive.writestr(zipfile.ZipInfo("classifier.json", _DATE), json.dumps(head, indent=1, sort_keys=True))
            for name, array in sorted(arrays.items()):
                stream = io.BytesIO()
                np.lib.format.write_array(stream, np.asarray(array), allow_pickle=False)
                info = zipfile.ZipInfo(f"{name}.npy", _DATE)
                info.compress_type = zipfile.ZIP_DEFLATED
                archive.writestr(info, stream.getvalue())


def windows(frames: SpeechFrames) -> list[tuple[float, SpeechFrames]]:
    """Overlapping stretches with enough speech in them, each with its middle in seconds of the sound."""
    end = frames.start + STEP * len(frames)
    starts = np.arange(frames.start, max(end - WINDOW, frames.start) + WINDOW_STEP, WINDOW_STEP)
    found = [(float(start + WINDOW / 2), frames.between(start, start + WINDOW)) for start in starts]
    spoken = [pair for pair in found if pair[1].seconds_of_speech >= LEAST_SPEECH]
    return spoken or [((frames.start + end) / 2, frames)]


def load_classifier(path: str | Path) -> EmotionClassifier:
    """Read a classifier that `EmotionClassifier.save` wrote.

    Raises
    ------
    InputError
        If the file is missing or is none.
    """
    return _read(read_bytes(path), str(path))


def _read(content: bytes, name: str) -> EmotionClassifier:
    with reading(name, "a classifier made by 'mien emotion-train'"):
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            head = parsed_json(read_member(archive, "classifier.json", name))
            if head.get("format") != FORMAT:
                raise KeyError("format")
            if head["version"] > VERSION:
                raise InputError(f"{name}: was written by a newer mien (version {head['version']} of the format)")
        arrays = load_arrays(io.BytesIO(content), name, only=lambda member: not member.endswith(".json"))
        made = EmotionClassifier(head["features"], head["kernel"], float(head["cost"]))
        made.machine_, made.about_ = SupportVectors.from_arrays(arrays), head["about"]
        made.activation_ = arrays["activation"]
        count = len(made.activation_) - 1
        # Version 1 had one threshold and knew no baseline.
        made.thresholds_ = head.get("thresholds") or dict.fromkeys(made.emotions, float(head["threshold"]))
        made.columns_ = arrays.get("columns", np.arange(count))
        made.usual_ = arrays.get("usual", np.zeros(count))
        made.from_neutral_ = arrays.get("from_neutral", np.zeros(count))
        return made


@lru_cache(maxsize=1)
def default_classifier() -> EmotionClassifier:
    """The classifier that ships: learned from the Berlin Database of Emotional Speech."""
    return _read(asset("emotions/voice.npz").read_bytes(), "the default classifier")


def _activation_weights(scaled: NDArray[np.float64], emotions: tuple[str, ...]) -> NDArray[np.float64]:
    """Ridge regression from features to the arousal that the emotions' names stand for (a hand-made table)."""
    known = emotion_tables()
    target = np.array([float(known[name]["arousal"]) for name in emotions])
    middle = float(target.mean())
    gram = scaled.T @ scaled + _RIDGE * np.eye(scaled.shape[1])
    return np.append(np.linalg.solve(gram, scaled.T @ (target - middle)), middle)


def _beside_speakers(samples: EmotionSamples) -> tuple[_Array, _Array]:
    """The mean of all emotions, and every sample less that of its own speaker, shapes (features,), (samples, features).

    A speaker of one emotion alone is compared with everybody: nothing tells the speaker from the mood.
    """
    emotions, speakers = np.array(samples.emotions), np.array(samples.speakers)
    plain = samples.variation == 0

    def middle(of: NDArray[np.bool_]) -> _Array:
        means = [samples.features[of & (emotions == name)].mean(axis=0) for name in np.unique(emotions[of])]
        return np.asarray(np.mean(means, axis=0))

    usual = middle(plain)
    distances = samples.features - usual
    for speaker in np.unique(speakers):
        theirs = speakers == speaker
        if len(np.unique(emotions[theirs & plain])) > 1:
            distances[theirs] = samples.features[theirs] - middle(theirs & plain)
    return usual, distances


def _with_weaker(samples: EmotionSamples, distances: _Array) -> tuple[_Array, tuple[str, ...], tuple[str, ...]]:
    """Distances, emotions and speakers of the samples, and after them of the same acted at `WEAKER` of their strength.

    These lie on the line from their speaker's neutral middle; speakers who were never neutral have none.
    """
    emotions, speakers = np.array(samples.emotions), np.array(samples.speakers)
    rows, names, groups = [distances], [emotions], [speakers]
    for speaker in np.unique(speakers):
        theirs = speakers == speaker
        calm, felt = theirs & (emotions == NEUTRAL), theirs & (emotions != NEUTRAL)
        if calm.any() and felt.any():
            middle = distances[calm].mean(axis=0)
            rows.append(middle + WEAKER * (distances[felt] - middle))
            names.append(emotions[felt])
            groups.append(speakers[felt])
    return np.concatenate(rows), tuple(np.concatenate(names).tolist()), tuple(np.concatenate(groups).tolist())


def _thresholds(machine: SupportVectors, emotions: Sequence[str]) -> dict[str, float]:
    """See `EmotionClassifier.fit`; 0 for neutral, and for all where nothing neutral was recorded."""
    truth, names = np.array(emotions), np.array(machine.classes_)
    if NEUTRAL not in machine.classes_:
        return dict.fromkeys(machine.classes_, 0.0)
    probabilities = machine.held_out_probabilities_
    top, best, neutral = probabilities.max(axis=1), names[probabilities.argmax(axis=1)], truth == NEUTRAL

    def lowest(name: str) -> float:
        for value in _GRID:
            given = (best == name) & (top >= value)
            wrong = given & ~neutral & (truth != name)
            if given[neutral].mean() <= MOST_NEUTRAL_WRONG and wrong.sum() <= MOST_WRONG * max(given.sum(), 1):
                return float(value)
        return float(_GRID[-1])

    return {name: 0.0 if name == NEUTRAL else lowest(name) for name in machine.classes_}
