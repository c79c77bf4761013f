"""A mouth and a voice that remember what they did last: emotions and drawn intensities leave them as they are."""

from __future__ import annotations

import json
from collections import OrderedDict
from contextlib import suppress
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from threading import Lock
from typing import Any
from zipfile import BadZipFile

import numpy as np

from mien.core.audio import Audio
from mien.core.errors import InputError, Note, OutputError
from mien.core.files import replace_when_complete
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.utterance import Utterance
from mien.motion.mouth.hand_made_mouth import MouthMotion
from mien.motion.performer import MouthModel
from mien.serve.studio.lru_store import Kept

__all__ = ["RememberingMouth", "RememberingVoice"]


class RememberingMouth:
    """Another mouth, asked once for the same phones, sound and rate.

    Parameters
    ----------
    mouth : MouthModel
        Must give the same for the same utterance and rate, as all do.
    most : int
        How many performances are kept.
    """

    def __init__(self, mouth: MouthModel, most: int = 4) -> None:
        self.mouth, self._most = mouth, most
        self._kept: OrderedDict[tuple[object, ...], tuple[Audio, MouthMotion]] = OrderedDict()
        self._lock = Lock()

    def perform(self, utterance: Utterance, rate: FrameRate) -> MouthMotion:
        """As the other mouth."""
        audio = utterance.audio  # kept with its motion, so that no other sound comes by its id
        key = id(audio), utterance.phones, utterance.shapes, utterance.words, utterance.native, utterance.sung, rate
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key][1]
        motion = self.mouth.perform(utterance, rate)
        motion.values.setflags(write=False)
        motion.seal.setflags(write=False)
        with self._lock:
            self._kept[key] = audio, motion
            while len(self._kept) > self._most:
                self._kept.popitem(last=False)
        return motion


class RememberingVoice:
    """`mien.speech.synthesis.synthesise`, asked once for the same plain text: what is felt is given to it afterwards.

    Parameters
    ----------
    folder : Path or None
        What was said is kept here beyond the end of the program, so that a take need not be spoken again.
    most : int
        How many texts are kept in memory.
    most_bytes : int
        How much is kept in the folder; the oldest gives way.
    """

    def __init__(self, folder: Path | None = None, most: int = 16, most_bytes: int = 2**30) -> None:
        self._kept: Kept[Utterance] = Kept("speech", most)
        self._folder, self._most_bytes = folder, most_bytes

    def __call__(self, text: str, **asked: object) -> Utterance:
        """As `synthesise` does."""
        from mien.speech.synthesis import synthesise

        key = repr((text, sorted(asked.items())))
        if key in self._kept:
            return self._kept.get(key)
        said = self._read(key)
        if said is None:
            said = synthesise(text, **asked)  # type: ignore[arg-type]
            self._write(key, said)
        self._kept.put(said, name=key)
        return said

    def _path(self, key: str) -> Path:
        assert self._folder is not None
        name = sha256(f"{version('mien')} {key}".encode()).hexdigest()
        return self._folder / f"{name}.npz"

    def _read(self, key: str) -> Utterance | None:
        if self._folder is None or not self._path(key).is_file():
            return None
        try:
            with np.load(self._path(key), allow_pickle=False) as kept:
                told = json.loads(str(kept["told"]))
                tiers: dict[str, Any] = {
                    name: told[name] and _tier(told[name]) for name in ("words", "phones", "native")
                }
                shapes = tuple(tuple(names) for names in told["shapes"])
                notes = tuple(Note(kind, message) for kind, message in told["notes"])
                sound = Audio(kept["samples"], told["rate"])
                plain: dict[str, Any] = {name: told[name] for name in ("text", "language", "timing", "sung")}
                return Utterance(audio=sound, notes=notes, shapes=shapes, **tiers, **plain)
        except (ValueError, KeyError, TypeError, OSError, EOFError, BadZipFile, InputError):  # damaged: spoken again
            return None

    def _write(self, key: str, said: Utterance) -> None:
        if self._folder is None:
            return
        told = {
            **{name: getattr(said, name) for name in ("text", "language", "timing", "sung", "shapes")},
            **{name: _plain(getattr(said, name)) for name in ("words", "phones", "native")},
            "notes": [[note.kind, note.message] for note in said.notes],
            "rate": said.audio.rate,
        }
        with suppress(OSError, OutputError), replace_when_complete(self._path(key)) as unfinished:
            np.savez(unfinished, samples=said.audio.samples, told=json.dumps(told))
        with suppress(OSError):
            self._sweep()

    def _sweep(self) -> None:
        assert self._folder is not None
        files = sorted((path.stat().st_mtime, path.stat().st_size, path) for path in self._folder.glob("*.npz"))
        held = sum(size for _, size, _ in files)
        for _, size, path in files[:-1]:
            if held <= self._most_bytes:
                return
            path.unlink(missing_ok=True)
            held -= size


def _plain(tier: Tier | None) -> list[object] | None:
    return None if tier is None else [tier.name, [[one.start, one.end, one.label] for one in tier]]


def _tier(told: list[Any]) -> Tier:
    name, intervals = told
    return Tier(str(name), tuple(Interval(*one) for one in intervals))
