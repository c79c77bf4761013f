"""How near is the live mouth to the truth and to the offline result? A third of docs/tables/live.md; run ``live.py``.

* Truth: the hand-made phones of timit-sample. Nothing was learned from it, but its figures were looked at while
  features, variations and the search were chosen: expect somewhat worse elsewhere. Damaged files are left out.
* Frame-viseme accuracy: share of the frames (30 a second) in which the viseme (13 and rest; a diphthong goes by its
  first) that is shown is that of the hand-made phones at the same instant.
* Closures: the lip opening of the default face (between landmarks 13 and 14, in excess of the resting face), counted by
  `mien.metrics.closure` against the hand-made phones: F1, recall, precision.
* Deviation: of the mouth's channels (root mean square; weights 0..1) and of the 48 mouth landmarks on the default face
  (mm), against what ``mien animate`` makes of the same sound with its text (the default performer, whole). ``same
  model``: against the same speech model (learned curves) over the hand-made phones with no limit ahead: what is lost by
  not knowing the future, if every phone were known as soon as it is said.
* Harmed sound: every third utterance, ``live, 150 ms``; noise is white and its level relative to the mean power of the
  utterance.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from hand_labels import Labelled
from numpy.typing import NDArray
from scipy.signal import butter, fftconvolve, sosfilt
from scipy.spatial import cKDTree

from mien.capture.layouts import load_layout
from mien.core import channels
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.utterance import PAUSE, Utterance
from mien.face.library import load_face
from mien.face.retargeting import basis_at
from mien.metrics.closure import ClosureCounts, closure_counts
from mien.motion.mouth.hand_made_mouth import HandMadeMouth
from mien.motion.mouth.streaming_mouth import StreamingMouth, without_sound
from mien.motion.performer import Performer
from mien.motion.performers import load_performer
from mien.serve.live.animator import LiveAnimator, LiveSettings
from mien.speech.align import align
from mien.speech.recognise import recognise
from mien.speech.streaming_features import RATE as HEARD

RATE = FrameRate.of(30)
LOOK_AHEADS = (0.05, 0.1, 0.15, 0.3)
_MOUTH = [channels.ALL.index(name) for name in channels.MOUTH]
_LIPS = (
    *(61, 146, 91, 181, 84, 17, 314, 405, 321, 375, 291, 409, 270, 269, 267, 0, 37, 39, 40, 185),  # outer lips
    *(78, 95, 88, 178, 87, 14, 317, 402, 318, 324, 308, 415, 310, 311, 312, 13, 82, 81, 80, 191),  # inner lips
    *(152, 175, 199, 200, 148, 377, 176, 400),  # chin
)

Floats = NDArray[np.float64]
Harm = Callable[[Floats, np.random.Generator], Floats]
"""What is done to a sound at 16 kHz."""


@dataclass(frozen=True)
class Shown:
    """What one way of making it shows of one recording: a phone for each frame, and the mouth's channels."""

    labels: list[str]
    values: Floats
    processor: float | None = None  # seconds of processor for each second of sound


class Mouth:
    """The default face's mouth, as far as it is measured."""

    def __init__(self) -> None:
        face, layout = load_face("default"), load_layout("mediapipe-218")
        names = [layout.landmarks[number] for number in (*_LIPS, 13, 14)]
        skin = face.part("skin")
        _, vertices = cKDTree(skin.vertices).query(layout.places[layout.index(names)])
        sites = [(skin.name, int(vertex)) for vertex in vertices]
        self.basis = basis_at(face, sites, channels.ALL)

    def moved(self, values: Floats) -> Floats:
        """Displacements of the 48 landmarks, shape (frames, 48, 3), mm."""
        return np.tensordot(values, self.basis[:, :-2], axes=1)

    def opening(self, values: Floats) -> Floats:
        """Distance of the inner lips beyond that of the resting face, shape (frames,), mm."""
        upper, lower = (np.tensordot(values, self.basis[:, place], axes=1)[:, 1] for place in (-2, -1))
        return np.asarray(upper - lower)


@cache
def performer() -> Performer:
    """The default performer."""
    return load_performer("default")


def visemes(labels: Sequence[str]) -> list[str]:
    """The viseme of each phone."""
    mouth = HandMadeMouth()
    return ["rest" if label == PAUSE else mouth.visemes_of(label)[0] for label in labels]


