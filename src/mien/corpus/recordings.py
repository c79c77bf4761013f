"""`Corpus`: takes on disk in plain files that anything can read.

::

    CORPUS/
      corpus.json             {"format": "mien-corpus", "version": 1, "layout": ..., "licence": ..., "citation": ...}
      manifest.jsonl          one line per take: name, text, emotion, sentence, speaker, length, digests, source
      reference.npz           one frame per speaker on which all others were laid (written by an import)
      refused.jsonl           one line per recording that did not become a take (written by an import)
      audio/NAME.flac         the sound, 24 bit
      motion/NAME.npz         markers: (frames, markers, 3) float32 mm, names, rate as [numerator, denominator];
                              head: (frames, 4, 4) float64 where the head's motion is known;
                              channels, channel_names: (frames, channels) float32 where weights were recorded
      people.npz              the speakers' heads and neutral faces (`mien.corpus.capturing`)
      channels/NAME.npz       what was captured: channels (frames, channels) float32, names, stamp
      textgrid/NAME.TextGrid  words and phones

A take is there when its line is in the manifest; its files are written before its line.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.border import reading
from mien.core.errors import InputError
from mien.core.files import replace_when_complete
from mien.core.limits import load_arrays
from mien.core.plain_text import parsed_json
from mien.core.timeline import FrameRate, Tier
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.corpus.take import Take
from mien.formats.textgrid import read_textgrid, write_textgrid

__all__ = ["FORMAT", "VERSION", "Corpus"]

FORMAT, VERSION = "mien-corpus", 1
_TRACKED = frozenset({"grid"})
"""Recipes whose takes version 0.1 gave a tracker's own weights as channels: not recorded, so they are not read."""
_IN_EVERY_LINE = ("name", "text", "emotion", "sentence", "speaker", "digest", "source")


