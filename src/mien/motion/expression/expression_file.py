"""Recorded expressions in a performer's file (`mien.motion.performer_file`): ``expression/...``.

Curves are kept in 32 bits and carried channels in 16; `rounded` does so at once, so that a performer moves alike before
and after it was saved.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core import channels
from mien.core.errors import Note
from mien.motion.em_pca import EMPCA
from mien.motion.expression.expression_space import RATE, ExpressionSettings, ExpressionSpace

__all__ = ["PREFIX", "RecordedExpressions", "expression_arrays", "expression_content", "expressions_from", "rounded"]

PREFIX = "expression/"
Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class RecordedExpressions:
    """What was learned of a person's expressions.

    Attributes
    ----------
    space : ExpressionSpace
        Carries `mien.core.channels.ALL`: what the default face does where the speaker's markers move so.
    notes : tuple of Note
        Which takes were left out, and why; not kept in files.
    """

    space: ExpressionSpace
    notes: tuple[Note, ...] = ()

    @property
    def seconds(self) -> dict[str, float]:
        """Seconds of expressive motion by emotion."""
        return {name: sum(map(len, curves)) / RATE for name, curves in self.space.curves_.items()}


def rounded(space: ExpressionSpace) -> ExpressionSpace:
    """The space as it will be after it was saved and loaded."""
    for rows, kind in ((space.curves_, np.float32), (space.carried_, np.float16)):
        for name, found in rows.items():
            rows[name] = tuple(piece.astype(kind).astype(np.float64) for piece in found)
    return space


def expression_content(recorded: RecordedExpressions) -> dict[str, Any]:
    """What goes into ``performer.json``."""
    space = recorded.space
    return {
        "components": space.settings.components,
        "channels": [channels.ALL[column] for column in _used(space)],
        "lengths": {name: [len(piece) for piece in curves] for name, curves in space.curves_.items()},
        "share": space.space_.share_,
        "steps": space.space_.steps_,
    }


def _used(space: ExpressionSpace) -> list[int]:
    """Columns of the carried channels that ever move."""
    moves = np.zeros(len(channels.ALL), dtype=bool)
    for carried in space.carried_.values():
        for piece in carried:
            moves |= piece.any(axis=0)
    return np.flatnonzero(moves).tolist()


def expression_arrays(recorded: RecordedExpressions) -> Arrays:
    """What goes into the file as arrays."""
    space, used = recorded.space, _used(recorded.space)
    arrays: Arrays = {
        f"{PREFIX}mean": space.space_.mean_,
        f"{PREFIX}axes": space.space_.axes_,
        f"{PREFIX}variances": space.space_.variances_,
    }
    for name in space.curves_:
        arrays[f"{PREFIX}curves/{name}"] = np.concatenate(space.curves_[name]).astype(np.float32)
        arrays[f"{PREFIX}carried/{name}"] = np.concatenate(space.carried_[name])[:, used].astype(np.float16)
    return arrays


def expressions_from(content: Mapping[str, Any], arrays: Arrays) -> RecordedExpressions:
    """The way back from `expression_content` and `expression_arrays`.

    Raises
    ------
    KeyError, ValueError
        If something is missing or does not fit.
    """
    space = ExpressionSpace(ExpressionSettings(components=int(content["components"])))
    pca = EMPCA(space.settings.components)
    pca.mean_, pca.axes_, pca.variances_ = (arrays[PREFIX + name] for name in ("mean", "axes", "variances"))
    pca.weights_, pca.share_, pca.steps_ = np.ones(len(pca.mean_)), float(content["share"]), int(content["steps"])
    space.space_, space.curves_, space.carried_ = pca, {}, {}
    columns = [channels.ALL.index(name) for name in content["channels"]]
    for name, lengths in content["lengths"].items():
        edges = np.cumsum(lengths)
        curves = arrays[f"{PREFIX}curves/{name}"].astype(np.float64)
        carried = np.zeros((len(curves), len(channels.ALL)))
        carried[:, columns] = arrays[f"{PREFIX}carried/{name}"]
        if edges[-1] != len(curves):
            raise ValueError(f"the curves of {name} have {len(curves)} samples, not {edges[-1]}")
        space.curves_[name], space.carried_[name] = (tuple(np.split(rows, edges[:-1])) for rows in (curves, carried))
    return RecordedExpressions(space)
