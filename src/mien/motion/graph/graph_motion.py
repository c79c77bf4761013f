"""`GraphMotion`: recorded motion found for new speech, and joined (Cao et al. 2005, section 4).

The takes become an Anime Graph; the nodes of least cost are searched for the phones that are said, by what they sound
like where there is sound; their motion is warped, joined and smoothed; closures are then held (`lip_closure`) as for
the other speech models. The weights of the search are the paper's, or are learned from the takes
(`weight_learning`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mien.core.audio import Audio
from mien.core.timeline import Interval, Tier
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.core.utterance import PAUSE
from mien.corpus.take import Take
from mien.motion.graph.candidates import GraphIndex, candidates_for
from mien.motion.graph.compact import snapped_graph
from mien.motion.graph.costs import SearchWeights
from mien.motion.graph.felt_takes import emotion_of, labels_of
from mien.motion.graph.graph import AnimeGraph, RecordedChain, build_graph, frame_spans, without_gaps
from mien.motion.graph.joining import Joiner
from mien.motion.graph.motion_code import PAPER_SHARE, MotionCode
from mien.motion.graph.query import SpokenPhones, spoken_phones
from mien.motion.graph.search import cheapest_nodes
from mien.motion.graph.smoothing import learned_cut_offs, low_passed
from mien.motion.graph.sound import SOUND_RATE, heard_features
from mien.motion.graph.weight_learning import learn_weights
from mien.motion.mouth.lip_closure import LipClosure
from mien.motion.mouth.mouth_space import MouthSpace, mouth_space_of
from mien.motion.mouth.recorded_mouths import recorded_mouths

__all__ = ["GRID_RATE", "PAPER_WEIGHTS", "GraphMotion", "GraphMotionSettings", "covering", "trimmed"]

MARGIN = 0.32
"""Seconds before and after speech that the code of the motion is learned with, as in `speech_motion`."""
KEPT = 0.3
"""Seconds of silence that are kept before and after speech, at least."""
GRID_RATE = 100.0
"""Instants per second at which motion is joined and smoothed; frames are read off between them."""
PAPER_WEIGHTS = SearchWeights()

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class GraphMotionSettings:
    """Settings of `GraphMotion`.

    Attributes
    ----------
    share : float
        Share of the variance of the motion that is kept (`motion_code`).
    weights : SearchWeights or None
        Of the search; None learns them.
    evenness : float or None
        Share of an even warp against that by the sound (`joining`); None learns it.
    smooth : bool
        Whether joined motion passes the learned low-pass filters.
    hold_closures : bool
        Whether the lips are drawn shut at bilabials after synthesis.
    seed : int
        Of the independent components.
    learn_in : {"channels", "markers"} or None
        See `mien.motion.mouth.mouth_space.mouth_space_of`.
    """

    share: float = PAPER_SHARE
    weights: SearchWeights | None = None
    evenness: float | None = None
    smooth: bool = True
    hold_closures: bool = True
    seed: int = 0
    learn_in: str | None = None

    @classmethod
    def of_the_paper(cls) -> GraphMotionSettings:
        """The paper's weights and warp."""
        return cls(weights=PAPER_WEIGHTS, evenness=0.0)


