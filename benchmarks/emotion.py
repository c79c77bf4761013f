"""Measure how well emotion is told from voices and write docs/tables/emotion.md.

    python benchmarks/emotion.py [CORPUS ...]      # default: emodb in MIEN_DATA or ../shared/data
    python benchmarks/emotion.py --neutral-alone   # only the last section again

    python benchmarks/emotion.py --actors-alone    # only the section on actors of another corpus again

The tables are those of `mien emotion-table CORPUS ... --report docs/tables/emotion.md`. Each CORPUS is a folder or
table as in docs/emotion.md; several of them add the rows across corpora. The last section is of neutral English, which
the classifier that ships (learned from German) should leave neutral: timit-sample and every tenth recording of grid-s1,
both in MIEN_DATA or ../shared/data. Before it: actors of another corpus and language (ravdess-half there), from which
nothing was learned; the thresholds' two limits were set with it in view.
"""

from __future__ import annotations

import os
import sys
from collections import Counter
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.cli import main
from mien.core.files import replace_when_complete
from mien.corpus.labelled_sounds import read_labelled_sounds
from mien.emotion.emotion_classifier import EmotionClassifier, default_classifier
from mien.emotion.emotion_samples import EmotionSamples, emotion_samples
from mien.formats.sound_files import read_audio

HERE = Path(__file__).parent
Floats = NDArray[np.float64]
TABLE = HERE.parent / "docs" / "tables" / "emotion.md"
HEADING = "## Neutral English"
ACTORS = "## Actors of another corpus"
OTHERS, DRAWS = 5, 5
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


def of_actors(data: Path) -> str:
    """What is read from ravdess-half: alone, beside five other files of the actor, against five neutral ones."""
    corpus = read_labelled_sounds(data / "ravdess-half")
    samples, reader = emotion_samples(corpus, workers=0), default_classifier()
    truth, actors = np.array(samples.emotions), np.array(samples.speakers)
    strong = np.array([Path(name).stem.split("-")[3] == "02" for name in samples.names])
    others = partial(drawn, samples.features, actors, truth, reader)
    ways = {
        "alone": [np.broadcast_to(reader.usual_, samples.features.shape)],
        f"beside {OTHERS} others": [others(seed, False) for seed in range(DRAWS)],
        f"against {OTHERS} neutral": [others(seed, True) for seed in range(DRAWS)],
    }
    read = {way: [figures_of(samples, truth, strong, reader, base) for base in bases] for way, bases in ways.items()}
    rows = list(next(iter(read.values()))[0])
    lines = [
        ACTORS,
        "",
        f"ravdess-half: {len(truth)} recordings of {len(set(actors))} actors in English; nothing was learned from it. "
        f"Written by `python benchmarks/emotion.py`. Others are drawn {DRAWS} times. Six emotions are judged; "
        "`surprised` is not known to the reader. Kept: neutral and calm recordings that are left neutral. Strong "
        "takes: what a face shows of them, `--emotion auto` as in the first column. Stronger: of the same sentence by "
        "the same actor in the same emotion, how often the strong take reads as more stirred than the normal one.",
        "",
        "| | " + " | ".join(read) + " |",
        "| --- |" + " ---: |" * len(read),
    ]
    for row in rows:
        lines.append(
            f"| {row} | " + " | ".join(f"{np.mean([one[row] for one in found]):.2f}" for found in read.values()) + " |"
        )
    return "\n".join(lines)


def drawn(
    features: Floats,
    actors: NDArray[np.str_],
    truth: NDArray[np.str_],
    reader: EmotionClassifier,
    seed: int,
    calm: bool,
) -> Floats:
    """For each recording the baseline from others of its actor, shape (recordings, features)."""
    random = np.random.default_rng(seed)
    found = []
    for row in range(len(truth)):
        theirs = (actors == actors[row]) & (np.arange(len(truth)) != row) & ((truth == "neutral") | (not calm))
        found.append(reader.baseline_of(features[random.choice(np.flatnonzero(theirs), OTHERS, replace=False)], calm))
    return np.array(found)


def figures_of(
    samples: EmotionSamples, truth: NDArray[np.str_], strong: NDArray[np.bool_], reader: EmotionClassifier, base: Floats
) -> dict[str, float]:
    probabilities = reader.probabilities(samples.features, base)
    likeliest = np.array(reader.emotions)[probabilities.argmax(axis=1)]
    sure = probabilities.max(axis=1) >= np.array([reader.thresholds_[name] for name in likeliest])
    shown = np.where(sure, likeliest, "neutral")
    recall = {
        f"likeliest is right: {name}": float((likeliest == name)[truth == name].mean()) for name in reader.emotions
    }
    known = strong & np.isin(truth, reader.emotions) & (truth != "neutral")
    names = {Path(name).stem: row for row, name in enumerate(samples.names)}
    stirred = reader.activations(samples.features, base)
    pairs = [(row, names.get(f"{name[:9]}01{name[11:]}")) for name, row in names.items() if name[9:11] == "02"]
    return {
        **recall,
        "mean of six": float(np.mean(list(recall.values()))),
        "kept": float((shown == "neutral")[truth == "neutral"].mean()),
        "strong takes: right": float((shown == truth)[known].mean()),
        "strong takes: wrong": float(((shown != truth) & (shown != "neutral"))[known].mean()),
        "strong takes: none": float((shown == "neutral")[known].mean()),
        "stronger": float(np.mean([stirred[row] > stirred[weak] for row, weak in pairs if weak is not None])),
    }


def run(arguments: list[str]) -> int:
    """Measure and write."""
    data = Path(os.environ.get("MIEN_DATA", HERE.parent.parent / "shared" / "data"))
    only = {"--neutral-alone", "--actors-alone"} & set(arguments)
    corpora = [given for given in arguments if given not in only] or [str(data / "emodb" / "audio")]
    if not only and (failed := main(["emotion-table", *corpora, "--report", str(TABLE)])):
        return failed
    tables, _, rest = TABLE.read_text(encoding="utf-8").partition(HEADING)
    tables, _, actors = tables.partition(ACTORS)
    actors = ACTORS + actors if "--neutral-alone" in only else of_actors(data)
    neutral = HEADING + rest if "--actors-alone" in only else neutral_english(data)
    with replace_when_complete(TABLE) as unfinished:
        unfinished.write_text("\n\n".join(part.strip() for part in (tables, actors, neutral)) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
