"""Stimuli for experiments (SPEC D6): one table of factors in, videos or pictures with a log of every frame out.

Every stimulus is made alone from its row, so the same row, seed and versions give the same bits in whatever order, on
however many workers, on this machine or on a Dask cluster (SPEC D9).
"""

from __future__ import annotations

import csv
import hashlib
import itertools
import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from mien.animation import Animation
from mien.audio import Audio
from mien.corpus.workers import each
from mien.errors import InputError, MienError, OutputError, unknown_name
from mien.files import replace_when_complete

__all__ = ["StimuliReport", "Stimulus", "make_stimuli", "read_design"]

_EDGE = 200.0  # ms of silence at either end, as voices leave it
SCOPE = "same bits for the same row, seed, versions of mien and its parts, and processor family"


@dataclass(frozen=True)
class Stimulus:
    """One stimulus; the fields are the columns of a design (``docs/stimuli.md``).

    Attributes
    ----------
    name : str
        Of its files.
    sentence : str
        What the face says; tags as in ``docs/script.md``.
    heard : str
        What is heard instead (a McGurk pair); empty: the same.
    emotion, intensity
        As for `mien.say`.
    offset_ms : float
        Sound after (> 0) or before (< 0) the picture.
    rate : float
        Speaking rate, 1 as usual.
    au : str
        Action units or face parameters held throughout, such as ``AU12:0.7 AU4:0.5``.
    still_ms : str
        Empty for a video; else the time of the one picture.
    """

    name: str
    sentence: str
    heard: str = ""
    voice: str = ""
    emotion: str = ""
    intensity: float = 1.0
    offset_ms: float = 0.0
    rate: float = 1.0
    au: str = ""
    still_ms: str = ""
    fps: str = "25"
    seed: int = 0
    performer: str = "default"
    face: str = "default"
    width: int = 640
    height: int = 480
    where: str = ""

    @property
    def fingerprint(self) -> str:
        """Changes with anything that changes the stimulus."""
        facts = {name: value for name, value in asdict(self).items() if name != "where"} | {"mien": version("mien")}
        return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class StimuliReport:
    """What was made in this run, what was there already, and (name, reason) of what failed."""

    made: tuple[str, ...]
    kept: tuple[str, ...]
    failed: tuple[tuple[str, str], ...]


_COLUMNS = tuple(name for name in Stimulus.__dataclass_fields__ if name != "where")
_NUMBERS = {"intensity": float, "offset_ms": float, "rate": float, "seed": int, "width": int, "height": int}


def read_design(path: str | Path) -> tuple[Stimulus, ...]:
    """The stimuli of a table (CSV, or TSV by its suffix).

    Levels in one cell are parted by ``|`` and crossed with those of the other cells of the row; several rows list
    what is not crossed.

    Raises
    ------
    InputError
        Naming file and line: a column that is missing or not known, a value that does not fit, a name used twice.
    """
    path = Path(path)
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            reader = csv.DictReader(stream, delimiter="\t" if path.suffix.lower() == ".tsv" else ",")
            rows = [(reader.line_num, row) for row in reader]
            header = reader.fieldnames or ()
    except OSError as problem:
        raise InputError(f"{path}: cannot be read ({problem.strerror})") from problem
    except (UnicodeDecodeError, csv.Error) as problem:
        raise InputError(f"{path}: expected a table in UTF-8 ({problem})") from problem
    for column in header:
        if column not in _COLUMNS:
            raise InputError(f"{path}, line 1: {unknown_name('column', column, _COLUMNS)}")
    if "sentence" not in header:
        raise InputError(f"{path}, line 1: the column 'sentence' is missing; known: {', '.join(_COLUMNS)}")
    found: dict[str, Stimulus] = {}
    for line, row in rows:
        for stimulus in _crossed(row, f"{path}, line {line}", len(found)):
            if stimulus.name in found:
                raise InputError(
                    f"{stimulus.where}: the name {stimulus.name!r} is used at {found[stimulus.name].where} too"
                )
            found[stimulus.name] = stimulus
    if not found:
        raise InputError(f"{path}: no stimulus in it")
    return tuple(found.values())


def _crossed(row: Mapping[str | None, str | list[str] | None], where: str, before: int) -> Iterable[Stimulus]:
    if None in row or any(value is None for value in row.values()):
        raise InputError(f"{where}: expected as many cells as the first line has; a text with a comma stands in quotes")
    given = {str(name): str(value).strip() for name, value in row.items() if str(value).strip()}
    if "sentence" not in given:
        raise InputError(f"{where}: the sentence is empty")
    levels = {name: [level.strip() for level in value.split("|")] for name, value in given.items()}
    crossed = list(itertools.product(*levels.values()))
    for number, values in enumerate(crossed, start=1):
        cell = dict(zip(levels, values, strict=True))
        name = cell.pop("name", f"s{before + number:04d}")
        name = f"{name}-{number:03d}" if "name" in given and len(crossed) > 1 else name
        if not re.fullmatch(r"[\w.-]+", name):
            raise InputError(f"{where}: a name is letters, digits, '.', '_' and '-', not {name!r}")
        yield _stimulus(name, cell, where)


