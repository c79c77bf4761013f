"""From a folder of recordings to a corpus: find them, make a take of each on all cores, report.

A run that was stopped goes on where it was: each finished take has its line in ``importing.jsonl`` at once, and the
manifest takes those lines over at the end. What the takes look like does not depend on the number of workers: each is
made alone, and what they share (the layout, and one reference frame per speaker) is settled first.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError, MienError, Note, OutputError
from mien.core.files import held_alone, replace_when_complete
from mien.core.plain_text import parsed_json
from mien.corpus.capturing import capture_corpus
from mien.corpus.cheap_checks import cheap_faults
from mien.corpus.file_layout import located
from mien.corpus.import_plan import Failure, facts_of, jobs_for, named, references, unused_rows
from mien.corpus.import_preparation import Job, prepare_and_write
from mien.corpus.readers import Found, detect, reader_named
from mien.corpus.readers.mesh_recordings import mesh_with_faces, vertices_of
from mien.corpus.recipes import Recipe, load_recipe
from mien.corpus.recordings import Corpus, digest_of
from mien.corpus.transcripts import own_table, read_table
from mien.corpus.workers import each
from mien.text.languages import find_language

__all__ = ["Failure", "ImportReport", "Progress", "import_corpus"]

Progress = Callable[[int, int], None]
"""Called with how many takes are done and how many there are."""

VerticesFor = Callable[[Path, NDArray[np.float64], str], Mapping[str, int]]
"""A mesh with faces, its vertices in the file's order and a layout -> the vertex of each marker."""


@dataclass(frozen=True)
class ImportReport:
    """What an import did.

    Attributes
    ----------
    corpus : Corpus
    imported : tuple of str
        Takes made in this run.
    kept : tuple of str
        Takes that were there already, made from the same files by the same settings.
    failed : tuple of Failure
    notes : tuple of Note
        What concerns the whole source; what was done to single takes stands in their ``source["notes"]``.
    """

    corpus: Corpus
    imported: tuple[str, ...]
    kept: tuple[str, ...]
    failed: tuple[Failure, ...]
    notes: tuple[Note, ...]


def import_corpus(
    source: str | Path,
    folder: str | Path,
    *,
    recipe: str | Recipe | None = None,
    table: str | Path | None = None,
    name_pattern: str | None = None,
    emotion: str | None = None,
    speaker: str | None = None,
    language: str | None = None,
    workers: int | None = None,
    cluster: str | None = None,
    progress: Progress | None = None,
    vertices_for: VerticesFor | None = None,
) -> ImportReport:
    """Make a corpus of recordings, or go on with one.

    Parameters
    ----------
    source : path-like
        A folder of recordings, or one recording.
    folder : path-like
        Of the corpus; made if it is not there.
    recipe : str or Recipe, optional
        Name or file of a recipe; the default is found out from the source.
    table : path-like, optional
        CSV or TSV with ``name`` and any of text, emotion, sentence, speaker; goes before everything else. The
        default is the source's own ``table.csv``, if its first column is ``name``, as ``mien record`` writes it.
    name_pattern : str, optional
        Regular expression with named groups out of the same, held against the names.
    emotion, speaker : str, optional
        For takes of which nothing else says it.
    language : str, optional
        What is spoken: a tag such as ``"fi"``, or a phone map in a file (``docs/languages.md``); the default is the
        recipe's, which is English unless it says otherwise. Where a TextGrid gives the phones nothing is aligned.
    workers, cluster
        As in `mien.corpus.workers.each`.
    progress : callable, optional
    vertices_for : callable, optional
        Finds the markers in a mesh, for recordings that are meshes; `mien.import_corpus` gives it.

    Returns
    -------
    ImportReport
        One broken recording never stops the others: it is among ``failed``.

    Raises
    ------
    InputError
        If there is nothing to import, or an option cannot be used.
    OutputError
        If the corpus cannot be written.
    MissingPartError
        If an optional part that the source needs is not installed.
    """
    source, folder = Path(source), Path(folder)
    chosen = _recipe(source, recipe).with_changes(
        pattern=name_pattern, emotion=emotion, speaker=speaker, language=language
    )
    find_language(chosen.language)  # one that is not known is told once
    reader = reader_named(chosen.reader)
    found = reader.find(source)
    if not found:
        raise InputError(f"{source}: expected {reader.about}, found none")
    reader.needs()
    found, passed_over = located(found, source, chosen)
    if chosen.reader == "meshes" and not chosen.vertices and vertices_for is not None:
        mesh = mesh_with_faces(source, found[0].motion)
        chosen = chosen.with_changes(vertices=vertices_for(mesh, vertices_of(mesh), chosen.layout))
    takes, notes, failed = named(found, source)
    notes += passed_over
    table = table if table is not None else own_table(source)
    said, more = read_table(Path(table)) if table is not None else ({}, ())
    facts, strangers = facts_of(takes, chosen, said)
    notes += unused_rows(said, found, takes) + more
    takes = {name: recording for name, recording in takes.items() if name in facts}
    takes, hopeless = cheap_faults(takes, facts, source)  # before anything is tracked
    corpus = _created(folder, chosen)
    with held_alone(folder / ".importing", f"another import is writing into {folder}"):
        return _imported(
            corpus, takes, facts, chosen, source, workers, cluster, progress, notes, [*failed, *strangers, *hopeless]
        )


