"""Reading recordings with hand-made labels for the benchmarks: timit-sample, emodb and grid-s1.

What is read here is only measured against; nothing that ships is learned from timit-sample or emodb.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.resources import files
from itertools import pairwise
from pathlib import Path

import numpy as np

from mien.core.audio import Audio
from mien.core.timeline import Interval
from mien.core.utterance import PAUSE
from mien.formats.sound_files import read_audio

# TIMIT's 61 labels onto the 39 phones (after Lee and Hon 1989); closures belong to the release that follows.
_FOLD = {"ao": "AO", "ax": "AH", "ax-h": "AH", "axr": "ER", "el": "L", "em": "M", "en": "N", "eng": "NG", "hv": "HH"}
_FOLD |= {"ix": "IH", "nx": "N", "dx": "D", "ux": "UW", "h#": PAUSE, "pau": PAUSE, "epi": PAUSE}
_CLOSURES = {"bcl": "B", "dcl": "D", "gcl": "G", "pcl": "P", "tcl": "T", "kcl": "K"}
_RELEASES = {"B": ("B",), "D": ("D", "JH"), "G": ("G",), "P": ("P",), "T": ("T", "CH"), "K": ("K",)}


@dataclass(frozen=True)
class Labelled:
    """A recording with its words and phones as a person, or the corpus, marked them."""

    name: str
    audio: Audio
    words: tuple[Interval, ...]
    phones: tuple[Interval, ...] = ()


def spread(items: list[Path], number: int | None) -> list[Path]:
    """At most ``number`` of the items, spread over all of them."""
    if number is None or number >= len(items):
        return items
    return [items[i * len(items) // number] for i in range(number)]


def is_damaged(audio: Audio) -> bool:
    """Whether the sound jumps as no speech does: bytes are missing, and what follows is noise.

    22 of the 80 files of the shared timit-sample are so; they are also shorter than their labels say.
    """
    return bool(np.abs(np.diff(audio.samples)).max(initial=0.0) > 40_000 / 32_768)


def timit(folder: Path, number: int | None = None) -> tuple[list[Labelled], int]:
    """Sound files of timit-sample, and how many damaged ones were left out."""
    sounds = {path: read_audio(path)[0] for path in sorted(folder.glob("*/*.flac"))}
    whole = [path for path, audio in sounds.items() if not is_damaged(audio)]
    found = []
    for path in spread(whole, number):
        audio = sounds[path]
        words = tuple(_timit_lines(path.with_suffix(".wrd")))
        phones = tuple(_folded(list(_timit_lines(path.with_suffix(".phn"))), audio.duration))
        found.append(Labelled(f"{path.parent.name}-{path.stem}", audio, words, phones))
    return found, len(sounds) - len(whole)


def _timit_lines(path: Path) -> Iterator[Interval]:
    for line in path.read_text(encoding="ascii").splitlines():
        first, last, label = line.split()
        yield Interval(int(first) / 16_000, int(last) / 16_000, label)


def _folded(labels: list[Interval], duration: float) -> Iterator[Interval]:
    """61 labels to 39 phones and pauses, each from the end of the one before, up to the end of the sound."""
    out: list[list[float | str]] = []
    for i, label in enumerate(labels):
        name = label.label
        if name == "q" and out:
            out[-1][1] = label.end
            continue
        if name in _CLOSURES:
            following = _FOLD.get(labels[i + 1].label, labels[i + 1].label.upper()) if i + 1 < len(labels) else ""
            if following in _RELEASES[_CLOSURES[name]]:
                out.append([label.start, label.end, "closure"])
                continue
        phone = PAUSE if name == "q" else _CLOSURES.get(name) or _FOLD.get(name) or name.upper()
        if out and out[-1][2] == "closure":
            out[-1][1:] = [label.end, phone]
        elif out and out[-1][2] == phone == PAUSE:
            out[-1][1] = label.end
        else:
            out.append([label.start, label.end, phone])
    for i, (start, end, phone) in enumerate(out):
        yield Interval(float(start), duration if i + 1 == len(out) else float(end), str(phone))


def emodb(folder: Path, number: int | None = None) -> list[Labelled]:
    """The sound files of emodb (cut at 2 s) with their phones on English ones; words are the runs between pauses."""
    table = tomllib.loads((files("mien") / "assets" / "phones" / "german_to_arpabet.toml").read_text("utf-8"))["phones"]
    found = []
    for path in spread(sorted((folder / "audio").glob("*.flac")), number):
        audio, _ = read_audio(path)
        phones = tuple(_german(folder / "phones" / f"{path.stem}.lablaut", table, audio.duration))
        if sum(phone.label != PAUSE for phone in phones) >= 3:
            found.append(Labelled(path.stem, audio, (), phones))
    return found


def _german(path: Path, table: dict[str, list[str]], duration: float) -> Iterator[Interval]:
    """Phones inside the sound, the last one cut with it. The time of a line is where its label starts."""
    out: list[tuple[float, str]] = [(0.0, PAUSE)]
    for line in path.read_text(encoding="latin-1").partition("\n#\n")[2].splitlines():
        fields = line.split(maxsplit=2)
        if len(fields) < 3 or fields[2].startswith(("-", "+")):  # a remark on the phone before
            continue
        label = fields[2].split()[0]
        phone = _english(label, table)
        is_part = label.startswith("!") or label.endswith("asp")
        if phone and not (out[-1][1] == phone and (is_part or phone == PAUSE)):
            out.append((float(fields[0]), phone))
    for (start, phone), (end, _) in pairwise(out):
        if start < duration - 0.02:
            yield Interval(start, min(end, duration), phone)


def _english(label: str, table: dict[str, list[str]]) -> str:
    """The English phone of a German label; "" if it is no sound of its own or unknown."""
    bare = label.lstrip("!_[").removesuffix("asp")
    phones = table.get(bare, [])
    return phones[0] if phones else ""


def grid(folder: Path, number: int) -> list[Labelled]:
    """Some sounds of grid-s1 with the corpus's own word times."""
    found = []
    for path in spread(sorted((folder / "audio").glob("*.flac")), number):
        lines = [line.split() for line in (folder / "words" / f"{path.stem}.align").read_text().splitlines()]
        words = [Interval(int(a) / 25_000, int(b) / 25_000, w) for a, b, w in lines if w not in ("sil", "sp")]
        found.append(Labelled(path.stem, read_audio(path)[0], tuple(words)))
    return found
