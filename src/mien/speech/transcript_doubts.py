"""Does the text fit the sound? The aligner always answers, even for a text that nobody said.

Three signs are looked for, with limits calibrated on true and on spoilt transcripts, in quiet and in noise
(docs/tables/noise.md, docs/tables/alignment.md):

* a run of phones that is far less likely than what else could be said there, or phones one after another that are each
  somewhat less likely than they may be, until it adds up (in noise the first alone is rare: few phones are sure);
* words laid on silence;
* speech between two words that the text has no words for.

What cannot be heard for noise is hardly less likely than anything else, so that noise alone raises no doubt; it is
named by a note of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.errors import Note
from mien.core.long_arrays import let_go
from mien.speech.aligned_phone import AlignedPhone
from mien.text.spoken_text import SpokenText

__all__ = ["Misfit", "doubts", "misfits", "noise_below"]

RUN = 7
"""Phones whose scores are averaged."""
LOWEST_RUN_SCORE = -2.6
"""A run that scores lower on average does not fit."""
LOWEST_RUN_SCORE_THROUGH_A_MAP = -4.0
"""The same for a language whose phones the English model hears through a phone map (docs/languages.md)."""
LOWEST_PHONE_SCORE = -8.0
"""Scores are clipped here, so that one odd phone does not condemn its run."""
EACH, SUM = 1.1, 10.0
"""How far above the mean of a poor run a single phone begins to count, and what must come together in a row."""
LOWEST_IN_SUM = 3.4
"""How far below that mean a phone counts at most: one that is odd is not enough."""
QUIET_WORD = 36.0
"""Decibels that the loudest part of a word lies below speech for the word to count as laid on silence."""
OTHER_SPEECH = 0.28
"""Seconds of speech between two words that count as words left out."""
OTHER_IN_NOISE, LOUD_NOISE = 0.31, 9.0
"""The same where noise lies less than so many decibels below the voice: what babbles is speech too."""
NOISY = 15.0
"""Decibels by which noise lies below the voice at most for it to be named."""
_FRAME = 0.02
_BLOCK = 1000  # frames: a long sound is in memory a piece at a time

Kind = Literal["poor fit", "words on silence", "speech without words"]


@dataclass(frozen=True)
class Misfit:
    """A stretch, in seconds, where text and sound do not seem to fit.

    ``first_word`` and ``last_word`` are the numbers of the words in it, both included; -1 where there are none.
    """

    kind: Kind
    start: float
    end: float
    first_word: int = -1
    last_word: int = -1


def doubts(
    audio: Audio, spoken: SpokenText, phones: Sequence[AlignedPhone], lowest: float = LOWEST_RUN_SCORE
) -> tuple[Note, ...]:
    """A note on noise, and a warning for each stretch where the text does not seem to fit the sound."""
    below = noise_below(audio, phones)
    noise = Note(
        "note", f"the sound seems noisy: the noise lies about {below:.0f} dB below the voice, so times are less certain"
    )
    if below < 0:
        noise = Note("warning", "no voice stands out of the noise of the sound: the times are guesses")
    warnings = [Note("warning", _sentence(misfit, spoken)) for misfit in misfits(audio, phones, lowest)]
    return (*([noise] if below < NOISY else []), *warnings)


def noise_below(audio: Audio, phones: Sequence[AlignedPhone]) -> float:
    """Decibels by which the sound in the pauses, or at its quietest, lies below the sound in the words."""
    loudness = _loudness(audio)
    spoken = [(phone.start, phone.end) for phone in phones if phone.word >= 0]
    pauses = [(p.start + _FRAME, p.end - _FRAME) for p in phones if p.word < 0 and p.end - p.start > 6 * _FRAME]
    if not spoken:
        return float("inf")
    quiet = np.median(_parts(loudness, pauses)) if pauses else np.percentile(loudness, 5)
    powers = 10 ** (_parts(loudness, spoken) / 10)
    voice = max(float(powers.mean()) - 10 ** (quiet / 10), 1e-12)
    return float(10 * np.log10(voice) - quiet)


def misfits(audio: Audio, phones: Sequence[AlignedPhone], lowest: float = LOWEST_RUN_SCORE) -> list[Misfit]:
    """Stretches where aligned phones and sound do not seem to fit, in order of time.

    Parameters
    ----------
    audio : Audio
    phones : sequence of AlignedPhone
        As `mien.speech.align.align_words` gives them.
    lowest : float
        Mean score of a run of phones under which it does not fit.
    """
    loudness = _loudness(audio)
    spoken = [phone for phone in phones if phone.word >= 0]
    if not spoken:
        return []
    level = float(np.percentile(_parts(loudness, [(p.start, p.end) for p in spoken]), 75))
    found = (
        _poor_runs(spoken, lowest)
        + _words_on_silence(spoken, loudness, level)
        + _wordless_speech(phones, loudness, level, noise_below(audio, phones))
    )
    return sorted(found, key=lambda misfit: misfit.start)


def _sentence(misfit: Misfit, spoken: SpokenText) -> str:
    stretch = f"between {misfit.start:.2f} s and {misfit.end:.2f} s"
    if misfit.kind == "speech without words":
        return f"there seems to be speech {stretch} that the text has no words for: check the text"
    written = " ".join(spoken.written_for(misfit.first_word, misfit.last_word).split())
    written = written if len(written) <= 60 else written[:59] + "…"
    if misfit.kind == "words on silence":
        return f"the text has words {stretch} ({written!r}) where the sound is silent: check the text"
    return f"the text does not seem to fit the sound {stretch} ({written!r}): check the text"


def _poor_runs(spoken: Sequence[AlignedPhone], lowest: float) -> list[Misfit]:
    scores = np.maximum([phone.score for phone in spoken], LOWEST_PHONE_SCORE)
    lengths = np.array([phone.end - phone.start for phone in spoken])
    run = min(RUN, len(scores))
    sums, times = (np.concatenate([[0.0], np.cumsum(values)]) for values in (scores * lengths, lengths))
    means = (sums[run:] - sums[:-run]) / np.maximum(times[run:] - times[:-run], 1e-9)
    bad = np.zeros(len(scores), dtype=bool)
    for start in np.flatnonzero(means < lowest):
        bad[start : start + run] = True
    bad |= _adding_up(np.maximum([phone.score for phone in spoken], lowest - LOWEST_IN_SUM) - lowest)
    return [
        Misfit("poor fit", spoken[first].start, spoken[last].end, spoken[first].word, spoken[last].word)
        for first, last in _stretches(bad)
    ]


def _adding_up(above: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Phones that together lie too low: of each row of sums that reach `SUM`, from its start to the highest."""
    bad = np.zeros(len(above), dtype=bool)
    total, start, highest = 0.0, 0, 0.0
    for place, short in enumerate(EACH - above):
        if total + short <= 0:
            total, start, highest = 0.0, place + 1, 0.0
            continue
        total += short
        if total > max(highest, SUM):
            highest, bad[start : place + 1] = total, True
    return bad


