"""`Journal`: what was done in the studio, on the disk as it happens, so that no crash takes it away.

A take is one file of JSON lines, each written and synced before it is answered. Sounds, faces and the state of the page
lie beside them. A line that was cut off by a crash is passed over; everything before it counts.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import shutil
import time
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import RLock
from typing import Any

import numpy as np

from mien.animation.edits import EMPTY, EditLayer, layer_of, plain_layer
from mien.core.audio import Audio
from mien.core.errors import InputError, Note
from mien.core.files import replace_when_complete
from mien.core.plain_text import parsed_json
from mien.serve.studio.lru_store import Missing, new_id
from mien.serve.studio.requests import FieldError, TakeRequest
from mien.serve.studio.settings import Limits
from mien.serve.studio.studio_takes import Source

__all__ = ["Journal", "Record", "Step", "folder_to_keep", "record_of", "step_of", "sweep"]

_ID = re.compile(r"[A-Za-z0-9_-]{8,32}")
_MOST_STEPS = 200
_LARGE = 2**21  # bytes of a file that is written anew when it is read
_LONGEST_NAME = 200


@dataclass(frozen=True)
class Step:
    """One state of a take, as undo and redo know it.

    Attributes
    ----------
    request : TakeRequest
    layer : EditLayer
    sound : str or None
        Digest of the uploaded sound; None where a voice speaks.
    """

    request: TakeRequest
    layer: EditLayer = EMPTY
    sound: str | None = None

    def plain(self) -> dict[str, Any]:
        """As JSON."""
        return {"request": self.request.plain(), "layer": plain_layer(self.layer), "sound": self.sound}

    def same_speech(self, other: Step) -> bool:
        """Whether only edits differ."""
        return self.request == other.request and self.sound == other.sound


@dataclass
class Record:
    """A take as the journal knows it: its name and all its steps.

    Attributes
    ----------
    name : str
        Given by the person, or the beginning of the text.
    made : float
        Seconds since 1970.
    steps : list of Step
    at : int
        Which of them is shown.
    """

    name: str
    made: float
    steps: list[Step] = field(default_factory=list)
    at: int = 0

    @property
    def step(self) -> Step:
        """The one that is shown."""
        return self.steps[self.at]

    def changed(self, keep: int, add: Sequence[Step], at: int) -> Record:
        """With the first ``keep`` steps, then others, and another one shown; the oldest of too many give way.

        Raises
        ------
        FieldError
            If there are not so many.
        """
        steps = [*self.steps[:keep], *add]
        if not 0 <= keep <= len(self.steps) or not 0 <= at < len(steps):
            raise FieldError("steps", f"the take has {len(self.steps)} steps: cannot keep {keep} and show {at}")
        gone = max(0, min(len(steps) - _MOST_STEPS, at))
        return replace(self, steps=steps[gone:], at=at - gone)

    def plain(self) -> dict[str, Any]:
        """As JSON."""
        steps = [step.plain() for step in self.steps]
        return {"name": self.name, "made": self.made, "steps": steps, "at": self.at}


class Journal:
    """All takes of a studio, and what the page looked like.

    Parameters
    ----------
    folder : Path
        Made if it is missing; only one studio at a time may have it (`folder_to_keep`).
    limits : Limits
    """

    def __init__(self, folder: Path, limits: Limits) -> None:
        self.folder, self._limits, self._lock = folder, limits, RLock()
        for name in ("takes", "sounds", "faces", "speech"):
            (folder / name).mkdir(parents=True, exist_ok=True)
        self.records: dict[str, Record] = {}
        self.faults: list[str] = []
        for path in sorted((folder / "takes").glob("*.jsonl")):
            self._read(path)

    def _read(self, path: Path) -> None:
        record: Record | None = None
        try:
            for number, line in enumerate(path.read_bytes().split(b"\n")):
                try:
                    told = parsed_json(line) if line.strip() else {}
                except ValueError:  # cut off by a crash
                    self.faults.append(f"{path.name}: line {number + 1} was cut off and is passed over")
                    continue
                record = _told(record, told, self._limits)
        except (InputError, KeyError, TypeError, ValueError, ArithmeticError, AttributeError, OSError) as problem:
            self.faults.append(f"{path.name}: {problem}")
        if record is not None and record.steps and _ID.fullmatch(path.stem):
            self.records[path.stem] = record
            if path.stat().st_size > _LARGE:
                self._written(path.stem, record)

    # ------------------------------------------------------------ takes

    def get(self, name: str) -> Record:
        """The record of an id; raises `mien.serve.studio.lru_store.Missing`."""
        with self._lock:
            if name not in self.records:
                raise Missing("there is no such take (any more)")
            return self.records[name]

    def add(self, record: Record, name: str | None = None) -> str:
        """Keep a new take; gives its id."""
        with self._lock:
            name = name if name and _ID.fullmatch(name) and name not in self.records else new_id()
            self._written(name, record)
            self.records[name] = record
            return name

    def change(self, name: str, keep: int, add: Sequence[Step], at: int) -> Record:
        """Change a take's steps (`Record.changed`)."""
        with self._lock:
            record = self.get(name).changed(keep, add, at)
            self._append(name, {"keep": keep, "add": [step.plain() for step in add], "at": at})
            self.records[name] = record
            return record

    def rename(self, name: str, called: object) -> Record:
        """Give a take another name."""
        called = " ".join(str(called).split())[:_LONGEST_NAME]
        if not called:
            raise FieldError("name", "expected a name, got an empty one")
        with self._lock:
            record = replace(self.get(name), name=called)
            self._append(name, {"name": called})
            self.records[name] = record
            return record

    def drop(self, name: str) -> None:
        """Delete a take: it moves to the folder ``deleted``, from where a person can take it back."""
        with self._lock:
            self.get(name)
            (self.folder / "deleted").mkdir(exist_ok=True)
            path = self._path(name)
            path.replace(self.folder / "deleted" / path.name)
            del self.records[name]

    def _path(self, name: str) -> Path:
        return self.folder / "takes" / f"{name}.jsonl"

    def _written(self, name: str, record: Record) -> None:
        with replace_when_complete(self._path(name)) as unfinished:
            unfinished.write_bytes(_line(record.plain()))

    def _append(self, name: str, told: dict[str, Any]) -> None:
        with self._path(name).open("r+b") as file:
            end = file.seek(0, os.SEEK_END)
            file.seek(max(end - 1, 0))
            broken = end > 0 and file.read(1) != b"\n"
            file.seek(end)
            file.write((b"\n" if broken else b"") + _line(told))
            file.flush()
            os.fsync(file.fileno())

    # ------------------------------------------------------------ sounds, faces, the page

    def keep_sound(self, source: Source) -> str:
        """Keep an uploaded sound; gives its digest."""
        path = self.folder / "sounds" / f"{source.digest}.npz"
        if not path.exists():
            notes = json.dumps([[note.kind, note.message] for note in source.notes])
            with replace_when_complete(path) as unfinished:
                np.savez(unfinished, samples=source.sound.samples, rate=source.sound.rate, notes=notes)
        return source.digest

    def sound(self, digest: str | None) -> Source | None:
        """An uploaded sound.

        Raises
        ------
        FieldError
            If it is not there any more.
        """
        if digest is None:
            return None
        path = self.folder / "sounds" / f"{digest}.npz"
        if not re.fullmatch(r"[0-9a-f]{64}", digest) or not path.is_file():
            raise FieldError("sound", "the recording of this take is not in the studio's folder any more")
        return _source(path)

    def add_sound(self, content: bytes, limits: Limits) -> str:
        """Keep the sound of a project's; gives its digest.

        Raises
        ------
        FieldError
            If it is damaged or too long.
        """
        source = _source(io.BytesIO(content))
        if source.sound.duration > limits.seconds:
            raise FieldError(
                "sound", f"the studio takes {limits.seconds:.0f} s of sound, got {source.sound.duration:.0f} s"
            )
        return self.keep_sound(source)

    def keep_page(self, state: Mapping[str, Any]) -> None:
        """Keep what the page looks like."""
        with self._lock, replace_when_complete(self.folder / "page.json") as unfinished:
            unfinished.write_text(json.dumps(state), "utf-8")

    def page(self) -> dict[str, Any]:
        """What the page looked like; empty at first."""
        with contextlib.suppress(OSError, ValueError):
            state = parsed_json((self.folder / "page.json").read_text("utf-8"))
            if isinstance(state, dict):
                return state
        return {}


