"""Recordings of a corpus that says in its folders what each of them is, as most public ones do."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from mien.core.errors import InputError, Note
from mien.corpus.readers.raw_recordings import Found
from mien.corpus.recipes import Recipe

__all__ = ["located"]


def located(found: Sequence[Found], source: Path, recipe: Recipe) -> tuple[list[Found], tuple[Note, ...]]:
    """Recordings named by their paths, with the sound and the transcript that the recipe places elsewhere.

    Parameters
    ----------
    found : sequence of Found
    source : Path
        The folder that paths begin at.
    recipe : Recipe
        Without ``paths`` nothing changes.

    Returns
    -------
    found : list of Found
        Those whose paths fit; their names are the pattern's groups with ``-`` between.
    notes : tuple of Note
        How many do not fit.

    Raises
    ------
    InputError
        If none fits.
    """
    if not recipe.paths:
        return list(found), ()
    base = source if source.is_dir() else source.parent
    fitting, others = [], []
    for recording in found:
        path = recording.motion.relative_to(base).with_suffix("").as_posix()
        match = re.fullmatch(recipe.paths, path)
        if match is None:
            others.append(path)
            continue
        groups = {name: value for name, value in match.groupdict("").items() if value}
        fitting.append(
            replace(
                recording,
                name="-".join(groups.values()),
                sound=_placed(recipe.sound, groups, base) or recording.sound,
                transcript=_placed(recipe.transcript, groups, base) or recording.transcript,
            )
        )
    if not fitting:
        raise InputError(
            f"{source}: no recording lies where the recipe {recipe.name} expects it; found {others[0]!r}, "
            f"expected paths such as {recipe.example!r}"
        )
    note = f"{source}: {len(others)} recordings passed over: their paths are not the recipe's, first {others[:1]}"
    return fitting, (Note("note", note),) if others else ()


def _placed(template: str, groups: Mapping[str, str], base: Path) -> Path | None:
    """The file that a template such as ``{speaker}/audio/{number}.m4a`` names, if it is there."""
    if not template:
        return None
    path = base / template.format_map(groups)
    return path if path.is_file() else None
