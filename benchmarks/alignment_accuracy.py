"""How exact are alignment, recognition, the plausibility check and letters-to-sounds? Writes docs/tables/alignment.md.

    python benchmarks/alignment_accuracy.py --data FOLDER            about ten minutes on two cores
    python benchmarks/alignment_accuracy.py --data FOLDER --subset 8 a quick look

FOLDER holds timit-sample, emodb and grid-s1. Definitions:

* A phone boundary is counted where the two phones on its sides are the same in the labels and in the alignment
  (longest common rows of phones); ``counted`` says what share of the label's boundaries that is. Word boundaries are
  the starts and ends of all words: a text gives the same words on both sides.
* Error is the absolute difference in time. RTF is processor seconds, of all
  processes and with their start, over seconds of sound, one utterance at a time.
* Frame accuracy: share of instants 10 ms apart at which phone (39 and pause) or viseme (13 and rest, as
  assets/performance/visemes.toml has them; a diphthong goes by its first shape) is the same as in the labels.
"""

from __future__ import annotations

import argparse
import os
import random
import tomllib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from difflib import SequenceMatcher
from importlib.machinery import SourceFileLoader
from importlib.resources import files
from itertools import groupby
from pathlib import Path
from types import ModuleType

import hand_labels
import numpy as np
from hand_labels import Labelled

from mien.core.audio import Audio
from mien.core.errors import AlignmentError
from mien.core.timeline import Interval
from mien.core.utterance import PAUSE
from mien.speech.align import align_words, tiers
from mien.speech.aligned_phone import AlignedPhone
from mien.speech.connected_speech import heard_pronunciations
from mien.speech.recognise import Recogniser, recognise
from mien.speech.transcript_doubts import misfits
from mien.text.pronunciation import pronunciations

ROOT = Path(__file__).parent.parent
OUT = ROOT / "docs" / "tables" / "alignment.md"
GRID_UTTERANCES = 60
EMODB_FILES = 150
THREADS = 2
HELD_OUT = 1000
LIMITS = (0.01, 0.02, 0.05, 0.1)
Row = list[str]


