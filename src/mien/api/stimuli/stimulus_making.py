"""Making all stimuli of a design, each with a log of every frame.

Every stimulus is made alone from its row, so the same row, seed and versions give the same bits in whatever order, on
however many workers, on this machine or on a Dask cluster.
"""

from __future__ import annotations

import csv
import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from mien.animation.animation import Animation
from mien.api.stimuli.design import Stimulus, read_design
from mien.api.stimuli.row_lists import counterbalanced, write_list
from mien.api.stimuli.row_performance import performed
from mien.core.errors import InputError, MienError, OutputError
from mien.core.files import held_alone, replace_when_complete
from mien.corpus.workers import each
from mien.face.model import Face
from mien.face.render.view import Pictures, View
from mien.formats.registry import check_output, save
from mien.formats.video import check_film

__all__ = ["StimuliReport", "fingerprint", "make_stimuli"]

SCOPE = "same bits for the same row, seed, versions of mien and its parts, and processor family"
# What the bits depend on besides mien itself.
_PARTS = ("numpy", "scipy", "numba", "av", "onnxruntime")
# The log and the facts of a stimulus have these suffixes already.
_BESIDE = {".csv": "-livelink.csv", ".json": "-take.json"}


@dataclass(frozen=True)
class StimuliReport:
    """What was made in this run, what was there already, (name, reason) of what failed, (name, warning) of the rest."""

    made: tuple[str, ...]
    kept: tuple[str, ...]
    failed: tuple[tuple[str, str], ...]
    warned: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class _Job:
    stimulus: Stimulus
    folder: str
    formats: tuple[str, ...]  # suffixes of what is written besides; or, without a picture, alone
    picture: bool

    def files(self) -> dict[str, str]:
        """Names of what is written, with the suffix of the format of each; '' is the video or picture."""
        name = self.stimulus.name
        besides = {f"{name}{_BESIDE.get(suffix.lower(), suffix)}": suffix for suffix in self.formats}
        return {self.stimulus.file: "", **besides} if self.picture else besides


def make_stimuli(
    design: str | Path | Sequence[Stimulus],
    folder: str | Path,
    *,
    lists: int = 0,
    formats: Sequence[str] = (),
    picture: bool = True,
    workers: int | None = None,
    cluster: str | None = None,
    progress: Callable[[int, int], None] | None = None,
    finished: Callable[[str, str], None] | None = None,
) -> StimuliReport:
    """Make all stimuli of a design, or go on where a run was stopped.

    Parameters
    ----------
    design : path-like or sequence of Stimulus
    folder : path-like
        Made if it is not there. Gets ``NAME.mp4`` or ``NAME.png``, ``NAME.csv`` (one row for each frame) and
        ``NAME.json`` (settings, hashes) for each stimulus, and ``manifest.csv``.
    lists : int
        Also write so many counterbalanced lists: each holds every sentence once per ``lists`` conditions, by a Latin
        square.
    formats : sequence of str
        Suffixes of further files for each stimulus, such as ``.glb`` (`mien.formats.registry`); ``.csv`` and ``.json``
        are written as ``NAME-livelink.csv`` and ``NAME-take.json``.
    picture : bool
        Whether the video or picture is made at all; without it some format is needed.
    workers, cluster
        As in `mien.corpus.workers.each`.
    progress : callable (done, total), optional
    finished : callable (name, reason), optional
        Called when a stimulus is done; the reason is empty unless it failed.

    Raises
    ------
    InputError
        If the design cannot be used.
    OutputError
        If the folder cannot be written.
    """
    stimuli = read_design(design) if isinstance(design, (str, Path)) else tuple(design)
    counterbalanced((), lists)
    folder = _made(Path(folder))
    with held_alone(folder / ".making", f"another mien command is writing into {folder}"):
        jobs = [_Job(stimulus, str(folder), tuple(formats), picture) for stimulus in stimuli]
        if not picture and not formats:
            raise InputError("nothing is to be written: name a format")
        _check_views(stimuli, folder, formats, picture)
        # What is known of each is read once; a design may have thousands of rows.
        facts = {job.stimulus.name: known for job in jobs if (known := _finished(job)) is not None}
        kept = tuple(facts)
        made, failed = list[str](), list[tuple[str, str]]()
        for job, result in each(_make, [job for job in jobs if job.stimulus.name not in facts], workers, cluster):
            if isinstance(result, BaseException):
                reason = " ".join(str(result).split())
                failed.append(
                    (job.stimulus.name, reason if isinstance(result, MienError) else f"unexpected: {result!r}")
                )
            else:
                made.append(job.stimulus.name)
                facts[job.stimulus.name] = result
            if finished is not None:
                finished(job.stimulus.name, failed[-1][1] if isinstance(result, BaseException) else "")
            if progress is not None:
                progress(len(facts) + len(failed), len(stimuli))
        there = [stimulus for stimulus in stimuli if stimulus.name in facts]
        write_list(there, facts, folder / "manifest.csv")
        for number, members in enumerate(counterbalanced(there, lists), start=1):
            write_list(members, facts, folder / f"list-{number}.csv")
        warned = tuple((name, told) for name in sorted(made) for told in facts[name]["warnings"])
        return StimuliReport(tuple(sorted(made)), kept, tuple(sorted(failed)), warned)


