"""Measure how well emotion is told from voices and write docs/tables/emotion.md.

    python benchmarks/emotion.py [CORPUS ...]      # default: emodb in MIEN_DATA or ../shared/data
    python benchmarks/emotion.py --neutral-alone   # only the last section again

The tables are those of `mien emotion-table CORPUS ... --report docs/tables/emotion.md`. Each CORPUS is a folder or
table as in docs/emotion.md; several of them add the rows across corpora. The last section is of neutral English, which
the classifier that ships (learned from German) should leave neutral: timit-sample and every tenth recording of grid-s1,
both in MIEN_DATA or ../shared/data.
"""

from __future__ import annotations

import os
import sys
from collections import Counter
from pathlib import Path

import numpy as np

from mien.cli import main
from mien.core.files import replace_when_complete
from mien.emotion.emotion_classifier import default_classifier
from mien.formats.sound_files import read_audio

HERE = Path(__file__).parent
TABLE = HERE.parent / "docs" / "tables" / "emotion.md"
HEADING = "## Neutral English"
NEUTRAL = {"timit-sample": ("timit-sample", 1), "grid-s1": ("grid-s1/audio", 10)}
SOUNDS = (".flac", ".wav")


def neutral_english(data: Path) -> str:
    """How much neutral English stays neutral, and what the rest is taken for."""
    lines = [
        HEADING,
        "",
        "Read by `mien emotion`; written by `python benchmarks/emotion.py`. All of it is neutral: what is not left "
        "neutral is a wrong face.",
        "",
        "| recordings | number | likeliest is neutral | left neutral | taken for | mean intensity of these |",
        "| --- | ---: | ---: | ---: | --- | ---: |",
    ]
    classifier = default_classifier()
    for name, (folder, step) in NEUTRAL.items():
        found = sorted(path for path in (data / folder).rglob("*") if path.suffix.lower() in SOUNDS)[::step]
        if not found:
            lines.append(f"| {name} | 0 | – | – | – | – |")
            continue
        read = [classifier.read(read_audio(path)[0]) for path in found]
        felt = [reading for reading in read if reading.emotion != "neutral"]
        wrong = ", ".join(f"{emotion} {number}" for emotion, number in Counter(r.emotion for r in felt).most_common())
        likeliest = sum(reading.most_likely == "neutral" for reading in read) / len(read)
        strength = f"{np.mean([reading.intensity for reading in felt]):.2f}" if felt else "–"
        kept = 1 - len(felt) / len(read)
        lines.append(f"| {name} | {len(read)} | {likeliest:.0%} | {kept:.0%} | {wrong or '–'} | {strength} |")
    return "\n".join(lines)


def run(arguments: list[str]) -> int:
    """Measure and write."""
    data = Path(os.environ.get("MIEN_DATA", HERE.parent.parent / "shared" / "data"))
    corpora = [given for given in arguments if given != "--neutral-alone"] or [str(data / "emodb" / "audio")]
    if "--neutral-alone" not in arguments:
        failed = main(["emotion-table", *corpora, "--report", str(TABLE)])
        if failed:
            return failed
    tables = TABLE.read_text(encoding="utf-8").partition(HEADING)[0].rstrip()
    with replace_when_complete(TABLE) as unfinished:
        unfinished.write_text(f"{tables}\n\n{neutral_english(data)}\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
