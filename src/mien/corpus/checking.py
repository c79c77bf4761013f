"""What is in a corpus, how good it is, and every fault in it with file and frame."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.capture.cleaning.lag import MAX_LAG, Lag, lag_from_sound
from mien.core.errors import InputError
from mien.core.plain_text import parsed_json
from mien.core.tracks import MarkerTrack
from mien.corpus.recordings import Corpus, digest_of
from mien.corpus.take import Take
from mien.speech.transcript_doubts import LOWEST_PHONE_SCORE, LOWEST_RUN_SCORE
from mien.text.phones import phone_table

__all__ = ["CorpusCheck", "Fault", "check_corpus", "faults_of"]

FASTEST = 1500.0
"""mm/s; no part of a speaking face is faster, in the axes of the head."""
_LEAST_JUMP = 12.0  # mm between two frames; below it speed is noise
_LENGTHS_AGREE = 0.25  # seconds
LATEST = 0.06
"""Seconds that the motion may be before or behind the sound; ITU-R BT.1359 finds 45 ms early sound detectable."""
_SURE = 0.95
_TAKES_FOR_LAG = 40
_LIPS = (("2.2", "2.3"), ("8.1", "8.2"))


@dataclass(frozen=True)
class Fault:
    """One thing wrong with a take, or (``sure`` is False) one that should be looked at.

    ``frame`` is None where it concerns the whole take.
    """

    name: str
    file: str
    frame: int | None
    message: str
    sure: bool = True

    def __str__(self) -> str:
        kind = "fault" if self.sure else "doubt"
        return f"{kind}: {self.file}" + ("" if self.frame is None else f", frame {self.frame}") + f": {self.message}"


@dataclass
class CorpusCheck:
    """What is in a corpus.

    Attributes
    ----------
    takes, words, phones : int
        How many.
    seconds, speech_seconds : float
        Of sound; and without pauses.
    phone_types, diphone_types, triphone_types : Counter
        How often each occurs, pauses counted as a phone.
    positions, filled : int
        Marker positions, and those of them that were filled.
    dropped : Counter
        In how many takes each marker was dropped.
    confidences : list of float
        Alignment scores of the takes that were aligned.
    emotions, speakers : Counter
        Takes of each.
    emotions_of_sentence : mapping of str to set of str
        Emotions in which each sentence was said.
    lag : Lag or None
        Of the motion behind the sound, over some of the takes; None where it cannot be known.
    faults : list of Fault
    """

    takes: int = 0
    words: int = 0
    phones: int = 0
    seconds: float = 0.0
    speech_seconds: float = 0.0
    phone_types: Counter[str] = field(default_factory=Counter)
    diphone_types: Counter[tuple[str, ...]] = field(default_factory=Counter)
    triphone_types: Counter[tuple[str, ...]] = field(default_factory=Counter)
    positions: int = 0
    filled: int = 0
    dropped: Counter[str] = field(default_factory=Counter)
    confidences: list[float] = field(default_factory=list)
    emotions: Counter[str] = field(default_factory=Counter)
    speakers: Counter[str] = field(default_factory=Counter)
    emotions_of_sentence: dict[str, set[str]] = field(default_factory=lambda: defaultdict(set))
    lag: Lag | None = None
    faults: list[Fault] = field(default_factory=list)

    def rows(self) -> list[tuple[str, str]]:
        """The table: what is counted, and the count."""
        spoken = [phone for phone in self.phone_types if phone in phone_table()]
        missing = sorted(set(phone_table()) - set(spoken))
        linked = sum(len(emotions) > 1 for emotions in self.emotions_of_sentence.values())
        score = np.array(self.confidences)
        return [
            ("sound", f"{self.seconds / 60:.1f} minutes, {self.speech_seconds / 60:.1f} of them speech"),
            ("takes", f"{self.takes} with {self.words} words and {self.phones} phones"),
            (
                "phones",
                f"{len(spoken)} of {len(phone_table())}" + (f", none of {' '.join(missing)}" if missing else ""),
            ),
            ("diphones", f"{len(self.diphone_types)} kinds, {_often(self.diphone_types)} of them five times or more"),
            (
                "triphones",
                f"{len(self.triphone_types)} kinds, {_often(self.triphone_types)} of them five times or more",
            ),
            (
                "gaps filled",
                f"{self.filled} of {self.positions} positions ({self.filled / max(self.positions, 1):.3%})",
            ),
            ("markers dropped", _counted(self.dropped) if self.dropped else "none"),
            (
                "alignment score",
                f"median {np.median(score):.1f}, lowest {score.min():.1f} (poor below {LOWEST_RUN_SCORE:g})"
                if len(score)
                else "nothing was aligned",
            ),
            ("motion behind sound", _said(self.lag)),
            ("emotions", _counted(self.emotions)),
            ("sentences in several emotions", str(linked)),
            ("speakers", _counted(self.speakers)),
            ("faults", str(sum(fault.sure for fault in self.faults))),
            ("doubts", str(sum(not fault.sure for fault in self.faults))),
        ]

    def __str__(self) -> str:
        rows = self.rows()
        width = max(len(name) for name, _ in rows)
        lines = [f"{name.ljust(width)}  {value}" for name, value in rows]
        return "\n".join(lines + [str(fault) for fault in sorted(self.faults, key=lambda fault: not fault.sure)])


def check_corpus(corpus: Corpus, progress: Callable[[int, int], None] | None = None) -> CorpusCheck:
    """Read every take of a corpus and say what is there and what is wrong."""
    check = CorpusCheck()
    seen: dict[str, str] = {}
    for number, name in enumerate(corpus.names, start=1):
        entry = corpus.entries[name]
        try:
            take = corpus.take(name)
        except InputError as problem:
            check.faults.append(Fault(name, f"motion/{name}.npz", None, " ".join(str(problem).split())))
            continue
        _count(check, take, entry)
        check.faults += faults_of(take, str(entry["digest"]))
        twin = seen.setdefault(str(entry["digest"]), name)
        if twin != name:
            check.faults.append(Fault(name, f"motion/{name}.npz", None, f"the same recording as {twin}; keep one"))
        if progress is not None:
            progress(number, len(corpus))
    check.lag = _lag(corpus)
    if check.lag is not None and check.lag.confidence >= _SURE and abs(check.lag.seconds) > LATEST:
        message = f"the motion is {1000 * check.lag.seconds:+.0f} ms behind the sound: did both start together?"
        check.faults.append(Fault("", "all takes", None, message, sure=False))
    if corpus.unfinished:
        check.faults.append(Fault("", "importing.jsonl", None, corpus.unfinished))
    check.faults += _refused(corpus.folder / "refused.jsonl")
    return check


def faults_of(take: Take, digest: str = "") -> list[Fault]:
    """What is wrong with one take."""
    motion, sound = f"motion/{take.name}.npz", f"audio/{take.name}.flac"
    faults = [Fault(take.name, sound, None, warning, sure=False) for warning in _split(take.source.get("warnings", ""))]
    if digest and digest_of(take) != digest:
        faults.append(Fault(take.name, motion, None, "sound or motion changed since the import; import it again"))
    positions = take.markers.positions
    missing: NDArray[np.bool_] = np.any(np.isnan(positions), axis=2)
    dropped = set(take.source.get("dropped", "").split())
    kept = [i for i, name in enumerate(take.markers.names) if name not in dropped]
    if missing[:, kept].any():
        frame, marker = np.argwhere(missing[:, kept])[0]
        many = int(missing[:, kept].sum())
        message = (
            f"marker {take.markers.names[kept[marker]]} is missing ({many} positions in all): its gap was not filled"
        )
        faults.append(Fault(take.name, motion, int(frame), message))
    step = np.nan_to_num(np.linalg.norm(np.diff(positions[:, kept], axis=0), axis=2))
    limit = max(FASTEST / take.markers.rate.fps, _LEAST_JUMP)
    if (step > limit).any():
        frame, marker = np.unravel_index(int(np.argmax(step)), step.shape)
        message = (
            f"marker {take.markers.names[kept[int(marker)]]} jumps by {step[frame, marker]:.0f} mm: a spike or a swap?"
        )
        faults.append(Fault(take.name, motion, int(frame) + 1, message))
    seconds = len(take.markers) / take.markers.rate.fps
    if abs(seconds - take.duration) > _LENGTHS_AGREE:
        faults.append(Fault(take.name, motion, None, f"{seconds:.2f} s of motion, {take.duration:.2f} s of sound"))
    confidence = take.source.get("confidence", "")
    if confidence and LOWEST_PHONE_SCORE < float(confidence) < LOWEST_RUN_SCORE:  # version 0.1 had another scale
        faults.append(
            Fault(take.name, sound, None, f"text and sound hardly fit (score {confidence}): is this its text?")
        )
    return faults


def _count(check: CorpusCheck, take: Take, entry: dict[str, Any]) -> None:
    labels = [interval.label for interval in take.phones]
    check.takes += 1
    check.words += len(take.words)
    check.phones += sum(label in phone_table() for label in labels)
    check.seconds += take.duration
    check.speech_seconds += sum(i.duration for i in take.phones if i.label in phone_table())
    check.phone_types.update(labels)
    check.diphone_types.update(pairwise(labels))
    check.triphone_types.update(zip(labels, labels[1:], labels[2:], strict=False))
    check.positions += take.markers.positions.shape[0] * take.markers.positions.shape[1]
    check.filled += int(take.source.get("filled") or 0)
    check.dropped.update(take.source.get("dropped", "").split())
    if take.source.get("confidence"):
        check.confidences.append(float(take.source["confidence"]))
    check.emotions[take.emotion] += 1
    check.speakers[take.speaker or "(not named)"] += 1
    if take.sentence:
        check.emotions_of_sentence[take.sentence].add(take.emotion)


def _lag(corpus: Corpus) -> Lag | None:
    """Lag of the motion, from takes evenly spread over the corpus; faulty ones are passed over."""
    names = corpus.names[:: max(1, len(corpus) // _TAKES_FOR_LAG)][:_TAKES_FOR_LAG]
    tracks, sounds = [], []
    for name in names:
        try:
            take = corpus.take(name)
        except InputError:
            continue  # it is among the faults already
        lips = next((pair for pair in _LIPS if set(pair) <= set(take.markers.names)), None)
        if lips is not None:
            index = [take.markers.names.index(lip) for lip in lips]
            tracks.append(MarkerTrack(("upper", "lower"), take.markers.positions[:, index], take.markers.rate))
            sounds.append(take.audio)
    try:
        return lag_from_sound(tracks, sounds, ("upper", "lower"))
    except InputError:
        return None  # no lips, or lips that do not move


def _said(lag: Lag | None) -> str:
    if lag is None or np.isnan(lag.seconds):
        return "not known" + ("" if lag is None else f" (no best fit within {1000 * MAX_LAG:.0f} ms)")
    spread = "" if np.isnan(lag.error) else f" ± {1000 * lag.error:.0f}"
    return f"{1000 * lag.seconds:+.0f}{spread} ms" + ("" if lag.confidence >= _SURE else " (may be chance)")


def _refused(path: Path) -> list[Fault]:
    if not path.exists():
        return []
    entries = (parsed_json(line) for line in path.read_text(encoding="utf-8").splitlines() if line.strip())
    return [Fault(e["name"], e["file"], None, f"not in the corpus: {e['reason']}") for e in entries]


def _often(counter: Counter[tuple[str, ...]]) -> int:
    return sum(count >= 5 for count in counter.values())


def _counted(counter: Counter[str]) -> str:
    return ", ".join(f"{name} {count}" for name, count in sorted(counter.items()))


def _split(text: str) -> Iterable[str]:
    return [part for part in text.split(" | ") if part]