class GraphMotion:
    """Mouth motion from phones and sound, out of recorded takes.

    Parameters
    ----------
    settings : GraphMotionSettings

    Attributes
    ----------
    mouth_ : MouthSpace
        What `synthesise` returns: markers or channels of the mouth.
    code_ : MotionCode
    graph_ : AnimeGraph
        Snapped to small steps (`compact`).
    steps_ : ndarray, shape (components,)
        Of its motion.
    cut_offs_ : ndarray, shape (components,)
        Of the low-pass filter of each independent component, Hz.
    weights_ : SearchWeights
    evenness_ : float
    closure_ : LipClosure
    """

    def __init__(self, settings: GraphMotionSettings | None = None) -> None:
        self.settings = settings or GraphMotionSettings()

    def fit(
        self, takes: Sequence[Take], after_trial: Callable[[], None] = lambda: None, felt: Sequence[Take] = ()
    ) -> Self:
        """Learn from takes; what does not belong to the mouth is left out.

        Parameters
        ----------
        takes : sequence of Take
        after_trial : callable
            Called `weight_learning.TRIALS` times if weights are learned, to show progress.
        felt : sequence of Take
            Expressive takes, levelled (`felt_takes`): in the graph with their emotions, after the others.

        Raises
        ------
        InputError
            If there is no take, the takes do not share their markers, or none has a frame with speech.
        """
        self.mouth_: MouthSpace = mouth_space_of(takes, self.settings.learn_in)
        takes = [trimmed(take) for take in takes]
        mouths = recorded_mouths(takes, MARGIN, self.mouth_)
        self.code_ = MotionCode(self.settings.share, self.settings.seed)
        self.code_.fit(np.concatenate([mouth.rows for mouth in mouths]))
        self.closure_ = LipClosure(self.mouth_).fit(mouths)
        chains = [self._chain(take) for take in takes]
        moves = [chain.motion[np.isfinite(chain.motion).all(axis=1)] for chain in chains]
        self.cut_offs_ = learned_cut_offs([self.code_.separate(move) for move in moves], chains[0].motion_rate.fps)
        weights, evenness = self.settings.weights, self.settings.evenness
        if weights is None or evenness is None:
            weights, evenness = learn_weights(self, takes, chains, weights, evenness, after_trial)
        chains += [self._chain(trimmed(take)) for take in felt]
        graph, self.steps_ = snapped_graph(build_graph(chains, self.mouth_.points, instants=True))
        return self.restore(graph, weights, evenness)

    def restore(self, graph: AnimeGraph, weights: SearchWeights, evenness: float) -> Self:
        """Take a graph and weights that were made before."""
        self.graph_, self.weights_, self.evenness_ = graph, weights, evenness
        self.index_, self._joiner = GraphIndex(graph), Joiner(graph, evenness)
        return self

    def _chain(self, take: Take) -> RecordedChain:
        heard = heard_features(take.audio, take.phones)
        motion = self.code_.encode(self.mouth_.rows_of(take))
        return RecordedChain(take.name, take.phones, emotion_of(take), heard, SOUND_RATE, motion, take.markers.rate)

    def synthesise(self, phones: Tier, times: Floats) -> Floats:
        """The mouth by phones and their lengths alone.

        Parameters
        ----------
        phones : Tier
            ARPAbet phones without stress, pauses as ``SIL``; outside it there is silence.
        times : ndarray, shape (frames,)
            Seconds.

        Returns
        -------
        ndarray, shape (frames, markers, 3) or (frames, channels)
            Millimetres in the axes of the takes, or weights 0..1 (`mouth_`).

        Raises
        ------
        InputError
            If a label is no phone.
        """
        return self.perform_features(phones, np.asarray(times, dtype=np.float64), None)

    def synthesise_heard(self, phones: Tier, times: Floats, audio: Audio, felt: Tier | None = None) -> Floats:
        """The same by what is heard too; ``felt``: where which emotion is asked for."""
        return self.perform_features(phones, np.asarray(times, dtype=np.float64), heard_features(audio, phones), felt)

    def asked(
        self, phones: Tier, features: Floats | None, felt: Tier | None = None
    ) -> tuple[SpokenPhones, SearchWeights]:
        """What is searched for, and with which weights: without sound it costs nothing how a node sounds."""
        emotions = labels_of(without_gaps(phones), felt, self.graph_.emotion_names)
        weights = self.weights_
        if features is None:
            last = phones.intervals[-1].end if len(phones) else 0.0
            features = np.zeros((SOUND_RATE.frames_covering(last), self.graph_.features.shape[1]))
            weights = replace(weights, audio=0.0)
        return spoken_phones(phones, features, SOUND_RATE, emotions), weights

    def perform_features(
        self, phones: Tier, times: Floats, features: Floats | None, felt: Tier | None = None
    ) -> Floats:
        """The same by features that were made before (`heard_features`), or by None."""
        if not len(times):
            return self.mouth_.motion_of(np.zeros((0, len(self.code_.mean_))))
        said = covering(phones, float(times.min()), float(times.max()))
        asked, weights = self.asked(said, features, felt)
        nodes, _ = cheapest_nodes(candidates_for(self.index_, asked, weights))
        motion = self.joined(nodes, said, times, features)
        rows = self.code_.decode(motion)
        return self.mouth_.motion_of(self.closure_.hold(rows, phones, times) if self.settings.hold_closures else rows)

    def joined(
        self, nodes: Sequence[int] | NDArray[np.int64], said: Tier, times: Floats, features: Floats | None
    ) -> Floats:
        """Joined and smoothed motion of nodes, shape (frames, components); one node for each phone of ``said``."""
        first = np.floor(times.min() * GRID_RATE)
        grid = (first + np.arange(np.ceil(times.max() * GRID_RATE) - first + 1)) / GRID_RATE
        heard = None
        if features is not None:
            spans = frame_spans(said, SOUND_RATE, len(features))
            heard = [features[start : start + count] for start, count in spans]
        motion = self._joiner.join(nodes, said, grid, heard)
        if self.settings.smooth:
            motion = self.code_.mix(low_passed(self.code_.separate(motion), GRID_RATE, self.cut_offs_))
        return np.stack([np.interp(times, grid, column) for column in motion.T], axis=1)


