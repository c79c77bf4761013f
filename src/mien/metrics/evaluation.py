"""`Evaluation`: scores of models on held-out takes, and `CountedRows`, which counts them take by take."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError, Note
from mien.core.tracks import ChannelTrack
from mien.metrics.counts import Tally, tally
from mien.metrics.published import upper_face_dynamics_deviation
from mien.metrics.repetitions import Repetitions
from mien.metrics.scored_takes import Recording
from mien.metrics.scores import Score, score
from mien.metrics.shown_mouth import Stage, constant_offsets
from mien.metrics.splits import Fold

__all__ = [
    "CAPTURED",
    "MARKERS",
    "RECORDING",
    "REPETITIONS",
    "YARDSTICKS",
    "CountedRows",
    "Evaluation",
    "Trace",
    "names_of",
]

RECORDING = "recording"
"""Row in which the recording is scored against itself: the yardstick for closures, jitter and distributions."""
CAPTURED = "recording, captured"
"""Row in which the recording is captured and shown on the face: what no model of this capture can better."""
REPETITIONS = "other repetitions"
"""Row in which the words are taken from the other takes that say them: a yardstick, though no bound."""
YARDSTICKS = (RECORDING, CAPTURED, REPETITIONS)
ENOUGH_REPEATED = 0.9
"""Share of the scored takes whose words other takes must repeat for that row to mean anything."""
TRACES = 4
"""Takes whose trajectories are kept for a picture."""

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Mouths = dict[str, dict[str, Array]]
"""Positions of the mouth markers by row and take."""


@dataclass(frozen=True, eq=False)
class Trace:
    """Mouths of one take as recorded and as each model has it, for a picture."""

    recording: Recording
    mouths: Mapping[str, Array]


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Scores of models on held-out takes.

    Attributes
    ----------
    scores : mapping of str to mapping of str to Score
        Of the face that is shown, by row and metric: first the `YARDSTICKS` (`REPETITIONS` only where words are
        repeated), then the models. Empty if the recorded markers are not on the default face.
    marker_scores : mapping of str to mapping of str to Score
        The same on the markers themselves, of the models that give markers.
    offsets : mapping of str to mapping of str to tuple of float
        By row and speaker: the constant offset that was removed from the shown face, its mean over the mouth (x, y, z),
        mm; over several folds that of the last.
    pooled : bool
        Whether frames were pooled (unseen words) or takes averaged.
    folds : tuple of Fold
        Empty for a finished performer.
    takes, frames, bilabials : int
        Takes and frames that were scored, and bilabials that were asked for.
    upper_face : tuple of (float, float), or None
        Upper-face dynamics deviation, signed and absolute, of a face whose upper part does not move, mm: what every
        model of the mouth alone gets. None where no upper-face marker was recorded.
    traces : tuple of Trace
    notes : tuple of Note
    """

    scores: Mapping[str, Mapping[str, Score]]
    marker_scores: Mapping[str, Mapping[str, Score]]
    offsets: Mapping[str, Mapping[str, tuple[float, float, float]]]
    pooled: bool
    folds: tuple[Fold, ...]
    takes: int
    frames: int
    bilabials: int
    upper_face: tuple[float, float] | None
    traces: tuple[Trace, ...]
    notes: tuple[Note, ...] = ()


MARKERS = 3
"""Dimensions of motion in markers, (frames, markers, 3); motion in channels has two."""


