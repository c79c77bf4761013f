"""What the mouth does in each phone (``assets/phones/articulation.toml``), and phones cut into parts.

A part is a stretch of time with one articulation: a phone, or one half of a diphthong.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset_table
from mien.core.errors import unknown_name
from mien.core.timeline import Tier
from mien.core.utterance import PAUSE

__all__ = ["ArticulationTable", "Parts", "articulation_table", "parts_of"]

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ArticulationTable:
    """Articulatory features of the parts of all phones.

    Attributes
    ----------
    features : tuple of str
    symbols : tuple of str
        Names of the parts: ``"M"``, or ``"AY.1"`` and ``"AY.2"`` for a diphthong.
    values : ndarray, shape (symbols, features)
        0..1.
    parts : dict of str to tuple of int
        For each phone the numbers of its parts.
    first_share : float
        Share of a diphthong's time that its first part takes.
    visemes : dict of str to tuple of str
        Phones that look alike, by class.
    """

    features: tuple[str, ...]
    symbols: tuple[str, ...]
    values: Floats
    parts: dict[str, tuple[int, ...]]
    first_share: float
    visemes: dict[str, tuple[str, ...]]

    def viseme_of(self, phone: str) -> str:
        """Class of a phone; a pause is a class of its own.

        Examples
        --------
        >>> articulation_table().viseme_of("B")
        'closed'
        """
        if phone == PAUSE:
            return PAUSE
        for name, members in self.visemes.items():
            if phone in members:
                return name
        raise unknown_name("phone", phone, self.parts)


@cache
def articulation_table() -> ArticulationTable:
    """Read the table.

    Examples
    --------
    >>> table = articulation_table()
    >>> [table.symbols[part] for part in table.parts["AY"]]
    ['AY.1', 'AY.2']
    """
    content = asset_table("phones/articulation.toml")
    features = tuple(content["features"])
    symbols: list[str] = []
    rows: list[list[float]] = []
    parts: dict[str, tuple[int, ...]] = {}
    for phone, entries in content["parts"].items():
        parts[phone] = tuple(range(len(symbols), len(symbols) + len(entries)))
        for place, entry in enumerate(entries, start=1):
            for name in entry:
                if name not in features:
                    raise unknown_name(f"feature of {phone} in articulation.toml", name, features)
            symbols.append(phone if len(entries) == 1 else f"{phone}.{place}")
            rows.append([float(entry.get(name, 0.0)) for name in features])
    visemes = {name: tuple(members) for name, members in content["visemes"].items()}
    return ArticulationTable(features, tuple(symbols), np.array(rows), parts, float(content["first_share"]), visemes)


@dataclass(frozen=True, eq=False)
class Parts:
    """The parts of an utterance in order of time, without gaps.

    Attributes
    ----------
    starts, ends : ndarray, shape (parts,)
        Seconds.
    symbols : ndarray of int, shape (parts,)
        Number of each in `ArticulationTable.symbols`.
    phones : ndarray of int, shape (parts,)
        Place of its phone in the tier; -1 for a pause that fills a gap.
    """

    starts: Floats
    ends: Floats
    symbols: Whole
    phones: Whole

    def __len__(self) -> int:
        return len(self.starts)


def parts_of(phones: Tier) -> Parts:
    """Cut phones into parts; gaps between phones become pauses.

    Raises
    ------
    InputError
        If a label is not an ARPAbet phone and no pause.

    Examples
    --------
    >>> from mien.core.timeline import Interval
    >>> parts = parts_of(Tier("phones", (Interval(0.0, 0.2, "AY"), Interval(0.3, 0.4, "M"))))
    >>> [articulation_table().symbols[s] for s in parts.symbols]
    ['AY.1', 'AY.2', 'SIL', 'M']
    """
    table = articulation_table()
    rows: list[tuple[float, float, int, int]] = []
    pause = table.parts[PAUSE][0]
    before = phones.intervals[0].start if len(phones) else 0.0
    for place, phone in enumerate(phones):
        if phone.label not in table.parts:
            raise unknown_name("phone", phone.label, table.parts)
        if phone.start > before + 1e-9:
            rows.append((before, phone.start, pause, -1))
        numbers = table.parts[phone.label]
        if len(numbers) == 1:
            rows.append((phone.start, phone.end, numbers[0], place))
        else:
            cut = phone.start + table.first_share * phone.duration
            rows += [(phone.start, cut, numbers[0], place), (cut, phone.end, numbers[1], place)]
        before = phone.end
    columns = list(zip(*rows, strict=True)) if rows else [(), (), (), ()]
    return Parts(
        np.array(columns[0], dtype=float),
        np.array(columns[1], dtype=float),
        np.array(columns[2], dtype=np.int64),
        np.array(columns[3], dtype=np.int64),
    )