def labels_of(phones: Sequence[Interval], times: Floats) -> list[str]:
    """The phone at each instant."""
    place = np.searchsorted([phone.start for phone in phones], times + 1e-9, side="right") - 1
    return [phones[p].label if p >= 0 and t < phones[p].end else PAUSE for p, t in zip(place, times, strict=True)]


def live(item: Labelled, look_ahead: float, harm: Harm = lambda samples, _: samples) -> Shown:
    """What ``mien live`` shows, without its clock."""
    animator = LiveAnimator(performer(), LiveSettings(look_ahead, RATE))
    samples = harm(item.audio.resampled(HEARD).samples.astype(np.float64), np.random.default_rng(1))
    frames = RATE.frames_covering(item.audio.duration)
    padded = np.concatenate([samples, np.full(HEARD, samples[-1])])
    given, labels, values = 0, [], []
    began = time.process_time()
    for number in range(frames):
        upto = round((RATE.time_of(number) + look_ahead) * HEARD)
        animator.hear(padded[given:upto])
        given = upto
        animator.frame(RATE.time_of(number))
        values.append(animator.spoken)
        phone = animator.phones.at(RATE.time_of(number))
        labels.append(phone.label if phone else PAUSE)
    spent = (time.process_time() - began) / item.audio.duration
    return Shown(labels, np.array(values), spent)


class Known:
    """The phones as a person marked them, each known as soon as it begins."""

    def __init__(self) -> None:
        self.mouth = without_sound(performer().mouth)

    def whole(self, item: Labelled) -> Floats:
        """Channels with no limit ahead."""
        return np.asarray(self.mouth.perform(_utterance(item, item.phones), RATE).values)

    def streamed(self, item: Labelled, look_ahead: float) -> Floats:
        """Channels with the phones that begin within the look-ahead."""
        streaming, found = StreamingMouth(self.mouth, RATE), []
        for number in range(RATE.frames_covering(item.audio.duration)):
            now = RATE.time_of(number)
            end = now + look_ahead
            known = tuple(Interval(p.start, min(p.end, end), p.label) for p in item.phones if p.start < end)
            found.append(streaming.frame(now, Tier("phones", known))[0])
        return np.array(found)


def _utterance(item: Labelled, phones: Sequence[Interval]) -> Utterance:
    return Utterance("", item.audio, Tier("words", ()), Tier("phones", tuple(phones)), "en-US", "aligned")


def offline(item: Labelled, utterance: Callable[[Labelled], Utterance]) -> Shown:
    """What ``mien animate`` shows: the default performer's mouth over the whole sound."""
    made = utterance(item)
    motion = performer().mouth.perform(made, RATE)
    return Shown(labels_of(made.phones.intervals, RATE.times(len(motion.values))), motion.values)


OFFLINE: dict[str, Callable[[Labelled], Utterance]] = {
    "offline, its true text, aligned": lambda item: align(item.audio, " ".join(word.label for word in item.words)),
    "offline, no text, hama": lambda item: recognise(item.audio, recogniser="hama"),
    "offline, no text, pocketsphinx": lambda item: recognise(item.audio, recogniser="pocketsphinx"),
}


def section(items: list[Labelled], damaged: int) -> Iterator[str]:
    """The lines of the table."""
    mouth, known = Mouth(), Known()
    speakers = sorted({item.name.rpartition("-")[0] for item in items})
    rows: dict[str, list[Shown]] = {}
    for name, utterance in OFFLINE.items():
        rows[name] = [offline(item, utterance) for item in items]
    for look_ahead in LOOK_AHEADS:
        rows[f"**live, {look_ahead * 1000:g} ms**"] = [live(item, look_ahead) for item in items]
    reference = rows["offline, its true text, aligned"]
    yield "## Against hand-made phones and against the offline result\n"
    yield (
        f"{len(items)} utterances of timit-sample, {len(speakers)} speakers ({damaged} damaged files left out); "
        "definitions stand at the head of `benchmarks/live_accuracy.py`. Processor: of one core, for the whole way "
        "from sound to channels.\n"
    )
    yield (
        "| what is shown | frames with the right viseme "
        "| closures F1 (recall, precision) | channels, RMS from offline | landmarks, mm from offline | processor |"
    )
    yield "| --- | --- | --- | --- | --- | --- |"
    for name, shown in rows.items():
        yield _row(name, shown, reference, items, mouth)
    yield "\nThe learned curves alone, over the hand-made phones: limited look-ahead against none.\n"
    yield "| look-ahead | channels, RMS | landmarks, mm |"
    yield "| --- | --- | --- |"
    for look_ahead in LOOK_AHEADS:
        pairs = [(known.streamed(item, look_ahead), known.whole(item)) for item in items]
        yield f"| {look_ahead * 1000:g} ms | {_rms(pairs):.4f} | {_millimetres(pairs, mouth):.2f} |"
    yield "\nHarmed sound.\n"
    yield "| sound | frames with the right viseme | closures F1 (recall, precision) |"
    yield "| --- | --- | --- |"
    for name, harm in harmed().items():
        heard = [live(item, 0.15, harm) for item in items[::3]]
        yield f"| {name} | {_right(heard, items[::3])} | {_closures(heard, items[::3], mouth)} |"