class CountedRows:
    """Mouths of the takes of one fold after another, counted row by row."""

    def __init__(self, ready: Mapping[str, Recording], rows: Collection[str]) -> None:
        self.ready = ready
        self.counted: dict[str, Mask] = {}
        self._rows = (*YARDSTICKS, *rows)
        self._every = Repetitions(ready.values())
        self._shown: Mouths = {}
        self._markers: Mouths = {}
        self._tallies: dict[str, dict[str, Tally]] = {}
        self._marker_tallies: dict[str, dict[str, Tally]] = {}
        self._offsets: dict[str, dict[str, tuple[float, float, float]]] = {}
        self._traces: list[Trace] = []
        self._notes: list[Note] = []
        self._stage: Stage | None = Stage(list(ready.values()))
        try:
            for recording in ready.values():
                self._stage.check(recording)
        except InputError as problem:
            self._stage = None
            self._notes.append(Note("warning", f"not scored as shown: {problem}"))

    def open(self, counted: Mapping[str, Mask]) -> None:
        """Begin a fold: frames to score by take; its yardsticks are made."""
        self.counted = dict(counted)
        self._shown, self._markers = {}, {}
        for name, held in self.counted.items():
            recording = self.ready[name]
            self._keep(self._markers, RECORDING, name, recording.bridged)
            self._keep(self._shown, RECORDING, name, recording.bridged)
            if self._stage is not None:
                self._keep(self._shown, CAPTURED, name, self._stage.recorded(recording))
            repeated, known = self._every.mouth(recording)
            if known[held].all():
                self._keep(self._markers, REPETITIONS, name, repeated)

    def add(self, row: str, name: str, moved: Sequence[str], motion: Array) -> None:
        """What a model moves, and what it gave for a take: (frames, channels) or of markers (frames, markers, 3)."""
        if motion.ndim == MARKERS:
            self._keep(self._markers, row, name, motion)
        else:
            self.show(row, name, ChannelTrack(tuple(moved), motion, self.ready[name].take.markers.rate))

    def show(self, row: str, name: str, track: ChannelTrack) -> None:
        """Channels that a take was performed with."""
        if self._stage is not None:
            self._keep(self._shown, row, name, self._stage.of_channels(self.ready[name], track))

    def close(self, *, brought_together: bool = False) -> None:
        """End a fold: count it. ``brought_together``: markers are brought to the reference of the recordings first."""
        for row, by_take in self._markers.items():
            offsets = constant_offsets(self.ready, by_take, self.counted) if brought_together else {}
            self._said(f"{row}, markers", offsets)
            for name, positions in by_take.items():
                laid = positions - offsets.get(self.ready[name].take.speaker, 0.0)
                _add(self._marker_tallies.setdefault(row, {}), name, tally(self.ready[name], laid, self.counted[name]))
                if self._stage is not None and row != RECORDING:
                    self._keep(self._shown, row, name, self._stage.of_markers(self.ready[name], laid))
        for row, by_take in self._shown.items():
            offsets = constant_offsets(self.ready, by_take, self.counted)
            self._said(row, offsets)
            for name, mouth in by_take.items():
                offset = offsets[self.ready[name].take.speaker]
                new = tally(self.ready[name], mouth, self.counted[name], offset, from_the_front=True)
                _add(self._tallies.setdefault(row, {}), name, new)
        if not self._traces:
            self._traces = self._pictured()

    def _pictured(self) -> list[Trace]:
        """A few takes of this fold."""
        mouths = self._shown if self._stage is not None else self._markers
        kept = list(self.counted)[:: max(1, len(self.counted) // TRACES)][:TRACES]
        return [
            Trace(self.ready[name], {row: by_take[name] for row, by_take in mouths.items() if name in by_take})
            for name in kept
        ]

    def finished(self, folds: tuple[Fold, ...], seed: int, notes: tuple[Note, ...]) -> Evaluation:
        """All that was counted, as scores."""
        scored = self._marker_tallies.get(RECORDING, {})
        if not scored:
            raise InputError("the test set is empty: none of its takes has a frame to score; give other names or words")
        pooled = any(fold.words for fold in folds)
        return Evaluation(
            scores=self._scores(self._tallies, pooled, seed) if self._stage is not None else {},
            marker_scores=self._scores(self._marker_tallies, pooled, seed),
            offsets=self._offsets,
            pooled=pooled,
            folds=folds,
            takes=len(scored),
            frames=int(sum(t["lips"][1] for t in scored.values())),
            bilabials=int(sum(t["closure"][0] for t in scored.values())),
            upper_face=_still_upper_face([self.ready[name] for name in sorted(scored)]),
            traces=tuple(self._traces),
            notes=(*notes, *self._notes),
        )

    def _scores(
        self, tallies: Mapping[str, Mapping[str, Tally]], pooled: bool, seed: int
    ) -> dict[str, Mapping[str, Score]]:
        """Rows in the order of the table; repetitions only where enough takes have them."""
        enough = ENOUGH_REPEATED * len(tallies[RECORDING])
        return {
            row: score(
                [tallies[row][name] for name in sorted(tallies[row])],
                pooled=pooled,
                random=np.random.default_rng(seed),
            )
            for row in self._rows
            if row in tallies and (row != REPETITIONS or len(tallies[row]) >= enough)
        }

    @staticmethod
    def _keep(mouths: Mouths, row: str, name: str, positions: Array) -> None:
        mouths.setdefault(row, {})[name] = positions

    def _said(self, row: str, offsets: Mapping[str, Array]) -> None:
        if row.removesuffix(", markers") == RECORDING:
            return
        for speaker, offset in offsets.items():
            x, y, z = (float(value) for value in offset.mean(axis=0))
            self._offsets.setdefault(row, {})[speaker] = (x, y, z)


def names_of(model: object) -> tuple[str, ...]:
    """What a model moves, in the order in which it gives it."""
    space = getattr(model, "mouth_", None)
    return tuple(space.names if space is not None else getattr(model, "markers_", ()))


def _add(tallies: dict[str, Tally], name: str, new: Tally) -> None:
    """A take tested in several folds (other words each time) counts once, with the frames of all."""
    old = tallies.get(name)
    tallies[name] = new if old is None else {family: old[family] + new[family] for family in new}


def _still_upper_face(scored: Sequence[Recording]) -> tuple[float, float] | None:
    """Upper-face dynamics deviation of a still face, mean over takes; rest is the mean of the scored frames."""
    pairs = []
    for recording in scored:
        held = recording.speech & np.isfinite(recording.upper).all(axis=(1, 2))
        if recording.upper.shape[1] and held.sum() > 1:
            rest = recording.upper[held].mean(axis=0)
            still = np.broadcast_to(rest, recording.upper[held].shape)
            pairs.append(upper_face_dynamics_deviation(recording.upper[held], still, rest))
    if not pairs:
        return None
    signed, absolute = np.mean(pairs, axis=0)
    return float(signed), float(absolute)