def _check_views(stimuli: Sequence[Stimulus], folder: Path, formats: Sequence[str], picture: bool) -> None:
    """Refuse what a format cannot hold before anything is made."""
    for suffix in formats:
        if suffix.startswith("%"):
            raise InputError(f"{suffix}: stimuli are one file of each format; for frames give mien say -o NAME{suffix}")
        for view in {stimulus.view for stimulus in stimuli} or {View()}:
            check_output(folder / f"x{suffix}", view)
    for stimulus in {(stimulus.view, bool(stimulus.still_ms)): stimulus for stimulus in stimuli}.values():
        if picture and not stimulus.still_ms:
            check_film(stimulus.file, stimulus.view)


def _made(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise OutputError(f"cannot make {folder}: {problem.strerror}") from problem
    return folder


def fingerprint(stimulus: Stimulus) -> str:
    """Changes with anything that changes the stimulus: its row, the files it names, the versions."""
    named = {name: _content(value) for name, value in (("performer", stimulus.performer), ("face", stimulus.face))}
    facts = {"settings": stimulus.settings(), "files": named, "versions": _versions()}
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:16]


def _content(name: str) -> str:
    """The hash of a file of that name; empty if it is the name of something that comes with mien."""
    try:
        state = Path(name).stat()
    except OSError:
        return ""
    return _content_of(name, state.st_mtime_ns, state.st_size) if Path(name).is_file() else ""


@lru_cache(maxsize=256)
def _content_of(path: str, _changed: int, _size: int) -> str:
    return _hash(Path(path))


@lru_cache(maxsize=1)
def _versions() -> dict[str, str]:
    return {name: version(name) for name in ("mien", *_PARTS)}


@lru_cache(maxsize=2)
def _face(name: str, _content: str) -> Face:
    from mien.face.library import load_face

    return load_face(name)


@lru_cache(maxsize=2)
def _renderer(face: str, content: str, view: View) -> Pictures:
    return view.renderer(_face(face, content))


def _make(job: _Job) -> dict[str, Any]:
    """One stimulus with its log; its ``.json`` is written last, so what has one is whole."""
    stimulus, folder = job.stimulus, Path(job.folder)
    log = folder / f"{stimulus.name}.csv"
    try:
        animation, heard = performed(stimulus)
        notes = list(animation.notes)
        for name, suffix in job.files().items():
            if suffix:
                notes += save(
                    animation, folder / name, face=_face(stimulus.face, _content(stimulus.face)), view=stimulus.view
                )
            else:
                _write_picture(stimulus, animation, folder / name)
        _write_log(animation, heard, log)
    except MienError as problem:
        raise InputError(f"{stimulus.where}: {problem}" if stimulus.where else str(problem)) from problem
    facts = {
        "name": stimulus.name,
        "fingerprint": fingerprint(stimulus),
        "settings": stimulus.settings(),
        "frames": len(animation.channels),
        "seconds": animation.utterance.duration,
        "sha256": {name: _hash(folder / name) for name in (*job.files(), log.name)},
        "versions": _versions(),
        "scope": SCOPE,
        "notes": [note.message for note in notes if note.kind == "note"],
        "warnings": [note.message for note in notes if note.kind == "warning"],
    }
    with replace_when_complete(folder / f"{stimulus.name}.json") as unfinished:
        unfinished.write_text(json.dumps(facts, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return facts


def _write_picture(stimulus: Stimulus, animation: Animation, path: Path) -> None:
    face = _face(stimulus.face, _content(stimulus.face))
    frame = _renderer(stimulus.face, _content(stimulus.face), stimulus.view)
    if not stimulus.still_ms:
        from mien.formats.video import write_video

        write_video(animation, face, path, view=stimulus.view, renderer=frame)
        return
    from PIL import Image

    from mien.face.deformers import poser_for

    number = animation.rate.nearest_frame(float(stimulus.still_ms) / 1000)
    if number >= len(animation.channels):
        raise InputError(f"still_ms={stimulus.still_ms} lies outside the sound of {animation.utterance.duration:.3f} s")
    posed = poser_for(face, animation.channels.names).pose(animation.channels.values[number])
    with replace_when_complete(path) as unfinished:
        Image.fromarray(frame.render(posed)).save(unfinished, format="PNG")


def _write_log(animation: Animation, heard: Animation, path: Path) -> None:
    track = animation.channels
    with replace_when_complete(path) as unfinished, unfinished.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["frame", "time_ms", "phone", "word", "phone_of_sound", *track.names])
        for number, row in enumerate(track.values):
            seconds = animation.rate.time_of(number)
            shown = [tier.at(seconds) for tier in (animation.utterance.phones, animation.utterance.words)]
            labels = [item.label if item else "" for item in (*shown, heard.utterance.phones.at(seconds))]
            writer.writerow([number, round(seconds * 1000, 6), *labels, *(repr(float(value)) for value in row)])


def _hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _finished(job: _Job) -> dict[str, Any] | None:
    """The facts of what was made before from the same settings, if nobody touched its files."""
    folder = Path(job.folder)
    try:
        facts = json.loads((folder / f"{job.stimulus.name}.json").read_text(encoding="utf-8"))
        hashes = dict(facts["sha256"])
        same = facts["fingerprint"] == fingerprint(job.stimulus) and {"frames", "seconds"} <= set(facts)
    except (OSError, ValueError, KeyError, TypeError):
        return None  # not there, not whole, or not ours: it is made anew
    whole = same and set(job.files()) <= set(hashes)
    if not whole or not all((folder / name).is_file() and _hash(folder / name) == hashes[name] for name in hashes):
        return None
    return facts  # type: ignore[no-any-return]
