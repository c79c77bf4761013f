"""Three ways to move a face, behind one interface: `poser_for` makes what turns rows of channels into vertices.

* ``blendshapes``: the morph targets as they are (`mien.face.posing.Poser`);
* ``tree``: rotations and translations in a tree (`mien.face.parameter_tree`), derived from the targets
  (`mien.face.tree_of_face`) or read from a configuration file;
* ``regions``: markers spread over the skin by interpolation in blended regions (`mien.face.marker_regions`).

A face that moves by a tree keeps targets, too: what each channel does at weight 1. Formats that hold morph targets show
those; `lost_by_targets` measures what that costs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mien.core.channels import HEAD
from mien.core.errors import InputError
from mien.face.model import Face, Part, Target
from mien.face.parameter_tree import ParameterTree
from mien.face.posing import PosedFace, Poser
from mien.face.tree_posing import TreePoser

__all__ = ["DEFORMERS", "FacePoser", "deformed_by", "lost_by_targets", "poser_for", "with_tree"]

DEFORMERS = ("blendshapes", "tree", "regions")
_SMALLEST = 5e-3  # mm


class FacePoser(Protocol):
    """What every deformer offers."""

    face: Face
    channel_names: tuple[str, ...]

    def pose(self, values: ArrayLike) -> PosedFace:
        """The face at one row of channel values, shape (channels,)."""
        ...


def poser_for(face: Face, channel_names: Sequence[str]) -> FacePoser:
    """What moves a face: its tree where it has one, else its morph targets.

    Examples
    --------
    >>> from mien.face.library import load_face
    >>> face = load_face("default")
    >>> [type(poser_for(deformed_by(face, kind), ("jawOpen",))).__name__ for kind in ("blendshapes", "tree")]
    ['Poser', 'TreePoser']
    """
    return Poser(face, channel_names) if face.tree is None else TreePoser(face, channel_names)


def deformed_by(face: Face, deformer: str | Path) -> Face:
    """A face that moves another way.

    Parameters
    ----------
    face : Face
    deformer : str or Path
        One of `DEFORMERS`, or the path of a tree configuration (``.tree``).

    Raises
    ------
    InputError
        If the deformer is not known, the configuration does not fit, or the face lacks what the deformer needs.
    """
    if str(deformer).endswith(".tree"):
        from mien.face.tree_config import read_tree

        return with_tree(face, read_tree(deformer).on({part.name: part.vertices for part in face.parts}))
    if deformer == "blendshapes":
        return replace(face, tree=None)
    if deformer == "tree":
        from mien.face.tree_of_face import tree_of_face

        return with_tree(face, tree_of_face(face))
    if deformer == "regions":
        from mien.face.marker_regions import face_by_regions

        return face_by_regions(face)
    raise InputError(f"unknown deformer {str(deformer)!r}: known: {', '.join(DEFORMERS)}, or a file ending in .tree")


def with_tree(face: Face, tree: ParameterTree) -> Face:
    """A face moved by a tree; its targets become what each driving channel does at 1 (head and eyes left out)."""
    parts = {part.name for part in face.parts}
    strange = {name for parameter in tree.parameters for name in parameter.influences} - parts
    if strange:
        raise InputError(f"the tree moves {', '.join(sorted(strange))}, which face {face.name!r} has not")
    turning = {f"eyeLook{way}{eye.side}" for eye in face.eyes for way in ("Up", "Down", "In", "Out")}
    eyeballs = {eye.part for eye in face.eyes}
    names = sorted(tree.driven_by - set(HEAD))
    moved = replace(face, tree=tree)
    poser = TreePoser(moved, names)
    rest = poser.pose(np.zeros(len(names)))
    targets: dict[str, dict[str, Target]] = {part.name: {} for part in face.parts}
    for column, name in enumerate(names):
        posed = poser.pose(np.eye(len(names))[column])
        for part, now, before in zip(face.parts, posed.parts, rest.parts, strict=True):
            if part.name in eyeballs and name in turning:
                continue
            offsets = now.vertices - before.vertices
            chosen = np.flatnonzero(np.abs(offsets).max(axis=1) > _SMALLEST)
            if len(chosen):
                targets[part.name][name] = Target(chosen.astype(np.int32), offsets[chosen])
    return replace(moved, parts=tuple(_with_targets(part, targets[part.name]) for part in face.parts))


def _with_targets(part: Part, targets: dict[str, Target]) -> Part:
    return replace(part, targets=targets)


def lost_by_targets(face: Face, channel_names: Sequence[str], rows: ArrayLike) -> float:
    """How far a face that moves by a tree lies from its own targets, mm: the greatest distance in all rows."""
    if face.tree is None:
        return 0.0
    by_tree, by_targets = TreePoser(face, channel_names), Poser(replace(face, tree=None), channel_names)
    worst = 0.0
    values: NDArray[np.float64] = np.atleast_2d(np.asarray(rows, dtype=np.float64))
    for row in values:
        for one, other in zip(by_tree.pose(row).parts, by_targets.pose(row).parts, strict=True):
            worst = max(worst, float(np.linalg.norm(one.vertices - other.vertices, axis=1).max(initial=0.0)))
    return worst
