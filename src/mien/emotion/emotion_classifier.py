"""Which emotion is in a voice (SPEC B8): a support vector machine on features of the sound, with probabilities.

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
from importlib.resources import files
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.border import reading
from mien.core.errors import InputError
from mien.core.files import replace_when_complete
from mien.core.limits import load_arrays, read_bytes, read_member
from mien.core.poses import read_table
from mien.emotion.emotion_samples import VOICE, EmotionSamples, features_of
from mien.emotion.support_vectors import Kernel, SupportVectors
from mien.speech.voice_features import STEP, SpeechFrames, analyse

__all__ = ["NEUTRAL", "EmotionClassifier", "EmotionReading", "default_classifier", "load_classifier"]

NEUTRAL = "neutral"
FORMAT, VERSION = "mien-emotion-classifier", 1
LONGEST_WHOLE = 3.5
"""Seconds of speech that are looked at as a whole; more is looked at in windows."""
WINDOW, WINDOW_STEP = 2.5, 0.5
LEAST_SPEECH = 0.4
"""Seconds with speech below which nothing is said about a voice."""
FEW_TOGETHER = 8
"""As many sounds judged together move each other half as far as a great many would."""
_RIDGE = 100.0
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
        quiet = _arousal()[self.emotion] < _arousal()[NEUTRAL]
        return 0.4 + 0.6 * (1 - self.activation if quiet else self.activation)


class EmotionClassifier:
    """Emotion from the voice.

    Parameters
    ----------
    features : str
        `mien.emotion.emotion_samples.VOICE`, or ``"cepstral:500"`` (the paper's).
    kernel : {"radial", "linear"}
    cost : float
        libsvm's C.

    Attributes
    ----------
    machine_ : SupportVectors
    activation_ : ndarray, shape (features + 1,)
        Linear weights of the activation on scaled features, and a constant.
    threshold_ : float
        Chosen on held-out speakers, see `fit`.
    about_ : mapping of str to str
        What it was learned from.
    """

    def __init__(self, features: str = VOICE, kernel: Kernel = "radial", cost: float = 1.0) -> None:
        self.features, self.kernel, self.cost = features, kernel, cost

    def fit(self, samples: EmotionSamples, about: Mapping[str, str] | None = None) -> Self:
        """Learn from samples of several speakers.

        The threshold below which a voice counts as neutral is chosen on speakers held out. A wrong face is worse than
        none: of neutral recordings the share left neutral counts, of others the share given their emotion less the
        share given another.

        Raises
        ------
        InputError
            If the samples hold fewer than two emotions, or other features than the classifier's.
        """
        if samples.kind != self.features:
            raise InputError(f"a classifier of {self.features!r} features cannot learn from {samples.kind!r} ones")
        own = self.features == VOICE
        self.machine_ = SupportVectors(self.kernel, self.cost, "spread" if own else "range", balanced=own)
        self.machine_.fit(samples.features, samples.emotions, samples.speakers)
        self.threshold_ = _best_threshold(self.machine_, samples)
        self.activation_ = _activation_weights(self.machine_.scaled(samples.features), samples.emotions)
        self.about_ = dict(about or {})
        return self

    @property
    def emotions(self) -> tuple[str, ...]:
        """The emotions it tells apart, sorted."""
        return self.machine_.classes_

    def read(self, audio: Audio) -> EmotionReading:
        """What emotion is in a sound, as a whole.

        A sound with more than a few seconds of speech is read in windows, whose probabilities are averaged.

        Examples
        --------
        >>> reading = default_classifier().read(Audio.silence(1.0, 16_000))
        >>> reading.emotion, reading.is_sure
        ('neutral', False)
        """
        frames = analyse(audio)
        spoken = float(frames.active.sum() * STEP)
        if spoken < LEAST_SPEECH:
            return self._unheard(spoken)
        if self.features != VOICE:
            return self._reading(*self._judge(features_of(audio, self.features)[None]), spoken)
        pieces = [frames] if spoken <= LONGEST_WHOLE else [piece for _, piece in windows(frames)]
        return self._reading(*self.judge(pieces), spoken)

    def read_together(self, sounds: Sequence[Audio]) -> list[EmotionReading]:
        """What emotion is in each of several sounds of one speaker (or one studio), each judged beside the others.

        The sounds' mean is moved towards the mean of what was learned, the further the more sounds there are: what all
        of them share is then the speaker and the room, not the mood. With sounds of a single mood this goes wrong.
        """
        analysed = [analyse(sound) for sound in sounds]
        spoken = [float(frames.active.sum() * STEP) for frames in analysed]
        heard = [i for i, seconds in enumerate(spoken) if seconds >= LEAST_SPEECH]
        readings = [self._unheard(seconds) for seconds in spoken]
        if heard:
            seen = [analysed[i] if self.features == VOICE else sounds[i] for i in heard]
            features = np.array([features_of(one, self.features) for one in seen])
            probabilities, activation = self._judge(self.beside_one_another(features))
            for row, i in enumerate(heard):
                readings[i] = self._reading(probabilities[row : row + 1], activation[row : row + 1], spoken[i])
        return readings

    def beside_one_another(self, features: NDArray[np.float64]) -> NDArray[np.float64]:
        """Features of several sounds, shape (sounds, features), their mean moved towards that of what was learned."""
        share = len(features) / (len(features) + FEW_TOGETHER)
        return np.asarray(features + share * (self.machine_.centre_ - features.mean(axis=0)))

    def _unheard(self, spoken: float) -> EmotionReading:
        """Where there is no speech to speak of: surely nothing but neutral."""
        return self._reading(np.array([[float(name == NEUTRAL) for name in self.emotions]]), np.zeros(1), spoken)

    def judge(self, pieces: list[SpeechFrames]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Probabilities (pieces, emotions) and activations (pieces,) of stretches of speech."""
        return self._judge(np.array([features_of(piece, self.features) for piece in pieces]))

    def _judge(self, features: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        scaled = self.machine_.scaled(features)
        activation = np.clip(scaled @ self.activation_[:-1] + self.activation_[-1], 0.0, 1.0)
        return self.machine_.probabilities(features), np.asarray(activation)

    def _reading(
        self, probabilities: NDArray[np.float64], activation: NDArray[np.float64], spoken: float
    ) -> EmotionReading:
        mean = probabilities.mean(axis=0)
        mean = mean if mean.sum() > 0 else np.ones(len(mean))  # nothing heard by a classifier that knows no neutral
        named = {name: float(p) for name, p in zip(self.emotions, mean / mean.sum(), strict=True)}
        return EmotionReading(named, self.threshold_, float(activation.mean()), spoken)

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
            "threshold": self.threshold_,
            "about": self.about_,
        }
        arrays = {**self.machine_.to_arrays(), "activation": self.activation_}
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
    spoken = [pair for pair in found if pair[1].active.sum() * STEP >= LEAST_SPEECH]
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
            head = json.loads(read_member(archive, "classifier.json", name))
            if head.get("format") != FORMAT:
                raise KeyError("format")
            if head["version"] > VERSION:
                raise InputError(f"{name}: was written by a newer mien (version {head['version']} of the format)")
        arrays = load_arrays(io.BytesIO(content), name, only=lambda member: not member.endswith(".json"))
        made = EmotionClassifier(head["features"], head["kernel"], float(head["cost"]))
        made.threshold_, made.about_ = float(head["threshold"]), head["about"]
        made.machine_ = SupportVectors.from_arrays(arrays)
        made.activation_ = arrays["activation"]
        return made


@lru_cache(maxsize=1)
def default_classifier() -> EmotionClassifier:
    """The classifier that ships: learned from the Berlin Database of Emotional Speech."""
    return _read(files("mien").joinpath("assets", "emotions", "voice.npz").read_bytes(), "the default classifier")


@lru_cache(maxsize=1)
def _arousal() -> dict[str, float]:
    return {name: float(value) for name, value in read_table("arousal.toml")["arousal"].items()}


def _activation_weights(scaled: NDArray[np.float64], emotions: tuple[str, ...]) -> NDArray[np.float64]:
    """Ridge regression from features to the arousal that the emotions' names stand for (an authored table)."""
    target = np.array([_arousal()[name] for name in emotions])
    middle = float(target.mean())
    gram = scaled.T @ scaled + _RIDGE * np.eye(scaled.shape[1])
    return np.append(np.linalg.solve(gram, scaled.T @ (target - middle)), middle)


def _best_threshold(machine: SupportVectors, samples: EmotionSamples) -> float:
    """See `EmotionClassifier.fit`; 0 where nothing neutral was recorded."""
    truth = np.array(samples.emotions)
    if NEUTRAL not in machine.classes_:
        return 0.0
    probabilities = machine.held_out_probabilities_
    top, best = probabilities.max(axis=1), np.array(machine.classes_)[probabilities.argmax(axis=1)]
    neutral = truth == NEUTRAL
    right = (best == truth) & ~neutral

    def worth(threshold: float) -> float:
        acts = (top >= threshold) & (best != NEUTRAL)
        wrong = acts & ~right
        return float((~acts)[neutral].mean() + (acts & right)[~neutral].mean() - wrong[~neutral].mean())

    grid = np.linspace(0, 0.95, 96)
    return float(grid[np.argmax([worth(value) for value in grid])])
