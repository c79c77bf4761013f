"""How well are lyrics laid on songs, by the level of the voice over the band? Writes docs/tables/song.md.

    python benchmarks/song.py              about four minutes on two cores
    python benchmarks/song.py --subset 1   one song

Songs are made (`made_songs`): synthetic voices with known phone times, vowels held 1.3 to 3 times as long and moved to
notes, a band of chords, bass and brushes behind. Word error is of starts and ends of words; a phone boundary counts
where its neighbours are the same phones in truth and answer.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from difflib import SequenceMatcher
from pathlib import Path

import numpy as np
from made_songs import SONGS, make_song

from mien.core.audio import Audio
from mien.core.errors import MienError
from mien.core.utterance import Utterance
from mien.speech.align import align
from mien.speech.song import align_song
from mien.speech.voices import catalogue

OUT = Path(__file__).parent.parent / "docs" / "tables" / "song.md"
LEVELS = (None, 20.0, 10.0, 5.0, 0.0)
VOICES = ("festival-slt", "espeak")
WAYS: dict[str, Callable[[Audio, str], Utterance]] = {"as speech": align, "as a song": align_song}


def errors(truth: Utterance, found: Utterance) -> tuple[list[float], list[float], int]:
    """Of words and of phones, seconds; and how many boundaries the truth has."""
    words = [abs(x) for a, b in zip(found.words, truth.words, strict=True) for x in (a.start - b.start, a.end - b.end)]
    one, other = [p.label for p in truth.phones], [p.label for p in found.phones]
    phones = [
        abs(found.phones.intervals[block.b + k].start - truth.phones.intervals[block.a + k].start)
        for block in SequenceMatcher(None, one, other, autojunk=False).get_matching_blocks()
        for k in range(1, block.size)
    ]
    return words, phones, len(truth.phones) - 1


def rows(names: list[str]) -> list[str]:
    installed = {voice.name for voice in catalogue() if voice.availability().installed}
    lines = []
    for voice in VOICES:
        if voice not in installed:
            raise SystemExit(f"the voice {voice} is not installed: make setup-festival, pip install espeakng-loader")
        for level in LEVELS:
            songs = [make_song(name, voice, level) for name in names]
            for way, aligner in WAYS.items():
                words, phones, all_of_them, failed = [], [], 0, 0
                for song in songs:
                    try:
                        w, p, n = errors(song.truth, aligner(song.audio, song.lyrics))
                    except MienError:
                        failed += 1
                        continue
                    words, phones, all_of_them = words + w, phones + p, all_of_them + n
                cells = ["-"] * 6
                if words:
                    cells = [
                        f"{1000 * np.median(words):.0f}",
                        f"{1000 * np.mean(words):.0f}",
                        f"{np.mean(np.array(words) <= 0.2):.0%}",
                        f"{1000 * np.median(phones):.0f}",
                        f"{np.mean(np.array(phones) <= 0.05):.0%}",
                        f"{len(phones) / all_of_them:.0%}",
                    ]
                shown = "no band" if level is None else f"{level:g} dB"
                lines.append("| " + " | ".join([voice, shown, way, *cells, str(failed)]) + " |")
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--subset", type=int, help="only so many songs")
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    names = list(SONGS)[: options.subset]
    head = (
        "| voice | voice over band | aligned | words: median ms | mean ms | ≤200 ms | phones: median ms | ≤50 ms "
        "| counted | failed |\n| " + " | ".join(["---"] * 10) + " |\n"
    )
    page = (
        "# Songs with their lyrics\n\nWritten by `python benchmarks/song.py` from "
        f"{len(names)} made songs of about 20 s by each voice; definitions stand at its head.\n\n"
        + head
        + "\n".join(rows(names))
        + "\n"
    )
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(page, encoding="utf-8")
    print(page)


if __name__ == "__main__":
    main()
