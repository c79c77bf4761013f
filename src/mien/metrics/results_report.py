"""Tables of scores in Markdown, and their place in a file of results."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from mien.core.errors import OutputError
from mien.core.files import check_writable, replace_when_complete
from mien.metrics.dynamics import CLASSES
from mien.metrics.evaluation import RECORDING, Evaluation
from mien.metrics.scores import METRICS, Score

__all__ = ["check_report", "markdown", "put_section"]

SHOWN_TABLES: tuple[tuple[str, ...], ...] = (
    ("opening_r", "opening_velocity_r", "opening_spread", "opening_bias", "opening_error_without_bias"),
    ("width_r", "width_velocity_r", "width_spread", "width_bias", "width_error_without_bias"),
    ("lips_rms", "lips_rms_frontal", "rms", "lip_vertex_error", "jitter"),
    ("closure_recall", "closure_precision", "closure_f1", "shut_f1", "speed_p99", "turns"),
    ("lag", "onset_lag", "in_sync"),
)
"""Which metrics of the shown face stand side by side; a table too wide to read is no table."""
TABLES: tuple[tuple[str, ...], ...] = (
    ("rms", "opening_r", "opening_error", "opening_velocity_r", "opening_velocity_error"),
    ("width_r", "width_error", "width_velocity_r", "width_velocity_error", "lip_vertex_error"),
    ("closure_recall", "closure_precision", "closure_f1", "shut_f1", "jitter"),
    ("lag", "onset_lag", "in_sync"),
)
"""The same of markers."""
Rows = Mapping[str, Mapping[str, Score]]
_WHOLE_TAKE = ("lag", "onset_lag", "in_sync")


def markdown(evaluation: Evaluation, heading: str) -> str:
    """Tables of an evaluation with a line on how it was made.

    Each cell is the figure with its 95 % bootstrap interval over takes; an en dash where it cannot be told.
    """
    lines = [heading, "", *_made(evaluation), ""]
    if evaluation.scores:
        lines += ["**As the default face shows it**", ""]
        lines += [*_tables(evaluation, evaluation.scores, SHOWN_TABLES), *_openings_table(evaluation.scores), ""]
        lines += [*_offset_lines(evaluation), ""]
    if len(evaluation.marker_scores) > 1 or not evaluation.scores:
        lines += ["**On markers**, of the rows that give markers", ""]
        lines += _tables(evaluation, evaluation.marker_scores, TABLES)
    lines += [_closure_line(evaluation), *_upper_face_line(evaluation)]
    lines += ["", *(f"* {note.message}" for note in evaluation.notes)]
    return "\n".join(lines).rstrip() + "\n"


def _tables(evaluation: Evaluation, scores: Rows, tables: Sequence[Sequence[str]]) -> list[str]:
    lines: list[str] = []
    for columns in tables:
        shown = [c for c in columns if not (evaluation.pooled and c in _WHOLE_TAKE)]
        if shown:
            lines += [*_table(scores, shown), ""]
    return lines


def _openings_table(scores: Rows) -> list[str]:
    """Median opening of each class of phones, and in brackets from a quarter to three quarters of them."""
    kinds = [kind for kind in CLASSES if any(math.isfinite(row[f"median_{kind}"].value) for row in scores.values())]
    lines = ["| opening by class: median (range of the middle half), mm | " + " | ".join(kinds) + " |"]
    lines += ["| --- |" + " ---: |" * len(kinds)]
    for model, row in scores.items():
        cells = [f"{_number(row[f'median_{kind}'])} ({_number(row[f'range_{kind}'])})" for kind in kinds]
        lines.append(f"| {model} | " + " | ".join(cells) + " |")
    return lines


def _number(score: Score) -> str:
    return f"{score.value:.1f}" if math.isfinite(score.value) else "–"


def _offset_lines(evaluation: Evaluation) -> list[str]:
    """What was removed from distances, mean over the mouth."""
    said = [
        f"{row}: "
        + ", ".join(
            f"{speaker or 'the speaker'} {x:+.1f} {y:+.1f} {z:+.1f}" for speaker, (x, y, z) in by_speaker.items()
        )
        for row, by_speaker in evaluation.offsets.items()
    ]
    if not said:
        return []
    return [
        "Constant offset per speaker, removed from distances (x y z, mean over the mouth, mm): " + "; ".join(said) + "."
    ]


def _made(evaluation: Evaluation) -> list[str]:
    how = "frames of all takes pooled" if evaluation.pooled else "each take scored, then averaged"
    what = f"{evaluation.takes} takes, {evaluation.frames} frames; {how}; intervals: 95 %, bootstrap over takes."
    parts = [_fold_text(fold.train, fold.test, sorted(fold.words)) for fold in evaluation.folds]
    return [f"{what} {parts[0]}"] if len(parts) == 1 else [what, *(["", *(f"* {p}" for p in parts)] if parts else [])]


def _fold_text(train: Sequence[str], test: Sequence[str], words: Sequence[str]) -> str:
    inside = f" inside the words {', '.join(words)}" if words else ""
    return f"Learned from {len(train)} takes, scored on {len(test)}{inside}."


def _table(scores: Rows, columns: Sequence[str]) -> list[str]:
    titles = [METRICS[c].title + (f" ({METRICS[c].unit})" if METRICS[c].unit else "") for c in columns]
    lines = ["| model | " + " | ".join(titles) + " |", "| --- |" + " ---: |" * len(columns)]
    for model, row in scores.items():
        cells = [_cell(row[c], METRICS[c].digits) for c in columns]
        lines.append(f"| {model} | " + " | ".join(cells) + " |")
    return lines


def _cell(score: Score, digits: int) -> str:
    if not math.isfinite(score.value):
        return "–"
    numbers = [f"{value:.{digits}f}" for value in (score.value, score.low, score.high)]
    value, low, high = ("0" + n[2:] if n.startswith("-") and not float(n) else n for n in numbers)
    return f"{value} ({low} to {high})"


def _closure_line(evaluation: Evaluation) -> str:
    rows = evaluation.scores or evaluation.marker_scores
    own = rows[RECORDING]["closure_f1"].value
    if not math.isfinite(own) or own == 0.0:
        return "Closures: not judged (no inner-lip markers, or no bilabial with speech on both sides)."
    shares = [f"{model} {scores['closure_f1'].value / own:.2f}" for model, scores in rows.items() if model != RECORDING]
    asked = f"{evaluation.bilabials} bilabials asked for"
    return f"Closures: {asked}; F1 as a share of the recording's own ({own:.2f}): {', '.join(shares)}."


def _upper_face_line(evaluation: Evaluation) -> list[str]:
    if evaluation.upper_face is None:
        return []
    signed, absolute = evaluation.upper_face
    return [
        "",
        "These models move the mouth alone. Upper-face dynamics deviation of a face whose upper part is still: "
        f"signed {signed:.2f} mm, absolute {absolute:.2f} mm.",
    ]


def check_report(path: str | Path) -> Path:
    """Say early whether a report can be written; it is a ``.md`` file.

    Raises
    ------
    OutputError
    """
    if not str(path).endswith(".md"):
        raise OutputError(f"a report is a Markdown file: give --report NAME.md, not {path}")
    return check_writable(path)


def put_section(path: str | Path, name: str, text: str) -> None:
    """Write a section of a Markdown file, in place of the older one of that name, or at the end.

    Sections stand between ``<!-- begin NAME -->`` and ``<!-- end NAME -->``; the rest of the file is kept.

    Raises
    ------
    OutputError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile; folder = tempfile.TemporaryDirectory(); file = Path(folder.name) / "results.md"
    >>> put_section(file, "one", "old"); put_section(file, "one", "new")
    >>> file.read_text().split()
    ['<!--', 'begin', 'one', '-->', 'new', '<!--', 'end', 'one', '-->']
    """
    path = check_report(path)
    begin, end = f"<!-- begin {name} -->", f"<!-- end {name} -->"
    section = f"{begin}\n{text.strip()}\n{end}"
    try:
        old = path.read_text(encoding="utf-8") if path.exists() else ""
    except (OSError, UnicodeDecodeError) as problem:
        raise OutputError(f"cannot add to {path}: {problem}") from problem
    pattern = re.compile(re.escape(begin) + ".*?" + re.escape(end), re.DOTALL)
    if pattern.search(old):
        new = pattern.sub(lambda _: section, old, count=1)
    else:
        new = (old.rstrip() + "\n\n" if old.strip() else "") + section + "\n"
    with replace_when_complete(path) as unfinished:
        unfinished.write_text(new, encoding="utf-8")
