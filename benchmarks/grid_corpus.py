"""What the import makes of the recordings of GRID speaker 1.

    python benchmarks/grid_corpus.py                    imports them first (about ten minutes on two cores)
    python benchmarks/grid_corpus.py --corpus FOLDER    takes a corpus that was imported from them already

Writes docs/tables/corpus.md, and the same as a section of docs/results.md. Needs the shared recordings (MIEN_DATA, or
../shared/data beside the clone).
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.capture.cleaning.normalise import apply, best_similarity
from mien.capture.cleaning.tracker_jitter import JitterSettings, jitter, smooth_group
from mien.capture.layouts import load_layout
from mien.capture.tracker import tracker_python
from mien.core.errors import MissingPartError
from mien.corpus.checking import check_corpus
from mien.corpus.importing import import_corpus
from mien.corpus.recordings import Corpus
from mien.corpus.take import Take
from mien.metrics.results_report import put_section

ROOT = Path(__file__).parent.parent
OUT = ROOT / "docs" / "tables" / "corpus.md"
RESULTS = ROOT / "docs" / "results.md"
Floats = NDArray[np.float64]
TICKS = 25_000
VIDEOS = 6
CLOSED_MM = 0.75
LAYOUT = load_layout("mediapipe-218")
MOUTH = LAYOUT.index(LAYOUT.groups["mouth"])
UPPER_LIP, LOWER_LIP = LAYOUT.index(["2.2", "2.3"])


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--corpus", help="imported already")
    chosen = options.parse_args()
    data = Path(os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data")) / "grid-s1"
    with tempfile.TemporaryDirectory() as folder:
        if chosen.corpus:
            corpus = Corpus(chosen.corpus)
        else:
            corpus = import_corpus(data, Path(folder) / "corpus", recipe="grid").corpus
        parts = [head(), *imported(corpus, data), *words_table(corpus, data), *variance_table(corpus)]
        parts += [*jitter_table(corpus), *video_table(corpus, data, Path(folder))]
    OUT.parent.mkdir(parents=True, exist_ok=True)
    text = "\n".join(parts) + "\n"
    OUT.write_text(text, encoding="utf-8")
    put_section(RESULTS, "corpus", _one_level_down(text))
    print(OUT.read_text(encoding="utf-8"))


def _one_level_down(text: str) -> str:
    """Markdown whose headings stand two levels lower, as a section of a longer file."""
    return re.sub(r"^(#+) ", r"##\1 ", text, flags=re.MULTILINE)


def head() -> str:
    return (
        "# The corpus made of GRID speaker 1\n\n"
        "Written by `python benchmarks/grid_corpus.py` from the tracked recordings (Cooke et al. 2006, "
        "CC BY 4.0); definitions stand at its functions.\n"
    )


def imported(corpus: Corpus, data: Path) -> Iterator[str]:
    """What there is, and a reason for each recording that is not there."""
    with np.load(data / "markers.npz") as takes:
        names = sorted(takes.files)
        incomplete = {name for name in names if (takes[name] == -32768).any()}
    check = check_corpus(corpus)
    yield f"## Takes\n\n{len(corpus)} of {len(names)} recordings are takes.\n\n| what | how much |\n| --- | --- |"
    for name, value in check.rows():
        yield f"| {name} | {value} |"
    yield ""
    refused = [fault for fault in check.faults if fault.message.startswith("not in the corpus")]
    missing = sorted(set(names) - set(corpus.names))
    for name in missing:
        reasons = [fault.message for fault in refused if fault.name == name]
        yield f"- {name} is not a take: {reasons[0] if reasons else 'no reason on record'}"
    if not missing:
        yield "No recording was left out.\n"
    yield (
        f"In {len(incomplete)} recordings the tracker lost the face for some frames; they were filled (at the "
        f"start the first frame seen is held, single frames are bridged): {', '.join(sorted(incomplete))}.\n"
    )
    yield (
        "Doubts are stretches that the plausibility check of the alignment points at; nobody has listened to them.\n"
    )


def words_table(corpus: Corpus, data: Path) -> Iterator[str]:
    """Start of each word by our alignment against the supplied one, ms; positive: ours is later."""
    first, inner, ends = [], [], []
    for take in corpus:
        supplied = supplied_words(data / "words" / f"{take.name}.align")
        own = [(interval.start, interval.end, interval.label) for interval in take.words]
        if [label for *_, label in own] != [label for *_, label in supplied]:
            continue
        starts = [1000 * (mine[0] - theirs[0]) for mine, theirs in zip(own, supplied, strict=True)]
        first.append(starts[0])
        inner += starts[1:]
        ends.append(1000 * (own[-1][1] - supplied[-1][1]))
    yield "## Our word times against those supplied\n"
    yield "Start of a word (end, for the last row) by our alignment minus the supplied one; positive: ours is later.\n"
    yield "| words | number | median ms | middle half ms | within 20 ms | 50 | 100 |"
    yield "| --- | --- | --- | --- | --- | --- | --- |"
    for what, late in (
        ("first of a sentence", first),
        ("others", inner),
        ("all", first + inner),
        ("last, its end", ends),
    ):
        values = np.array(late)
        near = " | ".join(f"{(np.abs(values) <= limit).mean():.1%}" for limit in (20, 50, 100))
        low, high = np.quantile(values, [0.25, 0.75])
        yield f"| {what} | {len(values)} | {np.median(values):+.0f} | {low:+.0f} to {high:+.0f} | {near} |"
    yield ""


def supplied_words(path: Path) -> list[tuple[float, float, str]]:
    lines = (line.split() for line in path.read_text(encoding="utf-8").splitlines())
    return [(int(start) / TICKS, int(end) / TICKS, word) for start, end, word in lines if word not in ("sil", "sp")]


def spoken_frames(take: Take) -> slice:
    """From two frames before the first phone to two after the last."""
    phones = [interval for interval in take.phones if interval.label != "SIL"]
    rate = take.markers.rate
    return slice(max(0, rate.frame_at(phones[0].start) - 2), rate.frame_at(phones[-1].end) + 3)


def variance_table(corpus: Corpus) -> Iterator[str]:
    """Share of the variance of the 48 mouth landmarks in the first principal components."""
    every, spoken = [], []
    for take in corpus:
        mouth = take.markers.positions[:, MOUTH].reshape(len(take.markers), -1)
        every.append(mouth)
        spoken.append(mouth[spoken_frames(take)])
    yield "## Principal components of the mouth (48 landmarks)\n"
    yield "| frames | number | 1 | 2 | 3 | 4 | 5 | 8 |\n| --- | --- | --- | --- | --- | --- | --- | --- |"
    for what, frames in (
        ("all", np.concatenate(every)),
        ("from two before speech to two after", np.concatenate(spoken)),
    ):
        centred = frames - frames.mean(axis=0)
        values = np.linalg.eigvalsh(centred.T @ centred)[::-1]
        share = np.cumsum(values) / values.sum()
        yield f"| {what} | {len(frames)} | " + " | ".join(f"{share[n - 1]:.1%}" for n in (1, 2, 3, 4, 5, 8)) + " |"
    yield ""


def jitter_table(corpus: Corpus) -> Iterator[str]:
    """Before and after the jitter filter, which the GRID recipe leaves out so that scores refer to what was tracked."""
    before: dict[str, list[float]] = {"speech": [], "rest": []}
    after: dict[str, list[float]] = {"speech": [], "rest": []}
    depth: dict[str, list[float]] = {"before": [], "after": []}
    for take in corpus:
        smooth = smooth_group(take.markers, LAYOUT.groups["mouth"], JitterSettings())
        speech = spoken_frames(take)
        for track, sink, key in ((take.markers, before, "before"), (smooth, after, "after")):
            mouth = track.positions[:, MOUTH]
            sink["speech"].append(jitter(mouth[speech]))
            rest = max((mouth[: speech.start], mouth[speech.stop :]), key=len)
            if len(rest) > 5:
                sink["rest"].append(jitter(rest))
            depth[key] += closure_depths(take, track.positions)
    closed = {key: float((np.array(values) < CLOSED_MM).mean()) for key, values in depth.items()}
    yield "## Jitter of the mouth\n"
    yield (
        "Jitter as `mien.capture.cleaning.tracker_jitter.jitter` measures it, mm, median over takes; closures: least "
        f"lip opening within a /p b m/ with speech on both sides, mm, and how many are below {CLOSED_MM} mm. The "
        "recipe for GRID keeps the motion as tracked.\n"
    )
    yield "| motion | jitter at rest | jitter in speech | closures, median mm | closed |"
    yield "| --- | --- | --- | --- | --- |"
    for what, sink, key in (("as tracked", before, "before"), ("filtered", after, "after")):
        yield (
            f"| {what} | {np.median(sink['rest']):.3f} | {np.median(sink['speech']):.3f} | "
            f"{np.median(depth[key]):.2f} | {closed[key]:.1%} of {len(depth[key])} |"
        )
    yield ""


def closure_depths(take: Take, positions: Floats) -> list[float]:
    """Least lip opening within each bilabial that has speech on both sides, a frame wider on either side."""
    opening = np.linalg.norm(positions[:, UPPER_LIP] - positions[:, LOWER_LIP], axis=1)
    labels = [interval.label for interval in take.phones]
    depths = []
    for number, interval in enumerate(take.phones):
        inside = 0 < number < len(labels) - 1 and "SIL" not in (labels[number - 1], labels[number + 1])
        if inside and interval.label in ("P", "B", "M"):
            first, last = (take.markers.rate.frame_at(t) for t in (interval.start, interval.end))
            depths.append(float(opening[max(first - 1, 0) : last + 2].min()))
    return depths


def video_table(corpus: Corpus, data: Path, folder: Path) -> Iterator[str]:
    """The recorded video through the whole import against the landmarks supplied with the set."""
    yield "## Raw video against the landmarks supplied\n"
    try:
        tracker_python()
    except MissingPartError:
        yield "The face tracker is not installed here (`mien tracker install`), so this was not measured.\n"
        return
    source = folder / "video"
    source.mkdir()
    clips = sorted((data / "video").glob("*.mpg"))
    for path in clips[:: max(1, len(clips) // VIDEOS)][:VIDEOS]:
        shutil.copy(path, source)
        shutil.copy(data / "words" / f"{path.stem}.align", source)
    tracked = import_corpus(source, folder / "tracked", recipe="grid").corpus
    apart, alike = [], []
    for take in tracked:
        other = corpus.take(take.name).markers.positions
        own = take.markers.positions[: len(other)]
        fit = best_similarity(own.mean(axis=0), other.mean(axis=0), np.ones(own.shape[1]), scale=True)
        apart.append(float(np.sqrt(((apply(fit[None].repeat(len(own), 0), own) - other) ** 2).sum(axis=2).mean())))
        pair = [np.linalg.norm(p[:, UPPER_LIP] - p[:, LOWER_LIP], axis=1) for p in (own, other)]
        alike.append(float(np.corrcoef(*pair)[0, 1]))
    yield (
        f"{len(tracked)} clips tracked by `mien corpus import`: all 218 landmarks lie {np.mean(apart):.2f} mm (RMS) "
        f"from those supplied, after one similarity fit per clip; the lip openings correlate at {np.mean(alike):.3f}.\n"
    )


if __name__ == "__main__":
    main()