def _source(file: Path | io.BytesIO) -> Source:
    try:
        with np.load(file, allow_pickle=False) as kept:
            notes = tuple(Note(kind, str(message)) for kind, message in parsed_json(str(kept["notes"])))
            samples = np.asarray(kept["samples"])
            return Source(Audio(samples, int(kept["rate"])), notes)
    except (ValueError, TypeError, KeyError, OSError, EOFError, zipfile.BadZipFile) as problem:
        raise FieldError("sound", f"the kept sound is damaged ({problem})") from problem


def step_of(told: Mapping[str, Any], limits: Limits) -> Step:
    """A step from JSON.

    Raises
    ------
    InputError
        If it does not hold together.
    """
    sound = told.get("sound")
    if sound is not None and not isinstance(sound, str):
        raise FieldError("sound", "expected the digest of a sound")
    asked = told["request"]
    if sound is None and asked.get("effort") == "auto":  # the default of earlier versions
        asked = {**asked, "effort": ""}
    request = TakeRequest.of(asked, limits, with_sound=sound is not None)
    return Step(request, layer_of(told["layer"]), sound)


def record_of(told: Mapping[str, Any], limits: Limits) -> Record:
    """A record from JSON, as `Record.plain` gives it.

    Raises
    ------
    InputError
        If it does not hold together.
    """
    try:
        record = _told(None, told, limits)
    except (KeyError, TypeError, ValueError, ArithmeticError, AttributeError) as problem:
        raise InputError(f"this is not a take of mien's studio ({type(problem).__name__}: {problem})") from problem
    if record is None or not record.steps or not 0 <= record.at < len(record.steps):
        raise InputError("this is not a take of mien's studio: it has no steps")
    return record