def _stimulus(name: str, cell: Mapping[str, str], where: str) -> Stimulus:
    values: dict[str, object] = {}
    for column, text in cell.items():
        if column not in _NUMBERS:
            values[column] = text
            continue
        try:
            values[column] = _NUMBERS[column](text)
        except ValueError:
            kind = "a whole number" if _NUMBERS[column] is int else "a number"
            raise InputError(f"{where}: {column} is {kind}, not {text!r}") from None
    stimulus = Stimulus(name=name, where=where, **values)  # type: ignore[arg-type]
    checks = (
        (0 <= stimulus.intensity <= 1, f"intensity runs from 0 to 1, not {stimulus.intensity:g}"),
        (0.25 <= stimulus.rate <= 4, f"rate lies between 0.25 and 4, not {stimulus.rate:g}"),
        (abs(stimulus.offset_ms) <= 10_000, f"offset_ms lies within 10 s, not {stimulus.offset_ms:g}"),
        (stimulus.seed >= 0, f"seed is 0 or more, not {stimulus.seed}"),
        (stimulus.width % 2 == 0 and stimulus.height % 2 == 0, "width and height are even numbers of pixels"),
        (not stimulus.still_ms or re.fullmatch(r"\d+(\.\d+)?", stimulus.still_ms), "still_ms is milliseconds"),
    )
    for right, message in checks:
        if not right:
            raise InputError(f"{where}: {message}")
    return stimulus


@dataclass(frozen=True)
class _Job:
    stimulus: Stimulus
    folder: str