def _words_on_silence(spoken: Sequence[AlignedPhone], loudness: NDArray[np.float64], level: float) -> list[Misfit]:
    spans: dict[int, tuple[float, float]] = {}
    for phone in spoken:
        spans[phone.word] = (spans.get(phone.word, (phone.start, 0.0))[0], phone.end)
    words = sorted(spans)
    loudest = [_parts(loudness, [spans[word]]).max() for word in words]
    return [
        Misfit("words on silence", spans[words[first]][0], spans[words[last]][1], words[first], words[last])
        for first, last in _stretches(np.array(loudest) < level - QUIET_WORD)
    ]


def _wordless_speech(
    phones: Sequence[AlignedPhone], loudness: NDArray[np.float64], level: float, below: float
) -> list[Misfit]:
    """Where the network hears other speech, unless it is all but silent there: its scores mean little then."""
    least = OTHER_IN_NOISE if below < LOUD_NOISE else OTHER_SPEECH
    return [
        Misfit("speech without words", phone.start, phone.end)
        for phone in phones
        if phone.other >= least - 1e-9
        and np.percentile(_parts(loudness, [(phone.start, phone.end)]), 75) > level - QUIET_WORD
    ]


def _loudness(audio: Audio) -> NDArray[np.float64]:
    """RMS in decibels of each frame of 20 ms; at least one."""
    window = max(1, round(audio.rate * _FRAME))
    frames = max(1, len(audio.samples) // window)
    body = audio.samples[: frames * window].reshape(frames, -1)
    power = np.empty(len(body))
    for start in range(0, len(body), _BLOCK):
        part = body[start : start + _BLOCK]
        power[start : start + _BLOCK] = np.einsum("ij,ij->i", part, part, dtype=np.float64)
        let_go(audio.samples)
    return np.asarray(10.0 * np.log10(power / body.shape[1] + 1e-12))


def _parts(loudness: NDArray[np.float64], spans: Sequence[tuple[float, float]]) -> NDArray[np.float64]:
    """The frames inside some spans of time; at least one each."""
    last = len(loudness) - 1
    pieces = []
    for start, end in spans:
        first = min(int(start / _FRAME), last)
        pieces.append(loudness[first : max(first + 1, int(end / _FRAME))])
    return np.concatenate(pieces)


def _stretches(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of each row of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(first), int(after) - 1) for first, after in zip(edges[::2], edges[1::2], strict=True)]
