"""Every take of a corpus as motion of the speaker's own face, kept beside its markers.

::

    CORPUS/
      people.npz         each speaker: neutral face, head, what each channel does on it (`mien.capture.person.Person`)
      channels/NAME.npz  channels (frames, channels) float32, names, stamp

Takes that were recorded as channels keep those. An import ends with this; ``mien corpus upgrade`` does it for a corpus
that an older version imported, or captures again what a newer solver does better.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.capture.capture import capture_take
from mien.capture.one_camera import fit_speaker
from mien.capture.person import Person
from mien.capture.person_file import arrays_of, person_from, stamp_of
from mien.core.assets import asset
from mien.core.errors import InputError, MienError, Note
from mien.core.files import replace_when_complete
from mien.core.limits import load_arrays
from mien.corpus.recordings import Corpus
from mien.corpus.workers import each

__all__ = ["CaptureReport", "capture_corpus", "people_of", "source_of"]

SOLVER = "9"
"""Raise it when takes captured by older code should be captured again; what it reads is told apart by itself."""
_READS = ("capture/solver.toml", "faces/default.npz", "fitting/default.npz")
_ENOUGH = 24  # takes to know a person by
_PEOPLE = "people.npz"
_SEEN = 0.5  # share of its positions that a recording must have to tell what the person looks like
_BY_CAMERA = "mediapipe-218"


@dataclass(frozen=True)
class CaptureReport:
    """What was captured.

    Attributes
    ----------
    captured, kept, recorded : tuple of str
        Takes captured now, captured before by the same solver, and recorded as channels.
    failed : tuple of (str, str)
        Takes without channels, and why, in one line each.
    notes : tuple of Note
    """

    captured: tuple[str, ...]
    kept: tuple[str, ...]
    recorded: tuple[str, ...]
    failed: tuple[tuple[str, str], ...]
    notes: tuple[Note, ...]


@dataclass(frozen=True)
class _Job:
    corpus: str
    name: str
    speaker: str
    stamp: str


def capture_corpus(
    corpus: Corpus,
    workers: int | None = None,
    cluster: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> CaptureReport:
    """Capture all takes that have no channels by this solver yet.

    Parameters
    ----------
    corpus : Corpus
    workers, cluster
        As in `mien.corpus.workers.each`.
    progress : callable, optional
        Called with how many takes are done and how many there are.

    Raises
    ------
    InputError
        If the corpus cannot be read.
    """
    recorded = tuple(name for name in corpus.names if corpus.has_recorded_channels(name))
    names = [name for name in corpus.names if name not in set(recorded)]
    speakers: dict[str, list[str]] = {}
    for name in names:
        speakers.setdefault(corpus.entries[name]["speaker"], []).append(name)
    solver = _solver()
    known = people_of(corpus) if _solver_of(corpus) == solver else {}
    failed: list[tuple[str, str]] = []
    notes: list[Note] = []
    for speaker, own in speakers.items():
        stale = speaker in known and known[speaker].layout != corpus.about.get("layout")
        if speaker in known and not stale:
            continue
        try:
            known[speaker], said = _met(corpus, speaker, own)
            notes += said
        except InputError as problem:
            failed += [(name, str(problem)) for name in own]
    _keep(corpus, known)
    (corpus.folder / "channels").mkdir(exist_ok=True)
    stamps = {speaker: f"{solver} {stamp_of(person)}" for speaker, person in known.items()}
    jobs, kept = [], []
    for name in names:
        speaker = corpus.entries[name]["speaker"]
        if speaker not in known:
            continue
        stamp = f"{stamps[speaker]} {corpus.entries[name]['digest'][:16]}"
        if corpus.channel_stamp(name) == stamp:
            kept.append(name)
        else:
            jobs.append(_Job(str(corpus.folder), name, speaker, stamp))
    captured: list[str] = []
    for job, result in each(_capture_and_write, jobs, workers, cluster) if jobs else ():
        if isinstance(result, BaseException):
            why = str(result) if isinstance(result, MienError) else f"unexpected {type(result).__name__}: {result}"
            failed.append((job.name, " ".join(why.split())))
        else:
            captured.append(job.name)
        if progress is not None:
            progress(len(kept) + len(captured) + len(failed), len(names))
    return CaptureReport(tuple(sorted(captured)), tuple(kept), recorded, tuple(sorted(failed)), tuple(notes))


def people_of(corpus: Corpus) -> dict[str, Person]:
    """The speakers of a corpus, as far as they were captured.

    Raises
    ------
    InputError
        If their file is damaged.
    """
    path = corpus.folder / _PEOPLE
    if not path.exists():
        return {}
    try:
        arrays = load_arrays(path)
        speakers = [str(name) for name in arrays.pop("speakers")]
        arrays.pop("solver", None)
        own: list[dict[str, object]] = [{} for _ in speakers]
        for name, array in arrays.items():
            number, _, key = name.partition("/")
            own[int(number)][key] = array
        return {speaker: person_from(found) for speaker, found in zip(speakers, own, strict=True)}
    except (InputError, ValueError, KeyError, IndexError, TypeError) as problem:
        raise InputError(f"{path}: damaged ({problem}); delete it and run 'mien corpus upgrade'") from problem


def source_of(layout: str, head: NDArray[np.float64] | None) -> str:
    """``tracker`` if one camera saw a take, else ``optical``.

    Parameters
    ----------
    layout : str
        Of its markers.
    head : ndarray, shape (frames, 4, 4), or None
        The head's motion; what a camera saw is laid on the reference with a scale in every frame.

    Examples
    --------
    >>> source_of("mediapipe-218", None), source_of("mpeg4-32", np.eye(4)[None])
    ('tracker', 'optical')
    """
    if layout == _BY_CAMERA:
        return "tracker"
    if head is None:
        return "optical"
    sizes = np.cbrt(np.abs(np.linalg.det(head[:, :3, :3])))
    return "tracker" if np.abs(sizes[np.isfinite(sizes)] - 1).max(initial=0.0) > 1e-4 else "optical"


def _met(corpus: Corpus, speaker: str, names: list[str]) -> tuple[Person, list[Note]]:
    """Know a speaker by their neutral takes; by all if there are none."""
    neutral = [name for name in names if corpus.entries[name]["emotion"] == "neutral"]
    notes = []
    if not neutral:
        whose = f"speaker {speaker!r}" if speaker else "the speaker"
        notes.append(
            Note("warning", f"{whose} has no neutral take: what the face at rest looks like is guessed from the others")
        )
    motions = [corpus.motion(name) for name in _spread(neutral or names)]
    tracks = [markers for markers, *_ in motions]
    whole = [track for track in tracks if np.isfinite(track.positions).mean() > _SEEN] or tracks
    layout = str(corpus.about.get("layout", ""))
    return fit_speaker(whole, layout, source_of(layout, motions[0][1])), notes


def _spread(names: list[str]) -> Iterable[str]:
    step = max(1, len(names) // _ENOUGH)
    return names[::step][:_ENOUGH]


def _keep(corpus: Corpus, people: dict[str, Person]) -> None:
    arrays: dict[str, Any] = {"speakers": np.array(sorted(people)), "solver": np.array(_solver())}
    for number, speaker in enumerate(sorted(people)):
        arrays |= {f"{number}/{key}": array for key, array in arrays_of(people[speaker]).items()}
    with replace_when_complete(corpus.folder / _PEOPLE) as unfinished:
        np.savez_compressed(unfinished, **arrays)


@cache
def _solver() -> str:
    """Tells this solver, and the face and table that it works with, from others."""
    value = hashlib.sha256(SOLVER.encode())
    for name in _READS:
        value.update(asset(name).read_bytes())
    return value.hexdigest()[:16]


def _solver_of(corpus: Corpus) -> str:
    """Which solver the people of a corpus are known to; empty if it was one that did not say."""
    path = corpus.folder / _PEOPLE
    try:
        return str(load_arrays(path)["solver"]) if path.exists() else _solver()
    except KeyError:
        return ""
    except InputError:
        return _solver()  # damaged: `people_of` says so


@lru_cache(maxsize=4)
def _person(folder: str, speaker: str, stamp: str) -> Person:
    return people_of(Corpus.files_only(Path(folder)))[speaker]


def _capture_and_write(job: _Job) -> None:
    corpus = Corpus.files_only(Path(job.corpus))
    person = _person(job.corpus, job.speaker, job.stamp.split()[1])
    markers = corpus.motion(job.name)[0]
    corpus.write_channels(job.name, capture_take(markers, person.layout, head=person, spoken=True).channels, job.stamp)
