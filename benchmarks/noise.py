"""What does noise do to alignment, recognition, live phones and warnings? Writes a part of docs/tables/noise.md.

    python benchmarks/noise.py --data FOLDER            about three minutes on one core
    python benchmarks/noise.py --data FOLDER --part before      with another version of mien on PYTHONPATH

FOLDER holds timit-sample, from which nothing was learned. Definitions:

* Every third undamaged utterance. Pink noise falls 3 dB an octave above 20 Hz; babble is six utterances of other
  speakers of the set at once. Its level lies below the mean power of the utterance by the decibels named.
* Frames: share of the frames (30 a second) in which the viseme is that of the hand-made phones at the same instant, as
  docs/tables/live.md has it. Loss: against the clean sound, in points.
* Warnings: how many stretches of true transcripts are said not to fit, in ten minutes of sound; in which share of the
  utterances a note names noise; and in which share a stretch is said not to fit when two words were left out of the
  transcript, three of another utterance were put in, or three were swapped for others.
"""

from __future__ import annotations

import argparse
import random
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import hand_labels
import numpy as np
from hand_labels import Labelled
from live_accuracy import RATE, labels_of, visemes
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.errors import AlignmentError
from mien.core.utterance import PAUSE, Utterance
from mien.speech.align import align
from mien.speech.phone_stream import PhoneStream
from mien.speech.recognise import recognise

OUT = Path(__file__).parent.parent / "docs" / "tables" / "noise.md"
CONDITIONS = (("clean", 0), ("pink", 10), ("pink", 5), ("babble", 10), ("babble", 5))
HEARD = 16_000
LOOK_AHEAD = 0.15
_HEAD = """# Noise

Written by `python benchmarks/noise.py`; definitions stand at its head. "Before" is commit 7eea77e, measured by
the same command.
"""

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Heard:
    """An utterance in noise."""

    item: Labelled
    audio: Audio
    words: list[str]
    others: list[str]


def pink(length: int, chance: np.random.Generator) -> Floats:
    """Pink noise."""
    spectrum = np.fft.rfft(chance.normal(size=length))
    return np.fft.irfft(spectrum / np.sqrt(np.maximum(np.arange(len(spectrum)), length * 20 / HEARD)), length)


def babble(length: int, others: Sequence[Labelled], chance: np.random.Generator) -> Floats:
    """Six utterances at once, each as loud."""
    made = np.zeros(length)
    for place in chance.choice(len(others), 6, replace=False):
        voice = others[place].audio.resampled(HEARD).samples.astype(np.float64)
        made += np.resize(np.roll(voice / voice.std(), int(chance.integers(len(voice)))), length)
    return made


def noisy(items: list[Labelled], place: int, kind: str, decibels: float) -> Heard:
    """One utterance with noise."""
    item, other = items[place], items[(place + 1) % len(items)]
    voice = item.audio.resampled(HEARD).samples.astype(np.float64)
    chance = np.random.default_rng([9, place, kind == "pink"])
    if kind != "clean":
        speaker = item.name.rpartition("-")[0]
        others = [one for one in items if one.name.rpartition("-")[0] != speaker]
        noise = pink(len(voice), chance) if kind == "pink" else babble(len(voice), others, chance)
        voice = voice + noise / noise.std() * voice.std() * 10 ** (-decibels / 20)
        voice *= min(1.0, 0.99 / np.abs(voice).max())
    words, strange = ([word.label for word in one.words] for one in (item, other))
    return Heard(item, Audio(voice.astype(np.float32), HEARD), words, strange)


def right(heard: Heard, found: Utterance | None) -> NDArray[np.bool_]:
    """In which frames the viseme is right."""
    times = RATE.times(RATE.frames_covering(heard.item.audio.duration))
    shown = [PAUSE] * len(times) if found is None else labels_of(found.phones.intervals, times)
    return np.array(visemes(shown)) == np.array(visemes(labels_of(heard.item.phones, times)))


