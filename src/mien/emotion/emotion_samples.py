"""Labelled recordings as numbers: what the classifier of voices learns from, and what it is judged on."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.errors import InputError, MienError, Note
from mien.core.limits import is_whole
from mien.corpus.labelled_sounds import LabelledSounds
from mien.corpus.workers import each
from mien.formats.sound_files import read_audio
from mien.speech.cepstral_features import cepstral_features
from mien.speech.sound_variations import varied
from mien.speech.voice_features import SpeechFrames, analyse, voice_features

__all__ = ["CEPSTRAL", "VOICE", "EmotionSamples", "emotion_samples", "feature_names", "features_of", "join_samples"]

VOICE = "voice"
"""`mien.speech.voice_features`, which other microphones leave alone."""
CEPSTRAL = "cepstral"
"""The paper's: ``cepstral`` with 500 coefficients, ``cepstral:100`` with 100."""

Progress = Callable[[int, int], None]
_Job = tuple[str, str, int, int]


@dataclass(frozen=True, eq=False)
class EmotionSamples:
    """Features of recordings, one row each.

    Attributes
    ----------
    features : ndarray, shape (samples, features)
    emotions, speakers, names : tuple of str
        Of each sample; where a corpus does not say who speaks, each recording is a speaker of its own.
    variation : ndarray of int, shape (samples,)
        0 is the recording itself, others are variations of it (`mien.speech.sound_variations`).
    kind : str
        Which features.
    notes : tuple of Note
    """

    features: NDArray[np.float64]
    emotions: tuple[str, ...]
    speakers: tuple[str, ...]
    names: tuple[str, ...]
    variation: NDArray[np.int64]
    kind: str
    notes: tuple[Note, ...] = ()

    def __len__(self) -> int:
        return len(self.emotions)

    def where(self, keep: NDArray[np.bool_]) -> EmotionSamples:
        """Only the samples that are marked."""
        index = np.flatnonzero(keep).tolist()

        def picked(values: Sequence[str]) -> tuple[str, ...]:
            return tuple(values[i] for i in index)

        return replace(
            self,
            features=self.features[index],
            emotions=picked(self.emotions),
            speakers=picked(self.speakers),
            names=picked(self.names),
            variation=self.variation[index],
        )

    def of_emotions(self, emotions: Sequence[str]) -> EmotionSamples:
        """Only the samples of these emotions."""
        return self.where(np.isin(self.emotions, list(emotions)))


def join_samples(parts: Sequence[EmotionSamples]) -> EmotionSamples:
    """Samples of several corpora as one; speakers of different corpora stay apart."""
    return EmotionSamples(
        np.concatenate([part.features for part in parts]),
        tuple(name for part in parts for name in part.emotions),
        tuple(f"{number}/{name}" for number, part in enumerate(parts) for name in part.speakers),
        tuple(name for part in parts for name in part.names),
        np.concatenate([part.variation for part in parts]),
        parts[0].kind,
        tuple(note for part in parts for note in part.notes),
    )


@cache
def feature_names() -> tuple[str, ...]:
    """Names of the `VOICE` features, in order."""
    return tuple(voice_features(analyse(Audio.silence(0.5, 16_000))))


def features_of(sound: Audio | SpeechFrames, kind: str) -> NDArray[np.float64]:
    """The features of one sound, shape (features,).

    Raises
    ------
    InputError
        If the kind of features is not known.
    """
    if kind == VOICE:
        frames = analyse(sound) if isinstance(sound, Audio) else sound
        return np.array(list(voice_features(frames).values()))
    name, _, number = kind.partition(":")
    if name != CEPSTRAL or not is_whole(number or "500") or isinstance(sound, SpeechFrames):
        raise InputError(f"features are 'voice', 'cepstral' or 'cepstral:NUMBER', not {kind!r}")
    return cepstral_features(sound, int(number or "500"))


def emotion_samples(
    corpus: LabelledSounds,
    kind: str = VOICE,
    variations: int = 0,
    seed: int = 0,
    workers: int | None = 0,
    progress: Progress | None = None,
    cluster: str | None = None,
) -> EmotionSamples:
    """Read every recording and take its features.

    Parameters
    ----------
    corpus : LabelledSounds
    kind : str
        `VOICE`, or `CEPSTRAL` with the number of coefficients.
    variations : int
        How many variations of each recording stand beside it.
    seed : int
        Of the variations; what one sounds like depends on the seed and the file's name alone.
    workers, cluster
        As in `mien.corpus.workers.each`.
    progress : callable (done, total), optional

    Raises
    ------
    InputError
        If more than half of the recordings cannot be read.
    """
    features_of(Audio.silence(0.1, 16_000), kind)
    sounds = corpus.sounds
    jobs: list[_Job] = [(str(s.path), kind, v, seed) for s in sounds for v in range(variations + 1)]
    found: dict[_Job, NDArray[np.float64]] = {}
    broken: dict[str, str] = {}
    for done, (job, result) in enumerate(each(_sample, jobs, workers, cluster), start=1):
        if isinstance(result, MienError):
            broken[job[0]] = str(result)
        elif isinstance(result, BaseException):
            raise result
        else:
            found[job] = result
        if progress is not None:
            progress(done, len(jobs))
    if 2 * len(broken) > len(sounds):
        raise InputError(
            f"{corpus.name}: {len(broken)} of {len(sounds)} recordings cannot be read: {min(broken.values())}"
        )
    rows = [(found[job], sounds[i // (variations + 1)], job[2]) for i, job in enumerate(jobs) if job[0] not in broken]
    notes = tuple(Note("warning", f"left out: {broken[path]}") for path in sorted(broken))
    return EmotionSamples(
        np.array([row for row, _, _ in rows]),
        tuple(sound.emotion for _, sound, _ in rows),
        tuple((sound.speaker if corpus.speakers else str(sound.path)) for _, sound, _ in rows),
        tuple(str(sound.path) for _, sound, _ in rows),
        np.array([number for _, _, number in rows]),
        kind,
        corpus.notes + notes,
    )


def _sample(job: _Job) -> NDArray[np.float64]:
    path, kind, variation, seed = job
    audio, _ = read_audio(path)
    if variation:
        name = zlib.crc32(Path(path).stem.encode())
        audio = varied(audio, np.random.default_rng([seed, variation, name]))
    return features_of(audio, kind)
