"""Which phones of the graph may stand for a phone that is asked for, so that a way is always found.

A phone that was recorded (in the emotion asked for, where that is a filter) stands for itself. For one that was not,
in this order: the phones of its viseme class (``assets/phones/articulation.toml``) in that emotion; the phone itself
in any emotion; its class in any emotion; the recorded phones that are articulated most alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import unknown_name
from mien.motion.graph.graph import AnimeGraph
from mien.motion.graph.query import SpokenPhones
from mien.motion.mouth.articulation import articulation_table

__all__ = ["Substitution", "nearest_articulations", "stand_ins", "substitutions_in"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Substitution:
    """A phone for which something else had to be taken.

    Attributes
    ----------
    place : int
        Of the phone among those asked for.
    phone : str
        What was asked for.
    taken : str
        What was found.
    reason : {"class", "articulation", "emotion"}
        What it has in common with the phone: the viseme class, the nearest articulation, or all but the emotion.
    """

    place: int
    phone: str
    taken: str
    reason: str


def stand_ins(phone: str, emotion: str | None, recorded: frozenset[tuple[str, str]]) -> tuple[tuple[str, ...], bool]:
    """Phones that may be taken, and whether in the emotion asked for only.

    Parameters
    ----------
    phone : str
    emotion : str or None
        Emotion that is a filter; None for none.
    recorded : frozenset of (phone, emotion)
        What the graph holds; not empty.

    Raises
    ------
    InputError
        If the phone is neither recorded nor one of the table.

    Examples
    --------
    >>> recorded = frozenset([("P", "sad"), ("B", "happy"), ("M", "happy")])
    >>> stand_ins("P", "sad", recorded), stand_ins("P", "happy", recorded), stand_ins("P", "angry", recorded)
    ((('P',), True), (('B', 'M'), True), (('P',), False))
    """
    names = {name for name, _ in recorded}
    felt = {name for name, how in recorded if how == emotion}
    for among, in_emotion in ((felt, True), (names, False)):
        if phone in among:
            return (phone,), in_emotion
        kin = _class_of(phone) & among
        if kin:
            return tuple(sorted(kin)), in_emotion
    return nearest_articulations(phone, names), False


def _class_of(phone: str) -> set[str]:
    """Phones that look like a phone; empty for a pause and for a symbol that the table does not have."""
    table = articulation_table()
    return set(table.visemes.get(table.viseme_of(phone), ())) if phone in table.parts else set()


def nearest_articulations(phone: str, names: set[str]) -> tuple[str, ...]:
    """Phones among ``names`` whose articulation, averaged over their parts, is nearest; several if equally near.

    Raises
    ------
    InputError
        If the phone is not in the table.

    Examples
    --------
    >>> nearest_articulations("NG", {"N", "AA", "S"})
    ('N',)
    """
    table = articulation_table()
    if phone not in table.parts:
        raise unknown_name("phone", phone, {*table.parts, *names})

    def features(name: str) -> Floats:
        return np.asarray(table.values[list(table.parts[name])].mean(axis=0))

    known = sorted(names & set(table.parts)) or sorted(names)
    apart = [float(((features(name) - features(phone)) ** 2).sum()) if name in table.parts else 0.0 for name in known]
    return tuple(name for name, value in zip(known, apart, strict=True) if value <= min(apart) + 1e-9)


def substitutions_in(graph: AnimeGraph, asked: SpokenPhones, nodes: NDArray[np.int64]) -> tuple[Substitution, ...]:
    """Where nodes are of another phone, or of another emotion, than asked for.

    Parameters
    ----------
    graph : AnimeGraph
    asked : SpokenPhones
    nodes : ndarray of int64, shape (phones,)
    """
    found: list[Substitution] = []
    for place, (phone, node) in enumerate(zip(asked.phones, nodes, strict=True)):
        taken, felt = graph.symbols[graph.phones[node]], graph.emotion_names[graph.emotions[node]]
        if taken != phone:
            alike = taken in _class_of(phone)
            found.append(Substitution(place, phone, taken, "class" if alike else "articulation"))
        elif asked.emotions is not None and felt != asked.emotions[place]:
            found.append(Substitution(place, f"{phone} ({asked.emotions[place]})", f"{taken} ({felt})", "emotion"))
    return tuple(found)