def live(heard: Heard) -> NDArray[np.bool_]:
    """The same of a stream with 150 ms of look-ahead."""
    stream, shown, given = PhoneStream(), [], 0
    samples = np.concatenate([heard.audio.samples.astype(np.float64), np.zeros(HEARD)])
    times = RATE.times(RATE.frames_covering(heard.item.audio.duration))
    for seconds in times:
        upto = round((seconds + LOOK_AHEAD) * HEARD)
        stream.push(samples[given:upto])
        given = upto
        phone = stream.phones().at(seconds)
        shown.append(phone.label if phone else PAUSE)
    return np.array(visemes(shown)) == np.array(visemes(labels_of(heard.item.phones, times)))


def attempt(make: Callable[[], Utterance]) -> Utterance | None:
    """None where no way through was found."""
    try:
        return make()
    except AlignmentError:
        return None


def blames_text(found: Utterance | None) -> int:
    """Stretches that are said not to fit the text."""
    return 1 if found is None else sum("check the text" in note.message for note in found.notes)


def names_noise(found: Utterance | None) -> bool:
    """Whether a note says that there is noise, or voices."""
    return found is not None and any(re.search(r"\bnois[ey]", note.message) for note in found.notes)


def spoilt(heard: Heard, number: int) -> dict[str, list[str]]:
    """The transcript with two words left out, three put in, three swapped."""
    words, chance = heard.words, random.Random(number)
    place = chance.randrange(max(1, len(words) - 3))
    strange = heard.others[:3]
    return {
        "left out": words[:place] + words[place + 2 :],
        "put in": words[:place] + strange + words[place:],
        "swapped": words[:place] + strange + words[place + 3 :],
    }


def row(name: str, sounds: list[Heard], clean: dict[str, float]) -> str:
    """One line of the table."""
    true = [attempt(lambda h=h: align(h.audio, " ".join(h.words))) for h in sounds]
    shares = {
        "text": np.concatenate([right(h, found) for h, found in zip(sounds, true, strict=True)]).mean(),
        "none": np.concatenate([right(h, attempt(lambda h=h: recognise(h.audio))) for h in sounds]).mean(),
        "live": np.concatenate([live(h) for h in sounds]).mean(),
    }
    for key, share in shares.items():
        clean.setdefault(key, float(share))
    seconds = sum(h.audio.duration for h in sounds)
    noticed: dict[str, list[bool]] = {}
    for number, h in enumerate(sounds):
        for kind, words in spoilt(h, number).items():
            found = attempt(lambda h=h, words=words: align(h.audio, " ".join(words)))
            noticed.setdefault(kind, []).append(blames_text(found) > 0)
    cells = [f"{share:.1%} (−{100 * (clean[key] - share):.1f})" for key, share in shares.items()]
    cells += [f"{sum(map(blames_text, true)) / seconds * 600:.1f}", f"{np.mean([names_noise(f) for f in true]):.0%}"]
    cells += [f"{np.mean(flags):.0%}" for flags in noticed.values()]
    return f"| {name} | " + " | ".join(cells) + " |"


def section(items: list[Labelled], step: int) -> list[str]:
    """The lines of a part."""
    lines = [
        f"{len(items[::step])} utterances, {sum(item.audio.duration for item in items[::step]):.0f} s.\n",
        "| sound | frames right with the true text (loss) | without text | live, 150 ms "
        "| false alarms in 10 minutes | noise named | left out, noticed | put in | swapped |",
        "| --- " * 9 + "|",
    ]
    clean: dict[str, float] = {}
    for kind, decibels in CONDITIONS:
        name = kind if kind == "clean" else f"{kind}, {decibels} dB"
        lines.append(row(name, [noisy(items, place, kind, decibels) for place in range(0, len(items), step)], clean))
        print(lines[-1], flush=True)
    return lines


def main() -> None:
    """Measure, and write the part."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of timit-sample")
    parser.add_argument("--part", choices=("before", "now"), default="now")
    parser.add_argument("--step", type=int, default=3, help="every so many utterances (default 3)")
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    items, _ = hand_labels.timit(options.data / "timit-sample")
    body = "\n".join(section(items, options.step))
    page = options.out.read_text(encoding="utf-8") if options.out.exists() else _HEAD
    part = f"<!-- {options.part} -->\n## {options.part.capitalize()}\n\n{body}\n<!-- end of {options.part} -->\n"
    pattern = re.compile(f"<!-- {options.part} -->.*<!-- end of {options.part} -->\n", re.DOTALL)
    page = pattern.sub(lambda _: part, page) if pattern.search(page) else f"{page}\n{part}"
    options.out.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