def _imported(
    corpus: Corpus,
    takes: Mapping[str, Found],
    facts: Mapping[str, Mapping[str, str]],
    chosen: Recipe,
    source: Path,
    workers: int | None,
    cluster: str | None,
    progress: Progress | None,
    notes: tuple[Note, ...],
    failed: Sequence[Failure],
) -> ImportReport:
    shared = references(takes, facts, chosen, corpus, apart=workers != 0)
    if corpus.about.get("layout") != shared.layout:
        corpus.describe(layout=shared.layout)
    jobs = jobs_for(takes, facts, chosen, shared.frames, corpus, source)
    journal = _journal(corpus)
    kept = [job.name for job in jobs if _is_done(job, corpus, journal)]
    hurt = [job.name for job in jobs if job.name in corpus.entries and job.name not in set(kept)]
    waiting = [job for job in jobs if job.name not in set(kept)]
    imported, broken = _run(waiting, corpus, workers, cluster, progress, len(jobs))
    failures = tuple(sorted([*failed, *shared.failed, *broken], key=lambda failure: failure.name))
    _finish(corpus, failures)
    notes += _told_of(hurt, set(imported))
    notes += _captured(corpus, workers, cluster)
    return ImportReport(corpus, tuple(sorted(imported)), tuple(sorted(kept)), failures, notes)


def _told_of(hurt: Sequence[str], imported: set[str]) -> tuple[Note, ...]:
    again = [name for name in hurt if name in imported]
    if not again:
        return ()
    names = ", ".join(again[:5]) + (" ..." if len(again) > 5 else "")
    return (Note("note", f"{len(again)} takes were changed, damaged or gone, and are made again: {names}"),)


def _recipe(source: Path, recipe: str | Recipe | None) -> Recipe:
    if isinstance(recipe, Recipe):
        return recipe
    return load_recipe(recipe if recipe is not None else detect(source).name)


def _created(folder: Path, recipe: Recipe) -> Corpus:
    try:
        about = {"layout": recipe.layout, "recipe": recipe.name, "licence": recipe.licence, "citation": recipe.citation}
        corpus = Corpus.create(folder, about)
    except OSError as problem:
        raise OutputError(f"cannot make a corpus in {folder}: {problem.strerror}") from problem
    if corpus.about.get("recipe", recipe.name) != recipe.name:
        raise InputError(
            f"{folder}: holds takes of recipe {corpus.about['recipe']!r}, not {recipe.name!r}; choose another folder"
        )
    return corpus


def _journal(corpus: Corpus) -> dict[str, dict[str, Any]]:
    """Takes that a stopped run had finished; a line that was cut off in the middle does not count."""
    path = corpus.folder / "importing.jsonl"
    entries = {}
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
        try:
            entry = parsed_json(line)
        except ValueError:
            continue
        entries[str(entry["name"])] = entry
    corpus.entries.update(entries)
    return entries


def _is_done(job: Job, corpus: Corpus, journal: Mapping[str, Mapping[str, Any]]) -> bool:
    entry = journal.get(job.name) or corpus.entries.get(job.name)
    if entry is None or entry["source"].get("fingerprint") != job.fingerprint:
        return False
    return _is_whole(job.name, corpus)


def _is_whole(name: str, corpus: Corpus) -> bool:
    """Whether a take reads, and holds what was written."""
    try:
        return digest_of(corpus.take(name)) == str(corpus.entries[name]["digest"])
    except InputError:
        return False


def _run(
    jobs: Sequence[Job],
    corpus: Corpus,
    workers: int | None,
    cluster: str | None,
    progress: Progress | None,
    total: int,
) -> tuple[list[str], list[Failure]]:
    imported: list[str] = []
    failed: list[Failure] = []
    before = total - len(jobs)
    with (corpus.folder / "importing.jsonl").open("a", encoding="utf-8") as journal:
        for job, result in each(prepare_and_write, jobs, workers, cluster):
            if isinstance(result, BaseException):
                corpus.entries.pop(job.name, None)
                failed.append(Failure(job.name, job.where, _reason(job, result)))
            else:
                corpus.entries[job.name] = result
                imported.append(job.name)
                journal.write(json.dumps(result, ensure_ascii=False) + "\n")
                journal.flush()
            if progress is not None:
                progress(before + len(imported) + len(failed), total)
    return imported, failed


def _captured(corpus: Corpus, workers: int | None, cluster: str | None) -> tuple[Note, ...]:
    """Capture the face's own motion; takes whose markers do not allow it stay takes of markers."""
    report = capture_corpus(corpus, workers, cluster)
    if not report.failed:
        return report.notes
    name, reason = report.failed[0]
    told = f"{len(report.failed)} of {len(corpus)} takes have markers only, no channels of the face; {name}: {reason}"
    return (*report.notes, Note("warning", told))


def _reason(job: Job, problem: BaseException) -> str:
    if isinstance(problem, MienError):
        return " ".join(str(problem).split())
    return f"{job.found.motion}: unexpected {type(problem).__name__}: {' '.join(str(problem).split())}"


def _finish(corpus: Corpus, failed: Sequence[Failure]) -> None:
    """Manifest, then the list of what did not become a take; the journal has done its duty."""
    corpus.write_manifest()
    with replace_when_complete(corpus.folder / "refused.jsonl") as unfinished:
        lines = [json.dumps({"name": f.name, "file": f.file, "reason": f.reason}, ensure_ascii=False) for f in failed]
        unfinished.write_text("".join(line + "\n" for line in lines), encoding="utf-8")
    (corpus.folder / "importing.jsonl").unlink(missing_ok=True)
