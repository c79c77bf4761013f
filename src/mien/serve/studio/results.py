"""Files that exports made, until they give way to newer ones."""

from __future__ import annotations

import re
import shutil
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mien.animation.animation import Animation
from mien.core.errors import InputError, Note
from mien.face.model import Face
from mien.formats.registry import exporters
from mien.formats.saving import save
from mien.serve.studio.jobs import Job
from mien.serve.studio.lru_store import Kept, new_id
from mien.serve.studio.requests import FieldError
from mien.serve.studio.settings import Limits
from mien.serve.studio.views import Shown

__all__ = ["Export", "ResultFile", "ResultShelf", "checked_formats", "file_stem"]


@dataclass(frozen=True)
class ResultFile:
    """One file to fetch.

    Attributes
    ----------
    path : Path
        Where it lies, in a folder of its own under a name of the server's.
    name : str
        What to call it: letters, digits and hyphens of the line, and the suffix.
    """

    path: Path
    name: str


class ResultShelf:
    """Writes results and keeps them."""

    def __init__(self, folder: Path, limits: Limits) -> None:
        self._folder = folder
        self._files: Kept[ResultFile] = Kept("file", limits.files, limits.kept_bytes, _removed)

    def get(self, name: str) -> ResultFile:
        """A result by its id; raises `mien.serve.studio.lru_store.Missing`."""
        return self._files.get(name)

    def export(self, animation: Animation, export: Export, job: Job) -> tuple[str, str, tuple[Note, ...]]:
        """Write an animation in some formats; gives the id and the name of the file, a .zip if there are several.

        The third are the notes of the writers.

        Raises
        ------
        InputError
            If a format cannot be written.
        """
        folder = self._folder / new_id()
        folder.mkdir()
        try:
            made = [folder / f"{file_stem(animation)}{suffix}" for suffix in export.formats]
            notes: list[Note] = []
            for number, path in enumerate(made):
                notes += _written(animation, path, export, _Steps(job, number, export.formats))
            result = _packed(folder, f"{file_stem(animation)}.zip")
            job.at("done", 1.0)
            size = sum(path.stat().st_size for path in folder.iterdir())
            return self._files.put(ResultFile(result, result.name), size), result.name, tuple(notes)
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise


@dataclass(frozen=True)
class Export:
    """What is to be written.

    Attributes
    ----------
    face : Face or Path
        One of mien's, or a GLB of another maker.
    shown : Shown
        Camera and light of a video.
    formats : sequence of str
    """

    face: Face | Path
    shown: Shown
    formats: Sequence[str]


@dataclass(frozen=True)
class _Steps:
    """Tells a job how far the writing of one of its formats is."""

    job: Job
    number: int
    formats: Sequence[str]

    def __call__(self, done: int, total: int) -> None:
        self.job.at(f"writing {self.formats[self.number]}", (self.number + done / total) / len(self.formats))


def _written(animation: Animation, path: Path, export: Export, steps: _Steps) -> tuple[Note, ...]:
    steps(0, 1)
    try:
        return save(animation, path, face=export.face, view=export.shown.view(), progress=steps)
    except InputError as problem:
        told = str(problem).replace(str(path), path.name)
        told = told.replace(str(export.face), "the face") if isinstance(export.face, Path) else told
        raise InputError(told) from problem


def checked_formats(asked: object) -> tuple[str, ...]:
    """The suffixes of formats, each once, as they are spelt.

    Raises
    ------
    FieldError
        If there is none, or one is not known.
    MissingPartError
        If a library that one needs is not installed.

    Examples
    --------
    >>> checked_formats([".GLB", ".textgrid"])
    ('.glb', '.TextGrid')
    """
    known = {exporter.suffix.lower(): exporter.suffix for exporter in exporters()}
    if not isinstance(asked, list) or not asked or not all(isinstance(one, str) for one in asked):
        raise FieldError("formats", f"expected a list of formats out of {', '.join(known.values())}")
    for one in asked:
        if one.lower() not in known:
            raise FieldError("formats", f"unknown format {one[:20]!r}; known: {', '.join(known.values())}")
    chosen = tuple(dict.fromkeys(known[one.lower()] for one in asked))
    for exporter in exporters():
        if exporter.suffix in chosen:
            exporter.check()
    return chosen


def file_stem(animation: Animation) -> str:
    """A file name from the first words of a line: ASCII letters, digits and hyphens only.

    Examples
    --------
    >>> from mien.animation.animation import imported
    >>> from mien.core.timeline import FrameRate
    >>> from mien.core.tracks import ChannelTrack
    >>> file_stem(imported(ChannelTrack(("jawOpen",), [[0.0]], FrameRate.of(25)), "test"))
    'line'
    """
    words = re.findall(r"[a-z0-9]+", animation.utterance.text.lower())
    stem = "-".join(words[:6])[:40].strip("-")
    return stem or "line"


def _packed(folder: Path, name: str) -> Path:
    """The one file in a folder; an archive of all that is in it, if there is more (some formats keep a folder)."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    if len(files) == 1 and files[0].parent == folder:
        return files[0]
    with zipfile.ZipFile(folder / name, "w", zipfile.ZIP_DEFLATED, compresslevel=3) as archive:
        for path in files:
            archive.write(path, path.relative_to(folder).as_posix())
    for item in list(folder.iterdir()):
        if item.is_dir():
            shutil.rmtree(item)
        elif item.name != name:
            item.unlink()
    return folder / name


def _removed(file: ResultFile) -> None:
    shutil.rmtree(file.path.parent, ignore_errors=True)
