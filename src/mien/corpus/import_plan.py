"""What an import has to do: names, facts and jobs of all takes, and the reference frames that they share."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.core.border import reading
from mien.core.errors import InputError, Note
from mien.core.files import replace_when_complete
from mien.core.limits import load_arrays
from mien.corpus.import_preparation import Job, layout_for
from mien.corpus.readers import Found, reader_named
from mien.corpus.recipes import FIELDS, Recipe
from mien.corpus.recordings import Corpus
from mien.corpus.reference_frame import reference_of
from mien.corpus.workers import each

__all__ = ["Failure", "References", "facts_of", "jobs_for", "named", "references", "unused_rows"]

_TRIED_FOR_REFERENCE = 20
_MAKER = "1"  # raise it when takes made by older code should be made again
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Failure:
    """A recording that did not become a take; ``reason`` is one line with file, frame and likely cause."""

    name: str
    file: str
    reason: str


@dataclass(frozen=True)
class References:
    """One frame per speaker on which all others are laid, and the layout of all; speakers without one failed."""

    frames: Mapping[str, Floats]
    layout: str
    failed: tuple[Failure, ...]


def named(found: Sequence[Found], source: Path) -> tuple[dict[str, Found], tuple[Note, ...], list[Failure]]:
    """Recordings by the names of their takes; names that repeat get the folder in front."""
    counts = Counter(recording.name for recording in found)
    notes, failed = [], []
    takes: dict[str, Found] = {}
    repeated = [name for name, count in counts.items() if count > 1]
    if repeated:
        notes.append(Note("note", f"{source}: {len(repeated)} names repeat ({repeated[0]!r}...): folders go in front"))
    for recording in found:
        plain = f"{recording.motion.parent.name}-{recording.name}" if counts[recording.name] > 1 else recording.name
        name = _fit_for_a_file(plain)
        if name != plain:
            notes.append(
                Note("note", f"{recording.motion}: its take is named {name!r}, since names of takes are plain")
            )
        if name in takes:
            reason = f"{recording.motion}: its name {name!r} is that of {takes[name].motion} too; rename one"
            failed.append(Failure(f"{name} ({recording.motion.suffix[1:]})", str(recording.motion), reason))
        else:
            takes[name] = recording
    return takes, tuple(notes), failed


def _fit_for_a_file(name: str) -> str:
    return "".join(c if c.isalnum() or c in "_-." else "_" for c in name).lstrip(".") or "take"


def facts_of(
    takes: Mapping[str, Found], recipe: Recipe, table: Mapping[str, Mapping[str, str]]
) -> tuple[dict[str, dict[str, str]], list[Failure]]:
    """Emotion, sentence, speaker and text of each take: the table's word, else the pattern's, else the default."""
    facts, failed = {}, []
    for name, recording in takes.items():
        row = dict(table.get(name) or table.get(recording.name) or table.get(recording.motion.name) or {})
        if "emotion" in row:
            row["emotion"] = recipe.emotion_of(row["emotion"])
        defaults = {"emotion": recipe.emotion, "speaker": recipe.speaker}
        try:
            by_name = {key: value for key, value in recipe.facts(name).items() if value}
        except InputError as problem:
            failed.append(Failure(name, str(recording.motion), f"{recording.motion}: {problem}"))
            continue
        facts[name] = dict.fromkeys(FIELDS, "") | defaults | by_name | row
    return facts, failed


def unused_rows(
    table: Mapping[str, Mapping[str, str]], found: Sequence[Found], takes: Mapping[str, Found]
) -> tuple[Note, ...]:
    """A warning if lines of the table name no recording."""
    known = {*takes, *(recording.name for recording in found), *(recording.motion.name for recording in found)}
    unused = [name for name in table if name not in known]
    if not unused:
        return ()
    return (Note("warning", f"{len(unused)} lines of the table name no recording, first {unused[0]!r}"),)


def jobs_for(
    takes: Mapping[str, Found],
    facts: Mapping[str, Mapping[str, str]],
    recipe: Recipe,
    frames: Mapping[str, Floats],
    corpus: Corpus,
    source: Path,
) -> list[Job]:
    """A job for every take whose speaker has a reference frame, in order of names."""
    base = source if source.is_dir() else source.parent
    return [
        Job(
            name=name,
            found=recording,
            recipe=recipe,
            facts=facts[name],
            reference=frames[facts[name]["speaker"]],
            corpus=str(corpus.folder),
            where=recording.motion.relative_to(base).as_posix(),
            fingerprint=_fingerprint(recording, recipe, facts[name], frames[facts[name]["speaker"]]),
        )
        for name, recording in sorted(takes.items())
        if facts[name]["speaker"] in frames
    ]


def _fingerprint(recording: Found, recipe: Recipe, facts: Mapping[str, str], reference: Floats) -> str:
    """Changes with the settings and with the names and sizes of the files."""
    files = [(path.name, path.stat().st_size) for path in recording.files]
    content = repr((_MAKER, recipe.digest(), sorted(facts.items()), recording.name, files)).encode()
    return hashlib.sha256(content + reference.astype(np.float32).tobytes()).hexdigest()[:16]


def references(
    takes: Mapping[str, Found],
    facts: Mapping[str, Mapping[str, str]],
    recipe: Recipe,
    corpus: Corpus,
    apart: bool = True,
) -> References:
    """Choose a reference frame for each new speaker; once chosen they stay, in ``reference.npz``.

    Recordings are read in a process of its own if ``apart``: a decoder that crashes on a damaged one costs no more.
    """
    path = corpus.folder / "reference.npz"
    speakers: dict[str, list[str]] = {}
    for name in sorted(takes):
        speakers.setdefault(facts[name]["speaker"], []).append(name)
    layout = str(corpus.about.get("layout", ""))
    frames = dict(_read_references(path)) if path.exists() else {}
    failed: list[Failure] = []
    for speaker, names in speakers.items():
        if speaker in frames:
            continue
        try:
            frame, found_layout = _chosen_apart(Choice([takes[name] for name in names], recipe, speaker), apart)
            if layout and layout != found_layout:
                raise InputError(f"speaker {speaker!r} has markers of layout {found_layout}, others of {layout}")
        except InputError as problem:
            failed += [Failure(name, str(takes[name].motion), str(problem)) for name in names]
            continue
        frames[speaker], layout = frame, found_layout
    with replace_when_complete(path) as unfinished:
        known = sorted(frames)
        np.savez(unfinished, speakers=np.array(known), frames=np.array([frames[speaker] for speaker in known]))
    return References(frames, layout, tuple(failed))


def _read_references(path: Path) -> dict[str, Floats]:
    with reading(path, "reference frames (delete it and import again)"):
        file = load_arrays(path)
        return {str(s): np.asarray(f) for s, f in zip(file["speakers"], file["frames"], strict=True)}


@dataclass(frozen=True)
class Choice:
    """Recordings of one speaker, to choose a reference frame from."""

    recordings: Sequence[Found]
    recipe: Recipe
    speaker: str


def _chosen_apart(choice: Choice, apart: bool) -> tuple[Floats, str]:
    """From the first recording that can be used."""
    problem: BaseException | None = None
    tries = [replace(choice, recordings=[recording]) for recording in choice.recordings[:_TRIED_FOR_REFERENCE]]
    for one in tries:
        _, result = next(iter(each(choose_reference, [one], 1 if apart else 0)))
        if not isinstance(result, BaseException):
            return result
        problem = problem or result
    if len(choice.recordings) == 1:
        raise InputError(str(problem))
    whose = f" of speaker {choice.speaker!r}" if choice.speaker else ""
    raise InputError(f"none of the first {len(tries)} recordings{whose} can be used; the first: {problem}")


def choose_reference(choice: Choice) -> tuple[Floats, str]:
    """The reference frame in one recording, and its layout."""
    recording, recipe = choice.recordings[0], choice.recipe
    raw = reader_named(recipe.reader).read(recording, recipe)
    layout = layout_for(recipe, raw, str(recording.motion))
    return reference_of(raw, recipe, layout, str(recording.motion)), layout.name