def table(head: Row, rows: list[Row]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def error_row(name: str, errors: Sequence[float], counted: float, rtf: float) -> Row:
    e = np.abs(errors)
    shares = [f"{np.mean(e <= limit + 1e-9):.1%}" for limit in LIMITS]
    middle = [f"{1000 * np.median(e):.1f}", f"{1000 * e.mean():.1f}"]
    return [name, str(len(e)), f"{counted:.0%}", *middle, *shares, f"{1000 * np.median(errors):+.1f}", f"{rtf:.2f}"]


ERROR_HEAD = [
    "boundaries",
    "number",
    "counted",
    "median ms",
    "mean ms",
    "≤10 ms",
    "≤20",
    "≤50",
    "≤100",
    "bias ms",
    "RTF",
]


def phone_errors(labels: Sequence[Interval], found: Sequence[AlignedPhone]) -> Iterator[float]:
    """Differences of the boundaries whose neighbours are the same phones in both."""
    a, b = [x.label for x in labels], [x.label for x in found]
    for block in SequenceMatcher(None, a, b, autojunk=False).get_matching_blocks():
        for k in range(1, block.size):
            yield found[block.b + k].start - labels[block.a + k].start


def processor_seconds() -> float:
    """Of this process and of those that it started and saw end."""
    spent = os.times()
    return spent.user + spent.system + spent.children_user + spent.children_system


def aligned(item: Labelled) -> list[AlignedPhone]:
    words = [word.label for word in item.words]
    return align_words(item.audio, words, [heard_pronunciations(word) for word in words], connected=True)


def timit_tables(items: list[Labelled]) -> tuple[list[Row], list[Row]]:
    """Boundary errors of phones and words, and frame accuracy with and without the text."""
    phone_e: list[float] = []
    word_e: list[float] = []
    boundaries, seconds = 0, 0.0
    true_frames: list[tuple[float, float]] = []
    start = processor_seconds()
    for item in items:
        phones = aligned(item)
        seconds += item.audio.duration
        phone_e += phone_errors(item.phones, phones)
        boundaries += len(item.phones) - 1
        words, tier = tiers(phones, [word.label for word in item.words], item.audio.duration)
        pairs = list(zip(words, item.words, strict=True))
        word_e += [found.start - label.start for found, label in pairs]
        word_e += [found.end - label.end for found, label in pairs]
        true_frames.append(frame_accuracy(item.phones, tier.intervals))
    rtf = (processor_seconds() - start) / seconds
    errors = [
        error_row("TIMIT phones", phone_e, len(phone_e) / boundaries, rtf),
        error_row("TIMIT words", word_e, 1.0, rtf),
    ]
    frames = [["its true text, aligned", *means(true_frames), f"{rtf:.2f}"]]
    for recogniser in ("hama", "pocketsphinx"):
        frames.append(recognised_row(items, recogniser, seconds))
    return errors, frames


def recognised_row(items: list[Labelled], recogniser: Recogniser, seconds: float) -> Row:
    start = processor_seconds()
    found = [recognise(item.audio, recogniser=recogniser) for item in items]
    work = processor_seconds() - start
    scores = [frame_accuracy(item.phones, heard.phones.intervals) for item, heard in zip(items, found, strict=True)]
    return [f"no text, {recogniser}", *means(scores), f"{work / seconds:.2f}"]


def means(scores: list[tuple[float, float]]) -> Row:
    return [f"{value:.1%}" for value in np.mean(scores, axis=0)]


def frame_accuracy(labels: Sequence[Interval], found: Sequence[Interval]) -> tuple[float, float]:
    """Share of instants with the same phone, and with the same viseme."""
    visemes = tomllib.loads((files("mien") / "assets" / "performance" / "visemes.toml").read_text("utf-8"))["phones"]
    instants = np.arange(0.005, labels[-1].end, 0.01)
    a, b = ([row[i].label for i in _places(row, instants)] for row in (labels, found))
    shapes = [[visemes.get(label, [PAUSE])[0] for label in row] for row in (a, b)]
    same = [x == y for x, y in zip(a, b, strict=True)]
    alike = [x == y for x, y in zip(*shapes, strict=True)]
    return float(np.mean(same)), float(np.mean(alike))


def _places(row: Sequence[Interval], instants: np.ndarray) -> np.ndarray:
    return np.clip(np.searchsorted([x.start for x in row], instants, side="right") - 1, 0, len(row) - 1)


def emodb_row(items: list[Labelled]) -> Row:
    """German: the hand-made phones are the transcript, one long word between two pauses."""
    start = processor_seconds()
    with ThreadPoolExecutor(THREADS) as pool:
        found = list(pool.map(aligned_runs, items))
    work = processor_seconds() - start
    pairs = list(zip(items, found, strict=True))
    errors = [error for item, phones in pairs for error in phone_errors(item.phones, phones)]
    boundaries = sum(len(item.phones) - 1 for item in items)
    seconds = sum(item.audio.duration for item in items)
    return error_row("EmoDB phones (German)", errors, len(errors) / boundaries, work / seconds)


def aligned_runs(item: Labelled) -> list[AlignedPhone]:
    groups = groupby(item.phones, key=lambda phone: phone.label == PAUSE)
    runs = [tuple(phone.label for phone in group) for pause, group in groups if not pause]
    return align_words(item.audio, ["run"] * len(runs), [(run,) for run in runs])


def plausibility_rows(name: str, items: list[Labelled]) -> list[Row]:
    """Share of utterances with a warning, by what was done to the transcript."""
    chance = random.Random(7)
    spoilt: dict[str, list[tuple[Audio, list[str]]]] = {}
    for i, item in enumerate(items):
        words = [word.label for word in item.words]
        other = [word.label for word in items[(i + 1) % len(items)].words]
        place = chance.randrange(max(1, len(words) - 2))
        middle = (item.words[0].start + item.words[-1].end) / 2
        half = Audio(item.audio.samples[: round(middle * item.audio.rate)], item.audio.rate)
        cases = {
            "true transcript (false alarms)": (item.audio, words),
            "transcript of another utterance": (item.audio, other),
            "three words added": (item.audio, words[:place] + other[:3] + words[place:]),
            "two words left out": (item.audio, words[:place] + words[place + 2 :] or words[:1]),
            "second half of the sound missing": (half, words),
        }
        for case, pair in cases.items():
            spoilt.setdefault(case, []).append(pair)
    return [[name, case, str(len(pairs)), f"{warned(pairs):.1%}"] for case, pairs in spoilt.items()]


def warned(pairs: list[tuple[Audio, list[str]]]) -> float:
    with ThreadPoolExecutor(THREADS) as pool:
        return float(np.mean(list(pool.map(has_misfit, pairs))))


def has_misfit(pair: tuple[Audio, list[str]]) -> bool:
    audio, words = pair
    try:
        choices = [heard_pronunciations(word) for word in words]
        return bool(misfits(audio, align_words(audio, words, choices, connected=True)))
    except AlignmentError:
        return True


def trainer() -> ModuleType:
    """The script that trains letters-to-sounds."""
    return SourceFileLoader("train_letter_to_sound", str(ROOT / "tools" / "train_letter_to_sound.py")).load_module()


def letter_rows(subset: int | None) -> list[Row]:
    """Words held out of the training of letters-to-sounds: share right, and phone errors per phone."""
    letters = trainer()
    words = letters.words_of_dictionary()
    if subset is not None:
        words = words[:: max(1, len(words) // (5000 * subset))]
    train, test = letters.split_held_out(words, HELD_OUT if subset is None else 20 * subset)
    model = letters.learn(letters.paired_words(train), letters.THRESHOLDS)
    return [
        letter_row(f"mien's own, {len(train)} words learned", [model.phones(word) for word, _ in test], test),
        letter_row("hama (may have learned these words)", list(hama_phones([word for word, _ in test])), test),
    ]


def letter_row(name: str, found: list[tuple[str, ...]], test: list[tuple[str, tuple[str, ...]]]) -> Row:
    distances = [
        min((edits(x, y), len(y)) for y in pronunciations(word)) for x, (word, _) in zip(found, test, strict=True)
    ]
    right = np.mean([edit == 0 for edit, _ in distances])
    wrong = sum(edit for edit, _ in distances) / sum(length for _, length in distances)
    return [name, str(len(test)), f"{right:.1%}", f"{wrong:.1%}"]


def hama_phones(words: list[str]) -> Iterator[tuple[str, ...]]:
    from hama import G2PModel

    from mien.speech.recognise import _ipa_table

    model, ipa = G2PModel(), _ipa_table()
    longest = max(len(sign) for sign in ipa)
    for word in words:
        said, place, phones = "".join(model.predict(word).ipa), 0, []
        while place < len(said):
            sign = next((said[place : place + n] for n in range(longest, 0, -1) if said[place : place + n] in ipa), "")
            phones += ipa.get(sign, ())
            place += max(1, len(sign))
        yield tuple(phones)


def edits(a: Sequence[str], b: Sequence[str]) -> int:
    """Levenshtein distance."""
    row = list(range(len(b) + 1))
    for i, x in enumerate(a, start=1):
        before, row[0] = row[0], i
        for j, y in enumerate(b, start=1):
            before, row[j] = row[j], min(row[j] + 1, row[j - 1] + 1, before + (x != y))
    return row[-1]


def report(data: Path, subset: int | None) -> str:
    """The whole page of tables."""
    timit, damaged = hand_labels.timit(data / "timit-sample", subset)
    grid = hand_labels.grid(data / "grid-s1", subset or GRID_UTTERANCES)
    german = hand_labels.emodb(data / "emodb", subset or EMODB_FILES)
    errors, frames = timit_tables(timit)
    fit = plausibility_rows("TIMIT", timit) + plausibility_rows("GRID, one speaker, one grammar", grid)
    scope = "the default sample" if subset is None else f"a subset of {subset} files of each set"
    return "\n".join(
        [
            "# Alignment, recognition and pronunciation\n",
            f"Written by `python benchmarks/alignment_accuracy.py` from {scope}; definitions stand at its head. "
            f"TIMIT: {len(timit)} utterances; {damaged} more are left out because their sound files are damaged "
            "(bytes are missing, the rest is noise). EmoDB: "
            f"{len(german)} files through a map onto English phones, with the hand-made phones as transcript.\n",
            "## Boundaries against hand labels\n",
            table(ERROR_HEAD, [*errors, emodb_row(german)]),
            "## With and without a text (TIMIT)\n",
            table(["what is given", "frames with the right phone", "with the right viseme", "RTF"], frames),
            "## Does a warning come when text and sound do not fit?\n",
            "The limits were chosen on other spoilings of these same two sets, so expect somewhat worse elsewhere.\n",
            table(["set", "what was done", "utterances", "warned"], fit),
            "## Letters to sounds, on dictionary words held out\n",
            "A word is right if it is any pronunciation that the dictionary lists.\n",
            table(["model", "words", "right", "phone errors"], letter_rows(subset)),
        ]
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of timit-sample, emodb and grid-s1")
    parser.add_argument("--subset", type=int, help="only so many files of each set")
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    page = report(options.data, options.subset)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(page, encoding="utf-8")
    print(page)


if __name__ == "__main__":
    main()