def _told(record: Record | None, told: Mapping[str, Any], limits: Limits) -> Record | None:
    """A record after one more line of its file."""
    if "steps" in told:
        steps = [step_of(step, limits) for step in told["steps"]]
        return Record(str(told["name"])[:_LONGEST_NAME], float(told["made"]), steps, int(told["at"]))
    if record is None:
        return None
    if "keep" in told:
        add = [step_of(step, limits) for step in told["add"]]
        return record.changed(int(told["keep"]), add, int(told["at"]))
    return replace(record, name=str(told["name"])) if "name" in told else record


def _line(told: Mapping[str, Any]) -> bytes:
    return json.dumps(told, separators=(",", ":")).encode() + b"\n"


# ---------------------------------------------------------------- where it lies


@contextlib.contextmanager
def folder_to_keep(asked: str | Path | None, temporary: Path) -> Iterator[tuple[Path, str]]:
    """The folder that a studio keeps its work in, held alone, and what a person should know of it.

    Parameters
    ----------
    asked : str, Path or None
        None: ``mien/studio`` where this system keeps a user's data.
    temporary : Path
        What is taken if the folder cannot be written, or another studio has it.
    """
    folder = Path(asked) if asked is not None else _home() / "mien" / "studio"
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        handle = os.open(folder / ".lock", os.O_CREAT | os.O_RDWR | os.O_CLOEXEC, 0o600)
    except OSError as problem:
        if asked is not None:
            raise InputError(f"cannot keep takes in {folder}: {problem.strerror}; give another --folder") from problem
        yield temporary, f"takes are not kept: {folder} cannot be written ({problem.strerror}); give --folder"
        return
    try:
        if _locked(handle):
            yield folder, f"takes are kept in {folder}"
        elif asked is not None:
            raise InputError(f"another studio keeps its takes in {folder}: close it, or give another --folder")
        else:
            yield temporary, f"takes are not kept: another studio uses {folder}; give this one a --folder of its own"
    finally:
        os.close(handle)


def _home() -> Path:
    given = os.environ.get("XDG_DATA_HOME") or os.environ.get("LOCALAPPDATA")
    with contextlib.suppress(RuntimeError):
        return Path(given) if given else Path.home() / ".local" / "share"
    return Path(os.devnull)


def _locked(handle: int) -> bool:
    """Whether a lock was to be had; where there are none, yes. It ends with the program, however that ends."""
    try:
        import fcntl
    except ImportError:
        return True
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True


def sweep(prefix: str, temporary: Path) -> int:
    """Remove temporary folders of studios that were killed; how many there were.

    A studio holds the lock in its folder as long as it runs; a folder without one is removed after a day.
    """
    swept = 0
    for folder in temporary.glob(f"{prefix}*"):
        with contextlib.suppress(OSError):
            lock = folder / ".lock"
            if not lock.exists() and time.time() - folder.stat().st_mtime < 86_400:
                continue
            if lock.exists():
                handle = os.open(lock, os.O_RDWR | os.O_CLOEXEC)
                try:
                    if not _locked(handle):
                        continue
                finally:
                    os.close(handle)
            shutil.rmtree(folder)
            swept += 1
    return swept
