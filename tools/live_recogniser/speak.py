"""Makes speech with known phone times to learn the live recogniser from, for `learn.py`.

Sentences of the recording script and rows of random dictionary words, spoken by the 54 voices of Kokoro-82M
(Apache-2.0), of which 28 are English and the others have an accent, every second time by a mixture of two of them, and
by Festival's voices where they are installed (BSD-like). What is there already is kept, so that the work can be stopped
and taken up again. Times come from the forced alignment, or from Festival itself. One ``.npz`` per line: samples
(int16, 16 kHz), labels, starts, ends, speaker.
"""

from __future__ import annotations

import tarfile
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import MienError
from mien.core.utterance import Utterance
from mien.speech import synthesis
from mien.speech.voices import kokoro
from mien.speech.voices.catalogue import catalogue
from mien.text.normalisation import spoken_words
from mien.text.phones import phone_table
from mien.text.pronunciation import dictionary_entries

RATE = 16_000
SCRIPTED = 0.3  # share of lines that are sentences of the recording script
FESTIVAL = ("festival-slt", "festival-kal")
FESTIVAL_SHARE = 0.12


def make(package: str, folder: Path, number: int) -> None:
    """Speak the lines that are not there yet."""
    styles = all_styles(package)
    kokoro._styles = lambda: styles  # all voices in place of the four that ship
    folder.mkdir(parents=True, exist_ok=True)
    write = Lines()
    for place in range(number):
        random = np.random.default_rng([7, place])
        path = folder / f"{place:04d}.npz"
        if path.exists():
            continue
        try:
            keep(path, *spoken(write.line(random), styles, random))
        except MienError as problem:
            print(f"{place}: left out: {problem}", flush=True)


def keep(path: Path, utterance: Utterance, speaker: str) -> None:
    """Write sound, phones and times of one line."""
    phones = utterance.phones
    np.savez_compressed(
        path,
        samples=np.round(utterance.audio.resampled(RATE).samples * 32767).astype(np.int16),
        labels=np.array([phone.label for phone in phones]),
        starts=np.array([phone.start for phone in phones]),
        ends=np.array([phone.end for phone in phones]),
        speaker=speaker,
    )


def all_styles(package: str) -> dict[str, NDArray[np.float16]]:
    """Style vectors by voice."""
    styles = {}
    with tarfile.open(package) as archive:
        for member in archive.getmembers():
            name = Path(member.name).stem
            if "/voices/" in member.name and member.name.endswith(".bin"):
                content = archive.extractfile(member)
                assert content is not None
                styles[name] = np.frombuffer(content.read(), "<f4").reshape(-1, 256).astype(np.float16)
    return dict(sorted(styles.items()))


def spoken(text: str, styles: dict[str, NDArray[np.float16]], random: np.random.Generator) -> tuple[Utterance, str]:
    """A line by a voice that is drawn, and that voice's name."""
    if random.random() < FESTIVAL_SHARE:
        name = str(random.choice(FESTIVAL))
        if any(voice.name == name and voice.availability().installed for voice in catalogue()):
            return synthesis.synthesise(text, voice=name), name
    one, other = (str(name) for name in random.choice(sorted(n for n in styles if n != "mixed"), 2, replace=False))
    share = float(random.uniform(0.2, 0.8)) if random.random() < 0.5 else 0.0
    styles["mixed"] = ((1 - share) * styles[one] + share * styles[other]).astype(np.float16)
    voice = kokoro.Kokoro("mixed")
    words = spoken_words(text)
    return synthesis._aligned(words, voice, voice.speak(words, 0)), one if not share else f"{one}+{other}"


class Lines:
    """Sentences of the script, and rows of words of the dictionary."""

    def __init__(self) -> None:
        script = (files("mien") / "assets" / "scripts" / "english.txt").read_text(encoding="utf-8")
        self.sentences = [line.strip() for line in script.splitlines() if line.strip() and not line.startswith("#")]
        self.common = sorted({word.strip(".,!?") for line in self.sentences for word in line.split()})
        self.all = sorted({word for word, phones in dictionary_entries() if word.isalpha() and 3 <= len(phones) <= 8})
        assert len(phone_table()) == 39

    def line(self, random: np.random.Generator) -> str:
        """One line."""
        if random.random() < SCRIPTED:
            return str(random.choice(self.sentences))
        words = [
            str(random.choice(self.common if random.random() < 0.55 else self.all))
            for _ in range(random.integers(6, 12))
        ]
        return " ".join(words).lower().capitalize() + "."
