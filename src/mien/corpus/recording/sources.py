"""Where takes come from: `Source` is the contract, `PreparedFolder` takes recordings that are there already."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.core.limits import is_whole
from mien.corpus.readers.recording_files import SOUND, VIDEO
from mien.corpus.recording.folder import writing
from mien.corpus.recording.scripts import Line
from mien.formats.media import open_media
from mien.formats.sound_files import read_audio

__all__ = ["MOTION", "PreparedFolder", "Source", "sound_of"]

MOTION = (".c3d", ".npz", ".csv")


class Source(Protocol):
    """What gives a session its takes."""

    live: bool
    """Whether someone speaks now: then sentences are shown, counted down to, and judged by the speaker."""

    def take(self, line: Line, name: str, folder: Path, until_done: Callable[[], None]) -> list[Path]:
        """Make the files of one take in ``folder``; ``until_done`` returns when the speaker has finished.

        Raises
        ------
        InputError
            If this sentence cannot be had; the others may.
        """
        ...


def sound_of(files: list[Path]) -> Audio:
    """The sound of a take: its sound file, else the track of its video.

    Raises
    ------
    InputError
        If it has neither, or it cannot be read.
    """
    for suffixes in (SOUND, VIDEO):
        for path in files:
            if path.suffix.lower() in suffixes:
                return read_audio(path)[0]
    raise InputError(f"{files[0]}: no sound in it or beside it; put a WAV of the same name beside it")


class PreparedFolder:
    """Recordings that are there already: one per sentence, by its number or the name of the take.

    For sentence 7: ``007.mp4``, ``07.wav``, ``7.mov``, ``anna-happy-english-007.mp4``. A video, a sound, or motion
    (C3D, NPZ, CSV) with a sound of the same name.

    Parameters
    ----------
    folder : path-like

    Raises
    ------
    InputError
        If there is no such folder, or no recording in it.
    """

    live = False

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        if not self.folder.is_dir():
            raise InputError(f"{self.folder}: expected a folder of recordings named 001.mp4, 002.mp4...")
        kinds = (*VIDEO, *SOUND, *MOTION)
        self._files = sorted(p for p in self.folder.iterdir() if p.is_file() and p.suffix.lower() in kinds)
        if not self._files:
            raise InputError(f"{self.folder}: expected videos or sounds named 001.mp4, 002.mp4..., found none")

    def take(self, line: Line, name: str, folder: Path, until_done: Callable[[], None]) -> list[Path]:
        """Copy the recording of a sentence, after a look whether it can be read."""
        found = self._files_for(line, name)
        if not found:
            raise InputError(f"{self.folder}: no recording of sentence {line.number}; name it {line.label}.mp4")
        kinds: dict[str, Path] = {}
        for path in found:
            twin = kinds.setdefault(path.suffix.lower(), path)
            if twin != path:
                raise InputError(f"{path}: sentence {line.number} is in {twin} too; keep one")
        sound_of(found)
        for path in found:
            if path.suffix.lower() in VIDEO:
                _check_pictures(path)
        copies = []
        for path in found:
            copy = folder / f"{name}{path.suffix.lower()}"
            with writing(copy):
                shutil.copyfile(path, copy)
            copies.append(copy)
        return copies

    def _files_for(self, line: Line, name: str) -> list[Path]:
        return [p for p in self._files if p.stem == name or (is_whole(p.stem) and int(p.stem) == line.number)]


def _check_pictures(path: Path) -> None:
    import av

    with open_media(path, "a video") as container:
        if not container.streams.video:
            raise InputError(f"{path}: expected a video, got a file without pictures")
        try:
            if next(container.decode(container.streams.video[0]), None) is None:
                raise InputError(f"{path}: holds no picture")
        except av.FFmpegError as problem:
            raise InputError(f"{path}: the pictures cannot be read ({problem.strerror}): is it cut short?") from problem
