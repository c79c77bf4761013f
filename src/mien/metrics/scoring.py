"""Scoring anything: every task whose metrics apply to two faces in motion, as tables and as plain data."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mien.core.errors import InputError
from mien.core.files import replace_when_complete
from mien.core.plug_ins import plug_ins
from mien.core.timeline import FrameRate
from mien.corpus.recordings import Corpus
from mien.metrics import closure, dynamics, head_turns, mouth, sync, upper_face
from mien.metrics.face_track import FaceTrack
from mien.metrics.loading import Scorable, face_track_of

__all__ = ["TASKS", "Comparison", "evaluate", "mean_of", "score", "score_folders", "tasks", "write_csv"]

Task = Callable[[FaceTrack, FaceTrack], dict[str, float]]

TASKS: Mapping[str, Task] = {
    "mouth": mouth.evaluate,
    "upper face": upper_face.evaluate,
    "head": head_turns.evaluate,
    "closures": closure.evaluate,
    "sync": sync.evaluate,
    "dynamics": dynamics.evaluate,
}
"""What is asked of two faces, by the name of the task; other packages add theirs (`mien.core.plug_ins`)."""
_CURVE = ("r", "velocity_r", "spread", "bias", "error", "absolute")
_SUFFIXES = (".json", ".csv", ".c3d", ".npz")
_UNITS = {"_mm2": "mm²", "_mm_s": "mm/s", "_deg_s": "°/s", "_deg": "°", "_mm": "mm", "_ms": "ms", "_s": "1/s"}


@dataclass(frozen=True)
class Comparison:
    """All that was scored of one face against another.

    Attributes
    ----------
    reference, estimate : str
        What they are called.
    scores : mapping of str to mapping of str to float
        By task and name; the unit is at the end of the name; NaN where it cannot be known.
    skipped : mapping of str to str
        Why a task does not apply, by its name.
    notes : tuple of str
        What was done to bring the two to common ground.
    """

    reference: str
    estimate: str
    scores: Mapping[str, Mapping[str, float]]
    skipped: Mapping[str, str]
    notes: tuple[str, ...] = ()

    def flat(self) -> dict[str, float]:
        """All figures of all tasks in one dict."""
        return {name: value for figures in self.scores.values() for name, value in figures.items()}

    def as_json(self) -> str:
        """One JSON document; what cannot be known is null."""
        figures = {
            task: {name: (value if math.isfinite(value) else None) for name, value in by_name.items()}
            for task, by_name in self.scores.items()
        }
        content = {
            "reference": self.reference,
            "estimate": self.estimate,
            "scores": figures,
            "skipped": dict(self.skipped),
            "notes": list(self.notes),
        }
        return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)

    def __str__(self) -> str:
        lines = [f"Reference: {self.reference}", f"Estimate: {self.estimate}", ""]
        figures = self.flat()
        curves = [
            name[: -len("_spread")] for name in figures if name.endswith("_spread") and name[:-6] + "r" in figures
        ]
        if curves:
            lines += [*_curves_table(curves, figures), ""]
        told = {f"{name}_{part}" for name in curves for part in _CURVE}
        told |= {name for name in figures if any(name.startswith(f"{c}_{p}_") for c in curves for p in _CURVE[3:])}
        rest = {name: value for name, value in figures.items() if name not in told}
        beside = [name for name in rest if name.replace("_reference", "_estimate") in rest and "_reference" in name]
        if beside:
            lines += ["| figure | reference | estimate |", "| --- | ---: | ---: |"]
            lines += [
                f"| {_title(n.replace('_reference', ''))} | {_shown(rest[n])} | "
                f"{_shown(rest[n.replace('_reference', '_estimate')])} |"
                for n in beside
            ]
            lines += [""]
        single = [n for n in rest if n not in beside and n.replace("_estimate", "_reference") not in beside]
        lines += ["| figure | value |", "| --- | ---: |", *(f"| {_title(n)} | {_shown(rest[n])} |" for n in single), ""]
        lines += [*self.notes, *(f"not scored: {task}: {reason}" for task, reason in self.skipped.items())]
        return "\n".join(lines).rstrip()


def tasks() -> Mapping[str, Task]:
    """Every task that is scored: `TASKS`, then those of other packages by the names of their entry points."""
    brought = plug_ins("mien.metrics", callable, "a function of two FaceTracks")
    return {**TASKS, **{name: measure for name, (_, measure) in brought.items()}}


def evaluate(reference: FaceTrack, estimate: FaceTrack) -> Comparison:
    """Every task that applies.

    Raises
    ------
    InputError
        If none applies; the message gives the reason of the first.
    """
    scores: dict[str, Mapping[str, float]] = {}
    skipped: dict[str, str] = {}
    for task, measure in tasks().items():
        try:
            scores[task] = measure(reference, estimate)
        except InputError as problem:
            skipped[task] = " ".join(str(problem).split())
    if not scores:
        raise InputError(f"{reference.name} and {estimate.name} have nothing to score: {next(iter(skipped.values()))}")
    return Comparison(reference.name, estimate.name, scores, skipped, _notes(reference, estimate))


def score(reference: Scorable, estimate: Scorable, *, fps: float | str | FrameRate | None = None) -> Comparison:
    """Score one face in motion against another, whatever holds them.

    Parameters
    ----------
    reference, estimate : path, Animation, Take, ChannelTrack, MarkerTrack or FaceTrack
        As `mien.metrics.loading.face_track_of` takes them, in any mixture.
    fps : float, str, FrameRate or None
        Frame rate of a ``.csv`` that does not say it itself.

    Returns
    -------
    Comparison
        ``print`` it for the tables, ``flat()`` for a dict.

    Raises
    ------
    InputError
        If one cannot be read, or nothing applies.
    """
    return evaluate(face_track_of(reference, fps), face_track_of(estimate, fps))


def score_folders(
    reference: str | Path, estimate: str | Path, *, fps: float | str | FrameRate | None = None
) -> tuple[list[Comparison], tuple[str, ...]]:
    """Score all that two folders (corpora, or folders of files) hold under the same names.

    Returns
    -------
    comparisons : list of Comparison
        In order of the names.
    missing : tuple of str
        Names that only the reference has.

    Raises
    ------
    InputError
        If no name is in both, or one of a pair cannot be read.
    """
    one, other = _inside(Path(reference)), _inside(Path(estimate))
    both = [name for name in one if name in other]
    if not both:
        raise InputError(f"{reference} and {estimate}: no take or file of one has the name of one of the other")
    found = [score(one[name], other[name], fps=fps) for name in both]
    return found, tuple(name for name in one if name not in other)


def mean_of(comparisons: Sequence[Comparison], reference: str, estimate: str) -> Comparison:
    """Means over several comparisons; a figure that is not known of some is the mean of the others."""
    scores: dict[str, dict[str, float]] = {}
    for task in tasks():
        rows = [one.scores[task] for one in comparisons if task in one.scores]
        for name in dict.fromkeys(name for row in rows for name in row):
            values = [row[name] for row in rows if math.isfinite(row.get(name, math.nan))]
            scores.setdefault(task, {})[name] = float(np.mean(values)) if values else math.nan
    skipped = {task: why for one in comparisons for task, why in one.skipped.items() if task not in scores}
    told = [note for note in comparisons[0].notes if all(note in one.notes for one in comparisons)]
    return Comparison(reference, estimate, scores, skipped, (f"means over {len(comparisons)} pairs", *told))


def _inside(folder: Path) -> dict[str, Path]:
    """What can be scored in a corpus or a folder, by name."""
    if (folder / "corpus.json").is_file():
        return {name: folder / name for name in Corpus(folder).names}
    files = sorted(path for path in folder.iterdir() if path.suffix.lower() in _SUFFIXES)
    return {path.stem: path for path in files}


def write_csv(comparisons: Sequence[Comparison], path: str | Path) -> None:
    """Write a line for each figure: reference, estimate, task, figure, unit, value (empty where not known)."""
    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(("reference", "estimate", "task", "figure", "unit", "value"))
    for one in comparisons:
        for task, figures in one.scores.items():
            for name, value in figures.items():
                plain, unit = _unit(name)
                shown = repr(value) if math.isfinite(value) else ""
                lines.writerow((one.reference, one.estimate, task, plain, unit, shown))
    with replace_when_complete(path) as unfinished:
        unfinished.write_text(text.getvalue(), encoding="utf-8")


def _notes(reference: FaceTrack, estimate: FaceTrack) -> tuple[str, ...]:
    said = []
    if reference.rate != estimate.rate:
        said.append(f"resampled: {estimate.name} from {estimate.rate} to the reference's {reference.rate} frames/s")
    lengths = [len(track.landmarks) / track.rate.fps for track in (reference, estimate)]
    if abs(lengths[0] - lengths[1]) > 2 / min(reference.rate.fps, estimate.rate.fps):
        said.append(f"lengths: reference {lengths[0]:.2f} s, estimate {lengths[1]:.2f} s; scored as far as both last")
    if reference.phones is None and estimate.phones is None:
        said.append("phones are known of neither: all frames are scored, and bilabials are not asked for")
    if not (reference.depth and estimate.depth):
        said.append("depth was guessed by one camera: the frontal distances are the ones to believe")
    return tuple(said)


def _curves_table(curves: Sequence[str], figures: Mapping[str, float]) -> list[str]:
    lines = ["| curve | r | velocity r | spread | bias | error | absolute |", "| --- |" + " ---: |" * 6]
    for name in curves:
        unit = next(_UNITS[f"_{u}"] for u in ("mm", "deg") if f"{name}_bias_{u}" in figures)
        ending = "mm" if unit == "mm" else "deg"
        values = [figures[f"{name}_{part}"] for part in _CURVE[:3]]
        values += [figures[f"{name}_{part}_{ending}"] for part in _CURVE[3:]]
        cells = [_shown(values[0]), _shown(values[1]), _shown(values[2]), _signed(values[3]), *map(_shown, values[4:])]
        lines.append(f"| {name.replace('_', ' ')} ({unit}) | " + " | ".join(cells) + " |")
    return lines


def _title(name: str) -> str:
    plain, unit = _unit(name)
    return plain.replace("_", " ") + (f" ({unit})" if unit else "")


def _unit(name: str) -> tuple[str, str]:
    for ending, unit in _UNITS.items():
        if name.endswith(ending):
            return name[: -len(ending)], unit
    return name, ""


def _shown(value: float) -> str:
    if not np.isfinite(value):
        return "–"
    return f"{value:.0f}" if value == round(value) and abs(value) >= 10 else f"{value:.2f}"


def _signed(value: float) -> str:
    return f"{value:+.2f}" if np.isfinite(value) else "–"