def trimmed(take: Take) -> Take:
    """A take without long silences at its ends, which tell nothing: shorter by whole frames of motion and sound."""
    spoken = [phone for phone in take.phones if phone.label != PAUSE]
    if not spoken:
        return take
    rate, step = take.markers.rate, Fraction(1, 5)
    first = max(Fraction(0), math.floor(Fraction(spoken[0].start - KEPT) / step) * step)
    if (first * rate.fraction).denominator != 1:
        first = Fraction(0)
    begin, end = float(first), spoken[-1].end + KEPT
    rows = slice(int(first * rate.fraction), rate.frames_covering(end) + 1)
    sound = slice(round(begin * take.audio.rate), math.ceil(end * take.audio.rate))
    return replace(
        take,
        audio=Audio(take.audio.samples[sound], take.audio.rate),
        markers=MarkerTrack(take.markers.names, take.markers.positions[rows], rate),
        phones=_between(take.phones, begin, end),
        words=_between(take.words, begin, end),
        head=None,
        channels=_rows(take.channels, rows),
    )


def _rows(track: ChannelTrack | None, rows: slice) -> ChannelTrack | None:
    return None if track is None else ChannelTrack(track.names, track.values[rows], track.rate)


def _between(tier: Tier, first: float, last: float) -> Tier:
    """What lies between two instants, in seconds from the first of them."""
    kept = [
        Interval(max(i.start, first) - first, min(i.end, last) - first, i.label)
        for i in tier
        if i.end > first and i.start < last
    ]
    return Tier(tier.name, tuple(kept))


def covering(phones: Tier, first: float, last: float) -> Tier:
    """The same phones without gaps, with pauses before and after them that reach the given instants, seconds.

    Examples
    --------
    >>> tier = covering(Tier("phones", (Interval(0.2, 0.4, "AY"),)), 0.0, 1.0)
    >>> [(phone.label, phone.start, phone.end) for phone in tier]
    [('SIL', 0.0, 0.2), ('AY', 0.2, 0.4), ('SIL', 0.4, 1.0)]
    """
    filled = list(without_gaps(phones))
    if not filled:
        return Tier(phones.name, (Interval(first, max(last, first + 1 / GRID_RATE), PAUSE),))
    if filled[0].start > first + 1e-9:
        filled.insert(0, Interval(first, filled[0].start, PAUSE))
    if last > filled[-1].end + 1e-9:
        filled.append(Interval(filled[-1].end, last, PAUSE))
    return Tier(phones.name, tuple(filled))