class Corpus:
    """Takes in a folder; opened, they are read one by one when asked for.

    Parameters
    ----------
    folder : str or Path
        Of an existing corpus (see `create` for a new one).

    Raises
    ------
    InputError
        If the folder holds no corpus, or one of another version.
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        self.about = self._read_about()
        self.entries: dict[str, dict[str, Any]] = self._read_manifest()

    @classmethod
    def create(cls, folder: str | Path, about: Mapping[str, str]) -> Corpus:
        """Make an empty corpus, or open the one that is there; ``about`` holds layout, licence, citation."""
        folder = Path(folder)
        if not (folder / "corpus.json").exists():
            for part in ("audio", "motion", "textgrid"):
                (folder / part).mkdir(parents=True, exist_ok=True)
            with replace_when_complete(folder / "corpus.json") as unfinished:
                content = {"format": FORMAT, "version": VERSION, **about}
                unfinished.write_text(json.dumps(content, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
        return cls(folder)

    @classmethod
    def files_only(cls, folder: Path) -> Corpus:
        """A corpus whose manifest is not read: for a process that only writes the files of takes."""
        corpus = cls.__new__(cls)
        corpus.folder, corpus.about, corpus.entries = Path(folder), {}, {}
        return corpus

    def describe(self, **about: str) -> None:
        """Change what the corpus says of itself (layout, licence, citation...)."""
        self.about |= about
        with replace_when_complete(self.folder / "corpus.json") as unfinished:
            unfinished.write_text(json.dumps(self.about, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")

    def files_of(self, name: str) -> tuple[Path, Path, Path]:
        """Where the sound, the motion and the TextGrid of a take lie."""
        return (
            self.folder / "audio" / f"{name}.flac",
            self.folder / "motion" / f"{name}.npz",
            self.folder / "textgrid" / f"{name}.TextGrid",
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the takes, sorted."""
        return tuple(sorted(self.entries))

    @property
    def unfinished(self) -> str:
        """What to say if an import was stopped or killed before its end; empty if none was."""
        journal = self.folder / "importing.jsonl"
        if not journal.exists():
            return ""
        made = len(journal.read_bytes().splitlines())
        return (
            f"{self.folder}: its import was not finished ({made} takes made and not in the corpus yet): "
            "run the same 'mien corpus import' again, it goes on where it stopped"
        )

    def __len__(self) -> int:
        return len(self.entries)

    def __iter__(self) -> Iterator[Take]:
        return (self.take(name) for name in self.names)

    def identity(self, name: str) -> str:
        """What tells a recording from every other, whatever its name and however it was imported (`identity_of`)."""
        known = self.entries[name].get("identity")
        return str(known) if known else identity_of(self.take(name))

    def take(self, name: str) -> Take:
        """Read one take.

        Raises
        ------
        InputError
            If there is no such take, or one of its files is missing or damaged.
        """
        if name not in self.entries:
            raise InputError(f"{self.folder}: no take {name!r} in this corpus of {len(self)}")
        entry = self.entries[name]
        markers, head, channels = self.motion(name)
        captured = None if channels is not None else self._captured(name, markers)
        grid = self.folder / "textgrid" / f"{name}.TextGrid"
        tiers = {tier.name: tier for tier in read_textgrid(grid)}
        if not {"words", "phones"} <= set(tiers):
            raise InputError(f"{grid}: expected the tiers words and phones, got {sorted(tiers)}; import the take again")
        return Take(
            name=name,
            audio=_read_sound(self.folder / "audio" / f"{name}.flac"),
            markers=markers,
            text=entry["text"],
            words=_without_blanks(tiers["words"]),
            phones=_without_blanks(tiers["phones"]),
            layout=str(self.about.get("layout", "")),
            head=head,
            emotion=entry["emotion"],
            sentence=entry["sentence"],
            speaker=entry["speaker"],
            source=entry["source"],
            channels=channels or captured,
            captured=captured is not None,
        )

    def motion(self, name: str) -> tuple[MarkerTrack, NDArray[np.float64] | None, ChannelTrack | None]:
        """Markers, head and recorded channels of a take, without its sound.

        Raises
        ------
        InputError
            If the file is missing or damaged.
        """
        motion = self.folder / "motion" / f"{name}.npz"
        try:
            with reading(motion, "the motion of a take"):
                file = load_arrays(motion)
                rate = FrameRate(Fraction(*(int(n) for n in file["rate"])))
                markers = MarkerTrack([str(n) for n in file["names"]], file["markers"], rate)
                head = np.array(file["head"]) if "head" in file else None
                channels = None
                if "channels" in file and self.about.get("recipe") not in _TRACKED:
                    channels = ChannelTrack([str(n) for n in file["channel_names"]], file["channels"], rate)
        except InputError as problem:
            raise InputError(f"{motion}: missing or damaged; import the take again ({problem})") from problem
        return markers, head, channels

    def has_recorded_channels(self, name: str) -> bool:
        """Whether the recording itself was of channels (face capture), so that nothing is captured from its markers."""
        return self.motion(name)[2] is not None

    def channel_stamp(self, name: str) -> str:
        """What the captured channels of a take were made with and from; empty if there are none."""
        try:
            return str(load_arrays(self._channel_file(name), only=lambda array: array == "stamp")["stamp"])
        except (InputError, KeyError):
            return ""

    def write_channels(self, name: str, channels: ChannelTrack, stamp: str) -> None:
        """Keep what was captured of a take (safe to call from several processes)."""
        moving = [column for column in range(len(channels.names)) if channels.values[:, column].any()]
        with replace_when_complete(self._channel_file(name)) as unfinished:
            np.savez_compressed(
                unfinished,
                channels=channels.values[:, moving].astype(np.float32),
                names=np.array([channels.names[column] for column in moving], dtype=np.str_),
                all_names=np.array(channels.names),
                stamp=np.array(stamp),
            )

    def _channel_file(self, name: str) -> Path:
        return self.folder / "channels" / f"{name}.npz"

    def _captured(self, name: str, markers: MarkerTrack) -> ChannelTrack | None:
        path = self._channel_file(name)
        if not path.exists():
            return None
        try:
            with reading(path, "captured channels"):
                file = load_arrays(path)
                moving = ChannelTrack([str(n) for n in file["names"]], file["channels"], markers.rate)
                found = moving.select([str(n) for n in file["all_names"]])
        except InputError as problem:
            raise InputError(f"{path}: damaged ({problem}); delete it and run 'mien corpus upgrade'") from problem
        return found if len(found) == len(markers) else None  # of an older import of the take

    def add(self, take: Take) -> None:
        """Write a take: first its files, then its line in the manifest. An older take of that name is replaced."""
        entry = self.write_files(take)
        self.entries[take.name] = entry
        self.write_manifest()

    def write_files(self, take: Take) -> dict[str, Any]:
        """Write the files of a take and return its line for the manifest (safe to call from several processes)."""
        with replace_when_complete(self.folder / "audio" / f"{take.name}.flac") as unfinished:
            take.audio.write(unfinished)
        rate = take.markers.rate.fraction
        arrays: dict[str, Any] = {
            "markers": take.markers.positions.astype(np.float32),
            "names": np.array(take.markers.names),
            "rate": np.array([rate.numerator, rate.denominator]),
        }
        if take.head is not None:
            arrays["head"] = take.head
        if take.channels is not None and not take.captured:
            arrays["channels"] = take.channels.values.astype(np.float32)
            arrays["channel_names"] = np.array(take.channels.names)
        with replace_when_complete(self.folder / "motion" / f"{take.name}.npz") as unfinished:
            np.savez_compressed(unfinished, **arrays)
        write_textgrid((take.words, take.phones), take.duration, self.folder / "textgrid" / f"{take.name}.TextGrid")
        return {
            "name": take.name,
            "text": take.text,
            "emotion": take.emotion,
            "sentence": take.sentence,
            "speaker": take.speaker,
            "seconds": round(take.duration, 6),
            "frames": len(take.markers),
            "digest": digest_of(take),
            "identity": identity_of(take),
            "source": take.source,
        }

    def write_manifest(self) -> None:
        """Write the manifest anew, takes in order of their names."""
        with replace_when_complete(self.folder / "manifest.jsonl") as unfinished:
            lines = (json.dumps(self.entries[name], ensure_ascii=False) + "\n" for name in self.names)
            unfinished.write_text("".join(lines), encoding="utf-8")

    def _read_about(self) -> dict[str, Any]:
        path = self.folder / "corpus.json"
        try:
            about = parsed_json(path.read_text(encoding="utf-8"))
        except (FileNotFoundError, NotADirectoryError) as problem:
            raise InputError(
                f"{self.folder}: expected a corpus (a folder with corpus.json); make one with 'mien corpus import'"
            ) from problem
        except (OSError, ValueError) as problem:
            raise InputError(f"{path}: damaged ({problem})") from problem
        if not isinstance(about, dict) or about.get("format") != FORMAT or about.get("version") != VERSION:
            raise InputError(f"{path}: expected format {FORMAT!r} version {VERSION}")
        return about

    def _read_manifest(self) -> dict[str, dict[str, Any]]:
        path = self.folder / "manifest.jsonl"
        if not path.exists():
            return {}
        try:
            lines = path.read_text(encoding="utf-8").splitlines()
        except (OSError, UnicodeDecodeError) as problem:
            raise InputError(f"{path}: damaged or not readable ({problem}); import the recordings again") from problem
        entries = {}
        for number, line in enumerate(lines, start=1):
            try:
                entry = parsed_json(line)
                missing = [key for key in _IN_EVERY_LINE if key not in entry]
            except (ValueError, TypeError) as problem:
                raise InputError(f"{path}, line {number}: expected one take as JSON ({problem})") from problem
            if missing:
                raise InputError(f"{path}, line {number}: expected one take, it lacks {', '.join(missing)}")
            entries[str(entry["name"])] = entry
        return entries


def identity_of(take: Take) -> str:
    """SHA-256 over the sound: the same recording has it under any name, recipe, reference frame or tracker.

    A take whose sound is silent is told by its motion as well.
    """
    if take.audio.is_silent():
        return digest_of(take)
    return hashlib.sha256(take.audio.samples.tobytes()).hexdigest()


def digest_of(take: Take) -> str:
    """SHA-256 over samples and marker positions (float32): whether the files are still those that were written."""
    value = hashlib.sha256()
    value.update(take.audio.samples.tobytes())
    value.update(take.markers.positions.astype(np.float32).tobytes())
    return value.hexdigest()


def _read_sound(path: Path) -> Audio:
    import soundfile

    try:
        samples, rate = soundfile.read(str(path), dtype="float64")
    except (soundfile.LibsndfileError, OSError) as problem:
        raise InputError(f"{path}: missing or damaged ({problem}); import the take again") from problem
    return Audio(samples, rate)


def _without_blanks(tier: Tier) -> Tier:
    return Tier(tier.name, tuple(interval for interval in tier if interval.label))
