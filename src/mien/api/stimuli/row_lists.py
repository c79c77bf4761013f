"""The manifest of a folder of stimuli, and counterbalanced lists."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mien.api.stimuli.design import COLUMNS, Stimulus
from mien.core.errors import InputError
from mien.core.files import replace_when_complete

__all__ = ["counterbalanced", "write_list"]


def counterbalanced(stimuli: Sequence[Stimulus], lists: int) -> list[list[Stimulus]]:
    """Parts stimuli into lists by a Latin square: the conditions of a sentence go round the lists.

    Parameters
    ----------
    stimuli : sequence of Stimulus
        The rows of one sentence are its conditions, in their order.
    lists : int
        How many.

    Raises
    ------
    InputError
        If ``lists`` is below 0.

    Examples
    --------
    >>> rows = [Stimulus(f"{word}{number}", word) for word in ("a", "b") for number in (1, 2)]
    >>> [[row.name for row in members] for members in counterbalanced(rows, 2)]
    [['a1', 'b2'], ['a2', 'b1']]
    """
    if lists < 0:
        raise InputError(f"a number of lists is 0 or more, not {lists}")
    place: dict[str, int] = {}
    next_condition: dict[str, int] = {}
    chosen: list[list[Stimulus]] = [[] for _ in range(lists)]
    for stimulus in stimuli if lists else ():
        first = place.setdefault(stimulus.sentence, len(place))
        condition = next_condition.get(stimulus.sentence, 0)
        next_condition[stimulus.sentence] = condition + 1
        chosen[(first + condition) % lists].append(stimulus)
    return chosen


def write_list(stimuli: Sequence[Stimulus], facts: Mapping[str, Mapping[str, Any]], path: Path) -> None:
    """One row for each stimulus: its file, what is known of it (by name), and its settings."""
    with replace_when_complete(path) as unfinished, unfinished.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["file", "frames", "seconds", "sha256", *COLUMNS])
        for stimulus in stimuli:
            known = facts[stimulus.name]
            digest = known["sha256"].get(stimulus.file, "")
            writer.writerow([stimulus.file, known["frames"], known["seconds"], digest, *stimulus.settings().values()])
