"""Recordings with an emotion on each: what the classifier of voices learns from and is judged by.

Three ways of saying which emotion a recording has, tried in this order:

* a table: a ``.csv`` with a header and the columns ``file`` (relative to the table), ``emotion`` and, if known,
  ``speaker``;
* a folder of files named as a known corpus names them (``assets/emotions/labels.toml``);
* a folder of folders named by emotions, ``EMOTION/NAME.wav`` or ``SPEAKER/EMOTION/NAME.wav``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from mien.core.assets import asset_table
from mien.core.errors import InputError, Note, unknown_name
from mien.core.table_rows import read_rows

__all__ = ["LabelledSound", "LabelledSounds", "emotion_of_label", "read_labelled_sounds", "speaker_of_name"]

_SOUNDS = {".wav", ".flac", ".ogg", ".aiff", ".aif", ".mp3", ".m4a", ".mp4"}
_MOST_NAMED = 3


@dataclass(frozen=True)
class LabelledSound:
    """One recording, its emotion, and who speaks (empty where that is not known)."""

    path: Path
    emotion: str
    speaker: str


@dataclass(frozen=True)
class LabelledSounds:
    """Recordings of one corpus.

    Attributes
    ----------
    name : str
    sounds : tuple of LabelledSound
        In the order of their paths or of the table.
    notes : tuple of Note
        What was left out, and how speakers were told.
    """

    name: str
    sounds: tuple[LabelledSound, ...]
    notes: tuple[Note, ...] = ()

    @property
    def emotions(self) -> tuple[str, ...]:
        """The emotions that occur, sorted."""
        return tuple(sorted({sound.emotion for sound in self.sounds}))

    @property
    def speakers(self) -> tuple[str, ...]:
        """Who speaks, sorted; empty if that is not known of every recording."""
        names = {sound.speaker for sound in self.sounds}
        return () if "" in names else tuple(sorted(names))


def emotion_of_label(label: str) -> str:
    """The emotion of mien's that a label of a corpus means.

    Raises
    ------
    InputError
        If the label is not known.

    Examples
    --------
    >>> emotion_of_label("Fearful"), emotion_of_label("boredom")
    ('afraid', 'neutral')
    """
    labels: dict[str, str] = _tables()["labels"]
    known = labels.get(label.strip().lower())
    if known is None:
        raise unknown_name("emotion", label, labels)
    return known


def read_labelled_sounds(source: str | Path) -> LabelledSounds:
    """Find the recordings of a labelled corpus, without opening them.

    Parameters
    ----------
    source : str or Path
        A table or a folder, see the module.

    Raises
    ------
    InputError
        If there are none, or a label is not understood.
    """
    path = Path(source)
    if path.is_file():
        if path.suffix.lower() != ".csv":
            raise InputError(f"{path}: expected a folder of labelled recordings or a .csv that lists them")
        return LabelledSounds(path.stem, _of_table(path))
    if not path.is_dir():
        raise InputError(f"{path}: no such folder or table")
    found = sorted(_sounds_in(path))
    if not found:
        raise InputError(f"{path}: holds no recording ({', '.join(sorted(_SOUNDS))})")
    return _of_names(path, found) or _of_folders(path, found)


def _sounds_in(folder: Path) -> Iterator[Path]:
    """All recordings in a folder and in what it links to; a folder that links back to one above is passed once."""
    seen: set[Path] = set()
    waiting = [folder]
    while waiting:
        here = waiting.pop()
        if here.resolve() in seen:
            continue
        seen.add(here.resolve())
        for path in here.iterdir():
            if path.is_dir():
                waiting.append(path)
            elif path.suffix.lower() in _SOUNDS and path.is_file():
                yield path


def speaker_of_name(path: str | Path) -> str | None:
    """Who speaks in a recording that is named as a known corpus names its recordings: corpus and speaker; else None.

    Examples
    --------
    >>> speaker_of_name("03-01-05-02-01-01-12.wav"), speaker_of_name("hello.wav")
    ('ravdess 12', None)
    """
    for name, naming in _tables()["naming"].items():
        match = re.fullmatch(naming["stem"], Path(path).stem)
        if match is not None:
            return f"{name} {match['speaker']}"
    return None


@lru_cache(maxsize=1)
def _tables() -> dict[str, Any]:
    return asset_table("emotions/labels.toml")


def _of_table(path: Path) -> tuple[LabelledSound, ...]:
    table = read_rows(path)
    columns = [name.lower() for name in table.rows[0][1]] if table.rows else []
    missing = [name for name in ("file", "emotion") if name not in columns]
    if missing:
        raise InputError(f"{path}: expected the columns file, emotion and speaker, got {', '.join(columns) or 'none'}")
    sounds = []
    for line, cells in table.rows[1:]:
        row = {column: cell for column, cell in zip(columns, cells, strict=False) if cell}
        sound = path.parent / row.get("file", "")
        if "file" not in row or not sound.is_file():
            raise InputError(f"{path}, line {line}: no such recording {row.get('file')!r}")
        try:
            emotion = emotion_of_label(row.get("emotion", ""))
        except InputError as problem:
            raise InputError(f"{path}, line {line}: {problem}") from problem
        sounds.append(LabelledSound(sound, emotion, row.get("speaker", "")))
    if not sounds:
        raise InputError(f"{path}: lists no recording")
    return tuple(sounds)


def _of_names(folder: Path, found: list[Path]) -> LabelledSounds | None:
    """Recordings named as a known corpus names them: one naming has to fit more than half of them."""
    for name, naming in _tables()["naming"].items():
        pattern = re.compile(naming["stem"])
        fits = [(path, match) for path in found if (match := pattern.fullmatch(path.stem))]
        if 2 * len(fits) > len(found):
            sounds = [
                LabelledSound(path, emotion_of_label(naming["codes"][match["emotion"]]), match["speaker"])
                for path, match in fits
            ]
            left = [path.name for path in found if path not in {p for p, _ in fits}]
            return LabelledSounds(_name_of(folder), tuple(sounds), _left_out(left, f"not named as in {name}"))
    return None


def _of_folders(folder: Path, found: list[Path]) -> LabelledSounds:
    sounds, left = [], []
    labels: Iterable[str] = _tables()["labels"]
    for path in found:
        parts = path.relative_to(folder).parts[:-1]
        where = [i for i, part in enumerate(parts) if part.strip().lower() in labels]
        if not where:
            left.append(str(path.relative_to(folder)))
            continue
        speaker = "/".join(parts[: where[-1]])
        sounds.append(LabelledSound(path, emotion_of_label(parts[where[-1]]), speaker))
    if not sounds:
        raise InputError(
            f"{folder}: cannot tell the emotions: expected folders named by emotions, names of a known corpus "
            f"({', '.join(_tables()['naming'])}), or a .csv with the columns file, emotion, speaker"
        )
    return LabelledSounds(_name_of(folder), tuple(sounds), _left_out(left, "in no folder named by an emotion"))


def _name_of(folder: Path) -> str:
    """A folder's name; its parent's where it is only called "audio"."""
    path = folder.resolve()
    return path.parent.name if path.name.lower() in ("audio", "wav", "sounds") else path.name


def _left_out(names: list[str], why: str) -> tuple[Note, ...]:
    if not names:
        return ()
    shown = ", ".join(names[:_MOST_NAMED]) + (", ..." if len(names) > _MOST_NAMED else "")
    return (Note("warning", f"{len(names)} recordings are left out, {why}: {shown}"),)
