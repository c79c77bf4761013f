"""`AnimeGraph`: every recorded phone with its sound, motion and emotion, in flat arrays (Cao et al. 2005, B3).

The paper's node is ``a = <P, C, M, E>``: phone, trajectories of the audio features, compressed motion, emotion. Nodes
of one recording are chained in the order in which they were spoken, and all chains are the graph. Here node ``i`` is
row ``i`` of the arrays; its recorded successor is row ``i + 1`` if both are of one chain, otherwise it has none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.utterance import PAUSE

__all__ = ["AnimeGraph", "RecordedChain", "build_graph", "frame_spans", "without_gaps"]

Floats32 = NDArray[np.float32]
Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

_NAMES = ("symbols", "emotion_names", "takes")


@dataclass(frozen=True, eq=False)
class RecordedChain:
    """One take as it enters the graph.

    Attributes
    ----------
    name : str
        Of the take.
    phones : Tier
        Seconds from the start of the take, pauses as ``SIL``; gaps between phones become pauses.
    emotion : str
    features : ndarray, shape (feature frames, coefficients)
        Audio features of the whole take; frame ``k`` stands at ``k / feature_rate``.
    feature_rate : FrameRate
    motion : ndarray, shape (motion frames, dimensions)
        Motion of the whole take in a space where the Euclidean distance of two rows is ``sqrt(markers)`` times the
        root mean square over markers of how far the markers lie apart, mm: marker coordinates, or their components
        along orthonormal axes. Rows with values that are not finite (a marker was lost) break the chain.
    motion_rate : FrameRate
    """

    name: str
    phones: Tier
    emotion: str
    features: NDArray[Any]
    feature_rate: FrameRate
    motion: NDArray[Any]
    motion_rate: FrameRate


@dataclass(frozen=True, eq=False)
class AnimeGraph:
    """All recorded phones. Arrays of `nodes` rows unless stated otherwise.

    Attributes
    ----------
    symbols, emotion_names, takes : tuple of str
        What the numbers in `phones`, `emotions` and `take_of` stand for.
    markers : int
        Markers behind a pose (see `RecordedChain.motion`).
    feature_rate, motion_rate : float
        Frames per second.
    phones, emotions : ndarray of int16
    chains : ndarray of int32
        Number of the unbroken stretch of recording; never falls from one row to the next.
    take_of : ndarray of int32
        Number of the take.
    starts, durations : ndarray of float32
        Seconds from the start of the take, and length in seconds.
    entries, exits : ndarray of float32, shape (nodes, dimensions)
        The pose with which the phone begins and ends (see `build_graph`), in the space of `motion`.
    features : ndarray of float32, shape (feature frames, coefficients)
        Of all takes, one after the other.
    feature_starts, feature_counts : ndarray of int64, int32
        Rows of `features` that belong to a node: at least one.
    motion : ndarray of float32, shape (motion frames, dimensions)
        Of all takes, whole: what was recorded before, after and between phones is there too.
    motion_starts, motion_counts : ndarray of int64, int32
        Rows of `motion` that belong to a node: at least one.
    take_motion : ndarray of int64, shape (takes + 1,)
        Rows ``take_motion[k]`` up to and without ``take_motion[k + 1]`` of `motion` are take ``k``.
    """

    symbols: tuple[str, ...]
    emotion_names: tuple[str, ...]
    takes: tuple[str, ...]
    markers: int
    feature_rate: float
    motion_rate: float
    phones: NDArray[np.int16]
    emotions: NDArray[np.int16]
    chains: NDArray[np.int32]
    take_of: NDArray[np.int32]
    starts: Floats32
    durations: Floats32
    entries: Floats32
    exits: Floats32
    features: Floats32
    feature_starts: Whole
    feature_counts: NDArray[np.int32]
    motion: Floats32
    motion_starts: Whole
    motion_counts: NDArray[np.int32]
    take_motion: Whole

    def __len__(self) -> int:
        return len(self.phones)

    @property
    def follows(self) -> NDArray[np.bool_]:
        """Whether row ``i`` is the recorded successor of row ``i - 1``, shape (nodes,)."""
        follows = np.zeros(len(self), dtype=bool)
        follows[1:] = self.chains[1:] == self.chains[:-1]
        return follows

    def features_of(self, node: int) -> Floats32:
        """Audio features of a node, shape (frames, coefficients)."""
        start = int(self.feature_starts[node])
        return self.features[start : start + int(self.feature_counts[node])]

    def motion_of(self, node: int) -> Floats32:
        """Motion of a node, shape (frames, dimensions)."""
        start = int(self.motion_starts[node])
        return self.motion[start : start + int(self.motion_counts[node])]

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Everything as named arrays, for a file (`from_arrays` is the way back)."""
        return {field.name: np.asarray(getattr(self, field.name)) for field in fields(self)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> AnimeGraph:
        """Make a graph of the arrays of `to_arrays`; memory-mapped arrays stay so.

        Raises
        ------
        InputError
            If an array is missing.
        """
        missing = [field.name for field in fields(cls) if field.name not in arrays]
        if missing:
            raise InputError(
                f"an Anime Graph lacks the array {missing[0]!r}: the file is damaged or of another version"
            )
        values: dict[str, Any] = {field.name: arrays[field.name] for field in fields(cls)}
        values |= {name: tuple(str(text) for text in values[name]) for name in _NAMES}
        values["markers"] = int(values["markers"])
        values |= {name: float(values[name]) for name in ("feature_rate", "motion_rate")}
        return cls(**values)


def without_gaps(phones: Tier) -> Tier:
    """The same phones with a pause in every gap between them.

    Examples
    --------
    >>> tier = without_gaps(Tier("phones", (Interval(0.0, 0.2, "AY"), Interval(0.3, 0.4, "M"))))
    >>> [phone.label for phone in tier]
    ['AY', 'SIL', 'M']
    """
    filled: list[Interval] = []
    for phone in phones:
        if filled and phone.start > filled[-1].end + 1e-9:
            filled.append(Interval(filled[-1].end, phone.start, PAUSE))
        filled.append(phone)
    return Tier(phones.name, tuple(filled))


def frame_spans(phones: Tier, rate: FrameRate, frames: int) -> Whole:
    """Which frames each phone holds, shape (phones, 2): the first, and how many.

    A frame belongs to the phone that sounds at its instant. A phone too short to hold one takes the frame nearest to
    its middle, and so shares it.

    Raises
    ------
    InputError
        If there is no frame.

    Examples
    --------
    >>> tier = Tier("phones", (Interval(0.0, 0.1, "AY"), Interval(0.1, 0.11, "T"), Interval(0.11, 0.2, "M")))
    >>> frame_spans(tier, FrameRate.of(25), 5).tolist()
    [[0, 3], [3, 1], [3, 2]]
    """
    if frames < 1:
        raise InputError("a take without a single frame cannot enter the graph")
    spans = np.empty((len(phones), 2), dtype=np.int64)
    for place, phone in enumerate(phones):
        # Frames k with start <= k / rate < end, in the tolerance of `timeline`.
        first = min(max(-rate.frame_at(-phone.start), 0), frames)
        after = min(max(-rate.frame_at(-phone.end), 0), frames)
        if after <= first:
            first = min(max(rate.nearest_frame(phone.middle), 0), frames - 1)
            after = first + 1
        spans[place] = first, after - first
    return spans


def build_graph(chains: Sequence[RecordedChain], markers: int, instants: bool = False) -> AnimeGraph:
    """Make the graph of recorded takes.

    A phone with a row of motion or features that is not finite is left out, and the chain ends before it.

    Parameters
    ----------
    chains : sequence of RecordedChain
        One per take.
    markers : int
        Markers behind a pose.
    instants : bool
        How a phone's entry and exit pose are read. False, the paper's reading: its first and last frame. True: the
        pose at the instant where it starts and ends, interpolated between frames, so that of recorded neighbours the
        exit is the entry; at low frame rates, where a phone has one frame or two, that is nearer to the motion.

    Raises
    ------
    InputError
        If there is no chain, they do not fit together, or no phone is left.

    Examples
    --------
    >>> rate = FrameRate.of(10)
    >>> tier = Tier("phones", (Interval(0.0, 0.2, "AY"), Interval(0.2, 0.4, "M")))
    >>> take = RecordedChain("one", tier, "neutral", np.zeros((4, 9)), rate, np.arange(12.0).reshape(4, 3), rate)
    >>> graph = build_graph([take], markers=1)
    >>> [graph.symbols[phone] for phone in graph.phones], graph.exits[0].tolist(), graph.entries[1].tolist()
    (['AY', 'M'], [3.0, 4.0, 5.0], [6.0, 7.0, 8.0])
    """
    if not chains:
        raise InputError("no take to make an Anime Graph of")
    if markers < 1:
        raise InputError(f"a pose has at least one marker behind it, not {markers}")
    for chain in chains:
        _check(chain, chains[0])
    symbols = sorted({phone.label for chain in chains for phone in without_gaps(chain.phones)})
    emotions = sorted({chain.emotion for chain in chains})
    feature_starts = np.cumsum([0, *(len(chain.features) for chain in chains)])
    motion_starts = np.cumsum([0, *(len(chain.motion) for chain in chains)])
    columns: list[dict[str, NDArray[Any]]] = []
    unbroken = 0
    for number, chain in enumerate(chains):
        nodes, kept = _nodes_of(chain, instants)
        nodes["phones"] = np.array([symbols.index(str(label)) for label in nodes.pop("labels")], dtype=np.int16)
        nodes["emotions"] = np.full(len(kept), emotions.index(chain.emotion), dtype=np.int16)
        nodes["take_of"] = np.full(len(kept), number, dtype=np.int32)
        nodes["chains"] = (unbroken + np.cumsum(~kept)).astype(np.int32)
        nodes["feature_starts"] += feature_starts[number]
        nodes["motion_starts"] += motion_starts[number]
        unbroken += 1 + int((~kept).sum())
        columns.append({name: values[kept] for name, values in nodes.items()})
    joined: dict[str, Any] = {name: np.concatenate([column[name] for column in columns]) for name in columns[0]}
    if not len(joined["phones"]):
        raise InputError(f"none of the {len(chains)} takes has a phone with sound and motion")
    joined["chains"] = np.unique(joined["chains"], return_inverse=True)[1].astype(np.int32)
    return AnimeGraph(
        symbols=tuple(symbols),
        emotion_names=tuple(emotions),
        takes=tuple(chain.name for chain in chains),
        markers=markers,
        feature_rate=chains[0].feature_rate.fps,
        motion_rate=chains[0].motion_rate.fps,
        features=np.concatenate([np.asarray(chain.features, dtype=np.float32) for chain in chains]),
        motion=np.concatenate([np.asarray(chain.motion, dtype=np.float32) for chain in chains]),
        take_motion=motion_starts,
        **joined,
    )


def _check(chain: RecordedChain, first: RecordedChain) -> None:
    for what, rows, model in (("features", chain.features, first.features), ("motion", chain.motion, first.motion)):
        if rows.ndim != 2 or not len(rows) or rows.shape[1] != model.shape[1]:
            raise InputError(
                f"take {chain.name!r}: expected {what} of shape (frames, {model.shape[-1]}) with a frame or more, "
                f"as in take {first.name!r}, not {rows.shape}"
            )
    if (chain.feature_rate, chain.motion_rate) != (first.feature_rate, first.motion_rate):
        raise InputError(f"take {chain.name!r} has other frame rates than take {first.name!r}: learn from one rate")


def _nodes_of(chain: RecordedChain, instants: bool) -> tuple[dict[str, NDArray[Any]], NDArray[np.bool_]]:
    """Columns of the nodes of one take, and which of them are whole."""
    phones = without_gaps(chain.phones)
    sound = frame_spans(phones, chain.feature_rate, len(chain.features))
    moves = frame_spans(phones, chain.motion_rate, len(chain.motion))
    starts = np.array([phone.start for phone in phones], dtype=np.float64)
    ends = np.array([phone.end for phone in phones], dtype=np.float64)
    motion = np.asarray(chain.motion, dtype=np.float64)
    if instants:
        entries, exits = (_poses_at(motion, times * chain.motion_rate.fps) for times in (starts, ends))
    else:
        entries, exits = motion[moves[:, 0]], motion[moves.sum(axis=1) - 1]
    kept = _all_finite(chain.features, sound) & _all_finite(motion, moves)
    kept &= np.isfinite(entries).all(axis=1) & np.isfinite(exits).all(axis=1)
    columns: dict[str, NDArray[Any]] = {
        "labels": np.array([phone.label for phone in phones], dtype=object),
        "starts": starts.astype(np.float32),
        "durations": (ends - starts).astype(np.float32),
        "entries": entries.astype(np.float32),
        "exits": exits.astype(np.float32),
        "feature_starts": sound[:, 0],
        "feature_counts": sound[:, 1].astype(np.int32),
        "motion_starts": moves[:, 0],
        "motion_counts": moves[:, 1].astype(np.int32),
    }
    return columns, kept


def _poses_at(motion: Floats, frames: Floats) -> Floats:
    """Motion at fractional frames, held before the first and after the last."""
    frames = np.clip(frames, 0, len(motion) - 1)
    before = np.minimum(frames.astype(np.int64), max(len(motion) - 2, 0))
    after = np.minimum(before + 1, len(motion) - 1)
    share = (frames - before)[:, None]
    # A lost frame must not spoil a pose that stands exactly on the frame beside it.
    return np.where(share <= 0, motion[before], np.where(share >= 1, motion[after], _mix(motion, before, after, share)))


def _mix(motion: Floats, before: Whole, after: Whole, share: Floats) -> Floats:
    return np.asarray((1 - share) * motion[before] + share * motion[after])


def _all_finite(rows: NDArray[Any], spans: Whole) -> NDArray[np.bool_]:
    lost = np.concatenate([[0], np.cumsum(~np.isfinite(rows).all(axis=1))])
    return np.asarray(lost[spans.sum(axis=1)] == lost[spans[:, 0]])
