"""A `Person` as arrays, to be kept beside what was captured of them."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any

import numpy as np

from mien.capture.knowledge import knowledge
from mien.capture.openings import Seen
from mien.capture.person import Person

__all__ = ["arrays_of", "person_from", "stamp_of"]

_NUMBERS = ("neutral", "turn", "head", "basis", "region", "noise")


def arrays_of(person: Person) -> dict[str, Any]:
    """All that a person is, by name, for `numpy.savez`."""
    arrays: dict[str, Any] = {name: getattr(person, name) for name in _NUMBERS}
    arrays |= {"markers": np.array(person.markers), "channels": np.array(person.channels)}
    arrays |= {"depth": np.array(person.depth), "raised": np.array(person.raised)}
    arrays["about"] = np.array([person.layout, person.source])
    arrays["openings"] = np.array([seen.opening.name for seen in person.openings])
    arrays["opening_rows"] = np.array([seen.rows for seen in person.openings]).reshape(-1, len(person.markers))
    arrays["opening_levels"] = np.array([(seen.rest, seen.shut) for seen in person.openings]).reshape(-1, 2)
    return arrays


def person_from(arrays: Mapping[str, Any]) -> Person:
    """The person again.

    Raises
    ------
    KeyError, ValueError
        If the arrays are not those of a person.
    """
    known = {opening.name: opening for opening in knowledge().openings}
    seen = tuple(
        Seen(known[str(name)], np.array(rows), float(levels[0]), float(levels[1]))
        for name, rows, levels in zip(arrays["openings"], arrays["opening_rows"], arrays["opening_levels"], strict=True)
    )
    layout, source = (str(word) for word in arrays["about"])
    return Person(
        layout=layout,
        source=source,
        markers=tuple(str(name) for name in arrays["markers"]),
        neutral=np.array(arrays["neutral"]),
        turn=np.array(arrays["turn"]),
        head=np.array(arrays["head"]),
        channels=tuple(str(name) for name in arrays["channels"]),
        basis=np.array(arrays["basis"]),
        region=np.array(arrays["region"]),
        noise=np.array(arrays["noise"]),
        openings=seen,
        depth=float(arrays.get("depth", 0.0)),
        raised=float(arrays.get("raised", 0.0)),
    )


def stamp_of(person: Person) -> str:
    """Tells a person from any other, and from the same person known otherwise."""
    value = hashlib.sha256()
    for name, array in sorted(arrays_of(person).items()):
        value.update(name.encode())
        value.update(np.ascontiguousarray(array).tobytes())
    return value.hexdigest()[:16]
