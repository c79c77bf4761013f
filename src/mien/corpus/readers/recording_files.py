"""Finding the files of a source, and those that belong together by their names."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection
from pathlib import Path

from mien.core.errors import InputError
from mien.corpus.readers.raw_recordings import Found

__all__ = ["SOUND", "TRANSCRIPTS", "VIDEO", "Beside", "found_by_suffix", "has_suffix", "listed"]

SOUND = (".wav", ".flac", ".ogg", ".aiff", ".aif", ".mp3", ".m4a")
VIDEO = (".mp4", ".mov", ".mkv", ".avi", ".mpg", ".mpeg", ".webm", ".m4v", ".mts", ".flv")
TRANSCRIPTS = (".textgrid", ".align", ".lab", ".txt")
"""Best first: if a recording has several, the first kind is taken."""


def listed(source: Path) -> list[Path]:
    """All files under a folder, or the one file, sorted; hidden files and folders are passed over.

    Raises
    ------
    InputError
        If there is no such file or folder.
    """
    if source.is_file():
        return [source]
    if not source.is_dir():
        raise InputError(f"{source}: expected a folder of recordings or one recording, there is nothing of that name")
    inside = (path for path in source.rglob("*") if path.is_file())
    return sorted(path for path in inside if not any(p.startswith(".") for p in path.relative_to(source).parts))


def has_suffix(source: Path, suffixes: Collection[str]) -> bool:
    """Whether a source has a file with one of these suffixes."""
    return any(path.suffix.lower() in suffixes for path in listed(source))


class Beside:
    """Files by the stem of their names.

    Parameters
    ----------
    source : Path
        A folder, or one file: then the files in its folder are looked at.
    """

    def __init__(self, source: Path) -> None:
        files = listed(source) if source.is_dir() else sorted(p for p in source.parent.iterdir() if p.is_file())
        self._by_stem: dict[str, list[Path]] = defaultdict(list)
        for path in files:
            self._by_stem[path.stem].append(path)

    def near(self, path: Path, suffixes: Collection[str]) -> Path | None:
        """The file of the same stem with the first of these suffixes that there is; the nearest folder wins."""
        rank = {suffix: number for number, suffix in enumerate(suffixes)}
        kin = [p for p in self._by_stem[path.stem] if p.suffix.lower() in rank and p != path]
        return min(kin, key=lambda p: (rank[p.suffix.lower()], -_shared(p, path), str(p)), default=None)


def _shared(one: Path, other: Path) -> int:
    count = 0
    for a, b in zip(one.parent.parts, other.parent.parts, strict=False):
        if a != b:
            break
        count += 1
    return count


def found_by_suffix(source: Path, suffixes: Collection[str]) -> list[Found]:
    """A recording for every file with one of these suffixes, with the sound and transcript that share its name."""
    beside = Beside(source)
    return [
        Found(path.stem, path, beside.near(path, SOUND), beside.near(path, TRANSCRIPTS))
        for path in listed(source)
        if path.suffix.lower() in suffixes
    ]
