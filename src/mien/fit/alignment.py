"""How a head lies in its file: axes, unit and place, found from its landmarks; and which landmarks cannot be right."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError, Note
from mien.face.head_space import HeadSpace
from mien.face.warps import Similarity, similarity_between
from mien.fit.landmarks import known_landmarks, other_side

__all__ = ["UNITS", "Alignment", "align"]

UNITS = {"mm": 1.0, "cm": 10.0, "inch": 25.4, "dm": 100.0, "m": 1000.0}
_LIKELY = 1.3  # heads of a known unit are this much larger or smaller than the default at most
_SNAP_DEGREES = 12.0  # a head this close to its file's axes keeps them
_FAR_MM, _ODD_MM = 40.0, 20.0
_SWAP_SHARE = 0.6

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Alignment:
    """From the file's coordinates to millimetres about the default face's origin, x left, y up, z forward.

    Attributes
    ----------
    to_face : Similarity
        Applied to the file's coordinates; keeps the head's true size where the unit is known.
    template : Similarity
        Applied to the default face; brings it onto the aligned head.
    unit : str
        The file's unit, or "" where the head has no human size in any.
    notes : tuple of Note
    """

    to_face: Similarity
    template: Similarity
    unit: str
    notes: tuple[Note, ...]


def align(places: Mapping[str, Floats], space: HeadSpace, where: str, unit: str | None = None) -> Alignment:
    """Find axes, unit and place of a head from its landmarks.

    Parameters
    ----------
    places : mapping of str to ndarray of shape (3,)
        In the file's coordinates.
    space : HeadSpace
    where : str
        Names the landmarks in errors.
    unit : str, optional
        One of `UNITS`, if known.

    Raises
    ------
    InputError
        If the landmarks lie in one place or on one line, left and right are swapped, or one lies where it cannot.
    """
    names = list(places)
    given = np.array([places[name] for name in names])
    own = space.rest[[known_landmarks()[name].vertex for name in names]]
    sizes = np.linalg.svd(given - given.mean(0), compute_uv=False)
    if not sizes[1] > 1e-3 * sizes[0]:
        raise InputError(f"{where}: the landmarks lie on one point or line: are they of this head?")
    fit = similarity_between(given, own)
    notes = _checked(names, given, own, fit, where)
    name, factor = _unit(fit.scale, unit, where)
    if not name:
        told = f"in no unit is this head of human size; it is scaled by {fit.scale:.4g} to the default face's"
        notes.append(Note("note", told))
    turn = _snapped(fit.turn)
    middle = factor * turn @ given.mean(0)
    to_face = Similarity(factor, turn, np.asarray(own.mean(0) * factor / fit.scale - middle))
    return Alignment(to_face, similarity_between(own, to_face(given)), name, tuple(notes))


def _unit(scale: float, unit: str | None, where: str) -> tuple[str, float]:
    """The unit's name and its millimetres; a head of no human size is scaled to the default's."""
    if unit is not None:
        size = UNITS[unit] / scale
        if not 0.1 < size < 10:
            raise InputError(f"{where}: in {unit} this head would be {size:.3g} times as large as a person's")
        return unit, UNITS[unit]
    name = min(UNITS, key=lambda each: abs(np.log(UNITS[each] / scale)))
    if abs(np.log(UNITS[name] / scale)) < np.log(_LIKELY):
        return name, UNITS[name]
    return "", scale


def _snapped(turn: Floats) -> Floats:
    """The rotation, or the nearest permutation of axes if that is close."""
    axes = np.zeros((3, 3))
    left = np.abs(turn).copy()
    for _ in range(3):
        row, column = np.unravel_index(np.argmax(left), left.shape)
        axes[row, column] = np.sign(turn[row, column])
        left[row], left[:, column] = -1, -1
    angle = np.degrees(np.arccos(np.clip((np.trace(axes.T @ turn) - 1) / 2, -1, 1)))
    return axes if np.linalg.det(axes) > 0 and angle < _SNAP_DEGREES else turn


def _checked(names: list[str], given: Floats, own: Floats, fit: Similarity, where: str) -> list[Note]:
    mirrored = similarity_between(given, own, mirrored=True)
    if mirrored.residual < _SWAP_SHARE * fit.residual:
        raise InputError(
            f"{where}: left and right are swapped in all landmarks (left is the person's own), or the mesh is mirrored"
        )
    error = np.linalg.norm(fit(given) - own, axis=1)
    if error.max() > _ODD_MM / 2:
        _refuse_swapped_pair(names, given, own, fit.residual, where)
    return _odd_ones(names, given, own, error, where)


def _refuse_swapped_pair(names: list[str], given: Floats, own: Floats, residual: float, where: str) -> None:
    """One pair with its sides exchanged, or two landmarks with each other's places."""
    best: tuple[float, str, str] | None = None
    for i, one in enumerate(names):
        for j in range(i + 1, len(names)):
            order = np.arange(len(names))
            order[[i, j]] = j, i
            after = similarity_between(given[order], own).residual
            share = _SWAP_SHARE if names[j] == other_side(one) else 0.4
            if after < share * residual and (best is None or after < best[0]):
                best = after, one, names[j]
    if best is not None:
        raise InputError(f"{where}: {best[1]} and {best[2]} look swapped (left and right are the person's own)")


def _odd_ones(names: list[str], given: Floats, own: Floats, error: Floats, where: str) -> list[Note]:
    """Landmarks that lie far from where the others put them; too far is refused."""
    notes = []
    for number in np.argsort(-error)[:3]:
        rest = np.delete(np.arange(len(names)), number)
        fit = similarity_between(given[rest], own[rest])
        away = float(np.linalg.norm(fit(given[number][None])[0] - own[number]))
        if away > _FAR_MM and away > 4 * fit.residual:
            raise InputError(
                f"{where}: {names[number]} lies {away:.0f} mm (of a head of human size) from where the others put it"
            )
        if away > _ODD_MM and away > 3 * fit.residual:
            told = f"{names[number]} lies {away:.0f} mm from where the other landmarks put it: is it right?"
            notes.append(Note("warning", told))
    return notes