def harmed() -> dict[str, Harm]:
    """The ways in which sounds are harmed."""

    def noisy(decibels: float) -> Harm:
        return lambda x, random: x + random.normal(0, x.std() * 10 ** (-decibels / 20), len(x))

    def room(x: Floats, random: np.random.Generator) -> Floats:
        tail = random.normal(size=6400) * np.exp(-6.9 * np.arange(6400) / 6400)
        tail[0] = 3.0 * np.sqrt((tail[1:] ** 2).sum())
        return np.asarray(fftconvolve(x, tail / tail[0])[: len(x)])

    band = butter(4, (300, 3400), "band", fs=HEARD, output="sos")
    return {
        "as it is": lambda x, _: x,
        "noise 20 dB below": noisy(20),
        "noise 10 dB below": noisy(10),
        "noise 5 dB below": noisy(5),
        "30 dB quieter, in steps of 16 bit": lambda x, _: np.round(x * 10**-1.5 * 32768) / 32768,
        "clipped at a tenth of its peak": lambda x, _: np.clip(x, -0.1 * np.abs(x).max(), 0.1 * np.abs(x).max()),
        "through a telephone": lambda x, _: np.asarray(sosfilt(band, x)),
        "in a room (0.4 s)": room,
        "offset by 0.1": lambda x, _: x + 0.1,
    }


def _row(name: str, shown: list[Shown], reference: list[Shown], items: list[Labelled], mouth: Mouth) -> str:
    pairs = [(one.values, other.values) for one, other in zip(shown, reference, strict=True)]
    own = shown is reference
    return (
        f"| {name} | {_right(shown, items)} | {_closures(shown, items, mouth)} | "
        f"{'' if own else f'{_rms(pairs):.4f}'} | {'' if own else f'{_millimetres(pairs, mouth):.2f}'} | "
        f"{_share([one.processor for one in shown])} |"
    )


def _right(shown: list[Shown], items: list[Labelled]) -> str:
    """Share of frames with the right viseme."""
    same: list[bool] = []
    for one, item in zip(shown, items, strict=True):
        true = visemes(labels_of(item.phones, RATE.times(len(one.values))))
        same += [a == b for a, b in zip(visemes(one.labels), true, strict=True)]
    return f"{np.mean(same):.1%}"


def _closures(shown: list[Shown], items: list[Labelled], mouth: Mouth) -> str:
    """How well closures are found: F1, recall and precision."""
    counts = ClosureCounts(0, 0, 0, 0)
    for one, item in zip(shown, items, strict=True):
        times = RATE.times(len(one.values))
        counts += closure_counts(mouth.opening(one.values), times, Tier("phones", item.phones))
    return f"{counts.f1:.2f} ({counts.recall:.2f}, {counts.precision:.2f})"


def _share(processor: list[float | None]) -> str:
    known = [share for share in processor if share is not None]
    return f"{np.mean(known):.0%}" if known else ""


def _rms(pairs: list[tuple[Floats, Floats]]) -> float:
    return float(np.sqrt(np.concatenate([((a - b)[:, _MOUTH] ** 2).ravel() for a, b in pairs]).mean()))


def _millimetres(pairs: list[tuple[Floats, Floats]], mouth: Mouth) -> float:
    squared = [(mouth.moved(a - b) ** 2).sum(axis=2).ravel() for a, b in pairs]
    return float(np.sqrt(np.concatenate(squared).mean()))
