"""`EmotionMaps`: a recorded person's maps between emotions (Cao et al. 2005), learned and kept in a performer's file.

There is a map for each two emotions in which the same sentences were recorded, in both directions; where none is, the
way leads through neutral. Arrays are kept in 32 bits; they are rounded at once when learned, so that a performer moves
alike before and after it was saved.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError, Note
from mien.core.timeline import FrameRate
from mien.core.utterance import PAUSE
from mien.corpus.take import Take
from mien.motion.graph.motion_code import MotionCode
from mien.motion.maps.emotion_component_maps import LIVELY, LivelyMap
from mien.motion.maps.emotion_mapping import ComponentSplit, EmotionMapping, Pair

__all__ = [
    "PREFIX",
    "EmotionMaps",
    "emotion_map_arrays",
    "emotion_map_content",
    "emotion_maps_from",
    "learn_emotion_maps",
]

Floats = NDArray[np.float64]
Arrays = dict[str, NDArray[Any]]
PREFIX = "emotion_maps/"
NEUTRAL = "neutral"
LEAST_SENTENCES = 2
"""Sentences that two emotions must share: of one alone a map cannot be chosen on what it has not seen."""
_LEARNED = ("from_", "to_", "gain_", "centres_", "weights_", "mixing_")
_CHOSEN = ("penalty_", "blend_", "width_", "bending_", "reach_", "liveliness_", "error_", "offset_error_")


@dataclass(frozen=True, eq=False)
class EmotionMaps:
    """Maps between the emotions of one recorded person.

    Attributes
    ----------
    layout : str
    markers : tuple of str
    rate : FrameRate
        Of the recordings: maps look at frames before and after.
    rest : ndarray, shape (markers, 3)
        Where the markers stand in the pauses of neutral takes, mm.
    maps : mapping of (str, str) to EmotionMapping
        By the emotion of the source and of the target.
    sentences : mapping of (str, str) to int
        How many sentences each was learned from.
    notes : tuple of Note
        What was left out, and why; not kept in files.
    """

    layout: str
    markers: tuple[str, ...]
    rate: FrameRate
    rest: Floats
    maps: Mapping[tuple[str, str], EmotionMapping]
    sentences: Mapping[tuple[str, str], int]
    notes: tuple[Note, ...] = ()

    @property
    def emotions(self) -> tuple[str, ...]:
        """Emotions that can be mapped from or to."""
        return tuple(sorted({name for pair in self.maps for name in pair}))

    def way(self, source: str, target: str) -> tuple[tuple[str, str], ...] | None:
        """The maps that lead from one emotion to another, one or two; none if they are the same; None: no way."""
        if source == target:
            return ()
        for way in (((source, target),), ((source, NEUTRAL), (NEUTRAL, target))):
            if all(step in self.maps for step in way):
                return way
        return None

    def apply(
        self, positions: Floats, source: str, target: str, rate: FrameRate, random: np.random.Generator | None = None
    ) -> Floats:
        """The same speech in another emotion.

        Parameters
        ----------
        positions : ndarray, shape (frames, markers, 3)
            Normalised as the recordings were, mm.
        source, target : str
            Emotions.
        rate : FrameRate
            Of the positions.
        random : numpy.random.Generator, optional
            Draws what cannot be told from the source (see `EmotionMapping.apply`), where the map alone is less lively
            than `LIVELY`: what is drawn by chance is nearer to no recording.

        Raises
        ------
        InputError
            If no map leads there.
        """
        way = self.way(source, target)
        if way is None:
            raise InputError(
                f"no map from {source!r} to {target!r} was learned; learned: "
                + ", ".join(f"{a} to {b}" for a, b in sorted(self.maps))
            )
        times, own = rate.times(len(positions)), self.rate.times(self.rate.frames_covering(len(positions) / rate.fps))
        moved = _at(positions, times, own)
        start = moved
        for step in way:
            learned = self.maps[step].map_
            lacks_life = isinstance(learned, LivelyMap) and learned.liveliness_ < LIVELY[0]
            moved = self.maps[step].apply(moved, random if lacks_life and step is way[-1] else None)
        return np.asarray(positions + _at(moved - start, own, times))


def _at(rows: Floats, times: Floats, wanted: Floats) -> Floats:
    """Rows at other instants, held at the ends."""
    if np.array_equal(times, wanted):
        return rows
    flat = rows.reshape(len(rows), -1)
    moved = np.stack([np.interp(wanted, times, column) for column in flat.T], axis=1)
    return np.asarray(moved.reshape(len(wanted), *rows.shape[1:]))


def learn_emotion_maps(takes: Sequence[Take], seed: int = 0) -> EmotionMaps | None:
    """Learn a map for each two emotions that share sentences; None if no two of them share `LEAST_SENTENCES`.

    Parameters
    ----------
    takes : sequence of Take
        Of one layout and frame rate. Of several takes of a sentence in one emotion by one speaker the first counts;
        takes in which a marker is missing are left out, with a note.
    seed : int
    """
    said: dict[tuple[str, str], dict[str, Take]] = {}
    faults = []
    for take in takes:
        key = (take.speaker, take.sentence or " ".join(word.label.lower() for word in take.words))
        if key[1] and np.isfinite(take.markers.positions).all():
            said.setdefault(key, {}).setdefault(take.emotion or NEUTRAL, take)
        elif key[1]:
            faults.append(take.name)
    names = sorted({emotion for found in said.values() for emotion in found})
    shared: dict[tuple[str, str], list[Pair]] = {}
    for source, target in permutations(names, 2):
        both = [found for found in said.values() if source in found and target in found]
        if len(both) >= LEAST_SENTENCES:
            shared[source, target] = [(f[source].markers.positions, f[target].markers.positions) for f in both]
    if not shared:
        return None
    every = [take for found in said.values() for take in found.values()]
    first = every[0]
    strange = [t.name for t in every if t.markers.names != first.markers.names or t.markers.rate != first.markers.rate]
    if strange:
        raise InputError(
            f"takes {first.name!r} and {strange[0]!r} differ in markers or frame rate: learn from one kind"
        )
    notes = (Note("warning", f"no map learned from {', '.join(faults[:5])}: a marker is missing"),) if faults else ()
    maps = {step: rounded(EmotionMapping(seed=seed).fit(pairs)) for step, pairs in shared.items()}
    counts = {step: len(pairs) for step, pairs in shared.items()}
    rest = _rest([take for take in every if take.emotion in ("", NEUTRAL)] or every)
    return EmotionMaps(first.layout, first.markers.names, first.markers.rate, rest, maps, counts, notes)


def _rest(takes: Sequence[Take]) -> Floats:
    """Markers in the pauses (of takes without any: in all frames), to 32 bits."""
    rows = []
    for take in takes:
        times = take.markers.rate.times(len(take.markers))
        quiet = np.zeros(len(times), dtype=bool)
        for phone in take.phones:
            if phone.label == PAUSE:
                quiet |= (times >= phone.start) & (times < phone.end)
        rows.append(take.markers.positions[quiet if quiet.any() else slice(None)])
    return np.asarray(np.concatenate(rows).mean(axis=0).astype(np.float32), dtype=np.float64)


def rounded(mapping: EmotionMapping) -> EmotionMapping:
    """The map as it will be after it was saved and loaded; what it was learned from is let go."""
    arrays = _arrays_of(mapping)
    return _mapping_from(_content_of(mapping), arrays)


def _arrays_of(mapping: EmotionMapping) -> Arrays:
    learned = mapping.map_
    assert isinstance(learned, LivelyMap)  # the default map; no other is kept
    code = {"mean": mapping.code_.mean_, "axes": mapping.code_.axes_, "mixing": mapping.code_.mixing_}
    return {
        name: np.ascontiguousarray(value, dtype=np.float32)  # order counts: the same bits come of the same order alone
        for name, value in {
            **code,
            **{name.strip("_"): getattr(learned, name) for name in _LEARNED if name != "mixing_"},
            "wander": mapping.wander_,
            "beside": mapping.beside_,
        }.items()
    }


def _content_of(mapping: EmotionMapping) -> dict[str, Any]:
    learned = mapping.map_
    assert isinstance(learned, LivelyMap)
    chosen = {name.strip("_"): _finite(getattr(learned, name)) for name in _CHOSEN}
    split = {name: list(values) for name, values in vars(mapping.split_).items()}
    return {
        "share": mapping.code_.share_,
        "memory": mapping.memory_,
        "context": learned.context,
        **chosen,
        "split": split,
    }


def _finite(number: float) -> float | None:
    """JSON knows no infinity."""
    return float(number) if np.isfinite(number) else None


def _mapping_from(content: Mapping[str, Any], arrays: Arrays) -> EmotionMapping:
    exact = {name: np.asarray(value, dtype=np.float64) for name, value in arrays.items()}
    mapping = EmotionMapping()
    code = MotionCode(mapping.share, mapping.seed)
    mapping.code_ = code.restore(exact["mean"], exact["axes"], exact["mixing"], float(content["share"]))
    mapping.split_ = ComponentSplit(**{name: tuple(values) for name, values in content["split"].items()})
    chosen = {f"{name}_": float("inf") if content[name] is None else float(content[name]) for name in _bare(_CHOSEN)}
    learned = {f"{name}_": exact[name] for name in _bare(_LEARNED)}
    mapping.map_ = LivelyMap(int(content["context"])).restore(**chosen, **learned)
    mapping.wander_, mapping.memory_ = exact["wander"], float(content["memory"])
    mapping.beside_ = exact["beside"]
    return mapping


def _bare(names: Sequence[str]) -> list[str]:
    return [name.strip("_") for name in names]


def emotion_map_content(maps: EmotionMaps) -> dict[str, Any]:
    """What goes into ``performer.json``."""
    return {
        "layout": maps.layout,
        "markers": list(maps.markers),
        "rate": str(maps.rate.fraction),
        "maps": [
            {"from": a, "to": b, "sentences": maps.sentences[a, b], **_content_of(mapping)}
            for (a, b), mapping in maps.maps.items()
        ],
    }


def emotion_map_arrays(maps: EmotionMaps) -> Arrays:
    """What goes into the file as arrays."""
    arrays: Arrays = {f"{PREFIX}rest": maps.rest.astype(np.float32)}
    for number, mapping in enumerate(maps.maps.values()):
        arrays |= {f"{PREFIX}{number}/{name}": value for name, value in _arrays_of(mapping).items()}
    return arrays


def emotion_maps_from(content: Mapping[str, Any], arrays: Arrays) -> EmotionMaps:
    """The way back from `emotion_map_content` and `emotion_map_arrays`.

    Raises
    ------
    KeyError, ValueError, TypeError
        If something is missing or does not fit.
    """
    maps, counts = {}, {}
    for number, told in enumerate(content["maps"]):
        begin = f"{PREFIX}{number}/"
        own = {name.removeprefix(begin): value for name, value in arrays.items() if name.startswith(begin)}
        step = (str(told["from"]), str(told["to"]))
        maps[step], counts[step] = _mapping_from(told, own), int(told["sentences"])
    rate = FrameRate.of(content["rate"])
    rest = np.asarray(arrays[f"{PREFIX}rest"], dtype=np.float64)
    return EmotionMaps(content["layout"], tuple(content["markers"]), rate, rest, maps, counts)