def make_stimuli(
    design: str | Path | Sequence[Stimulus],
    folder: str | Path,
    *,
    lists: int = 0,
    workers: int | None = None,
    cluster: str | None = None,
    progress: Callable[[int, int], None] | None = None,
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
    workers, cluster
        As in `mien.corpus.workers.each`.
    progress : callable (done, total), optional

    Raises
    ------
    InputError
        If the design cannot be used.
    OutputError
        If the folder cannot be written.
    """
    stimuli = read_design(design) if isinstance(design, (str, Path)) else tuple(design)
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise OutputError(f"cannot make {folder}: {problem.strerror}") from problem
    kept = [stimulus.name for stimulus in stimuli if _is_done(stimulus, folder)]
    waiting = [_Job(stimulus, str(folder)) for stimulus in stimuli if stimulus.name not in set(kept)]
    made, failed = list[str](), list[tuple[str, str]]()
    for job, result in each(_make, waiting, workers, cluster):
        if isinstance(result, BaseException):
            reason = " ".join(str(result).split())
            failed.append((job.stimulus.name, reason if isinstance(result, MienError) else f"unexpected: {result!r}"))
        else:
            made.append(job.stimulus.name)
        if progress is not None:
            progress(len(kept) + len(made) + len(failed), len(stimuli))
    _write_manifest([s for s in stimuli if s.name not in {name for name, _ in failed}], folder, lists)
    return StimuliReport(tuple(sorted(made)), tuple(kept), tuple(sorted(failed)))


def _make(job: _Job) -> str:
    """One stimulus with its log; its ``.json`` is written last, so what has one is whole."""
    stimulus, folder = job.stimulus, Path(job.folder)
    try:
        animation, heard = performed(stimulus)
        picture = _write_picture(stimulus, animation, folder)
    except MienError as problem:
        raise InputError(f"{stimulus.where}: {problem}" if stimulus.where else str(problem)) from problem
    log = folder / f"{stimulus.name}.csv"
    _write_log(animation, heard, log)
    facts = {
        "name": stimulus.name,
        "fingerprint": stimulus.fingerprint,
        "settings": {name: value for name, value in asdict(stimulus).items() if name != "where"},
        "frames": len(animation.channels),
        "seconds": animation.utterance.duration,
        "sha256": {path.name: _hash(path) for path in (picture, log)},
        "mien": version("mien"),
        "scope": SCOPE,
        "notes": [note.message for note in animation.notes],
    }
    with replace_when_complete(folder / f"{stimulus.name}.json") as unfinished:
        unfinished.write_text(json.dumps(facts, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return stimulus.name


def performed(stimulus: Stimulus) -> tuple[Animation, Animation]:
    """The animation with the sound that is heard, and the one whose words that sound says (timed with it)."""
    from mien import api

    options = {"voice": stimulus.voice or None, "fps": stimulus.fps, "seed": stimulus.seed}
    emotion = f"{stimulus.emotion}:{stimulus.intensity!r}" if stimulus.emotion else None

    def say(text: str, before: float, after: float) -> Animation:
        lead = f'<pause ms="{before}"/>' if before else ""
        tail = f'<pause ms="{after}"/>' if after else ""
        spoken = f"{lead}{_directed(stimulus, text)}{tail}"
        return api.say(spoken, emotion=emotion, performer=stimulus.performer, **options)  # type: ignore[arg-type]

    shift = stimulus.offset_ms
    before = _EDGE + -shift if shift < 0 else 0.0
    after = _EDGE + shift if shift > 0 else 0.0
    seen = say(stimulus.sentence, before, after)
    if not stimulus.heard:
        return _with_sound(seen, seen.utterance.audio, shift), seen
    heard = say(stimulus.heard, before, after)
    longer = heard.utterance.duration - seen.utterance.duration
    if longer > 0:
        last = max((word.end for word in seen.utterance.words), default=0.0)
        seen = say(stimulus.sentence, before, 1000 * (seen.utterance.duration - last + longer))
    return _with_sound(seen, heard.utterance.audio, shift), heard


def _directed(stimulus: Stimulus, text: str) -> str:
    for item in reversed(stimulus.au.replace(",", " ").split()):
        parameter, _, value = item.partition(":")
        text = f"<pose parameter={quoteattr(parameter)} value={quoteattr(value or '1')}>{text}</pose>"
    return text if stimulus.rate == 1 else f'<prosody rate="{stimulus.rate!r}">{text}</prosody>'


def _with_sound(animation: Animation, sound: Audio, shift_ms: float) -> Animation:
    """The animation with a sound that starts later (> 0) or earlier, as long as the picture."""
    rate, count = sound.rate, round(animation.utterance.duration * sound.rate)
    shift = round(shift_ms / 1000 * rate)
    samples = np.zeros(count, dtype=np.float32)
    first, start = max(0, -shift), max(0, shift)
    length = min(len(sound) - first, count - start)
    if length <= 0:
        raise InputError(
            f"offset_ms={shift_ms:g} puts the sound outside the picture of {animation.utterance.duration:.3f} s"
        )
    samples[start : start + length] = sound.samples[first : first + length]
    return replace(animation, utterance=replace(animation.utterance, audio=Audio(samples, rate)))


def _write_picture(stimulus: Stimulus, animation: Animation, folder: Path) -> Path:
    from mien.face.library import load_face

    face = load_face(stimulus.face)
    if not stimulus.still_ms:
        from mien.output.video import write_video

        path = folder / f"{stimulus.name}.mp4"
        write_video(animation, face, path, width=stimulus.width, height=stimulus.height)
        return path
    from PIL import Image

    from mien.face.posing import Poser
    from mien.render.renderer import Renderer

    frame = animation.rate.nearest_frame(float(stimulus.still_ms) / 1000)
    if frame >= len(animation.channels):
        raise InputError(f"still_ms={stimulus.still_ms} lies outside the sound of {animation.utterance.duration:.3f} s")
    posed = Poser(face, animation.channels.names).pose(animation.channels.values[frame])
    path = folder / f"{stimulus.name}.png"
    with replace_when_complete(path) as unfinished:
        Image.fromarray(Renderer(face, stimulus.width, stimulus.height).render(posed)).save(unfinished, format="PNG")
    return path


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


def _facts(stimulus: Stimulus, folder: Path) -> dict[str, object] | None:
    try:
        found: dict[str, object] = json.loads((folder / f"{stimulus.name}.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return found


def _is_done(stimulus: Stimulus, folder: Path) -> bool:
    """Whether it was made from the same settings and nobody touched its files."""
    facts = _facts(stimulus, folder)
    if facts is None or facts.get("fingerprint") != stimulus.fingerprint or not isinstance(facts.get("sha256"), dict):
        return False
    hashes = facts["sha256"]
    assert isinstance(hashes, dict)
    return all((folder / name).exists() and _hash(folder / name) == value for name, value in hashes.items())


def _write_manifest(stimuli: Sequence[Stimulus], folder: Path, lists: int) -> None:
    if lists < 0:
        raise InputError(f"a number of lists is 0 or more, not {lists}")
    sentences = list(dict.fromkeys(stimulus.sentence for stimulus in stimuli))
    place: dict[str, int] = {}
    chosen: list[list[Stimulus]] = [[] for _ in range(lists)]
    for stimulus in stimuli:
        condition = place[stimulus.sentence] = place.get(stimulus.sentence, -1) + 1
        if lists:
            chosen[(condition + sentences.index(stimulus.sentence)) % lists].append(stimulus)
    _write_list(stimuli, folder, folder / "manifest.csv")
    for number, members in enumerate(chosen, start=1):
        _write_list(members, folder, folder / f"list-{number}.csv")


def _write_list(stimuli: Sequence[Stimulus], folder: Path, path: Path) -> None:
    with replace_when_complete(path) as unfinished, unfinished.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["file", "frames", "seconds", "sha256", *_COLUMNS])
        for stimulus in stimuli:
            facts = _facts(stimulus, folder) or {}
            file = f"{stimulus.name}.{'png' if stimulus.still_ms else 'mp4'}"
            hashes = facts.get("sha256")
            digest = hashes.get(file, "") if isinstance(hashes, dict) else ""
            settings = [getattr(stimulus, name) for name in _COLUMNS]
            writer.writerow([file, facts.get("frames", ""), facts.get("seconds", ""), digest, *settings])
