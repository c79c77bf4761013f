"""Anime Graphs of any size for measuring the search: real recordings said again, or English that was never said.

Two kinds, both with sound and motion of real size and spread:

* *grammar*: takes of the corpus, drawn whole with replacement. The same few sentences come back with each copy, so
  recorded runs are as long as sentences: the graph of someone who records a small vocabulary again and again.
* *English*: sentences drawn word by word from the bigrams of the language model inside pocketsphinx (the `NEIGHBOURS`
  likeliest words; others by their own frequency as often as the model expects words outside of these), pronounced by
  its dictionary. Each phone is one recorded phone of the corpus, drawn among those with the same label (or, for the
  few that the corpus lacks, those that `standing_in` names): its features, its length and its poses.

Drawn features and poses get noise on top, so that no two nodes are alike. The search never reads the motion itself; it
is left out.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mien.corpus.recordings import Corpus
from mien.motion.graph.graph import AnimeGraph, RecordedChain, build_graph
from mien.motion.graph.motion_code import MotionCode
from mien.motion.graph.query import SpokenPhones, spoken_phones
from mien.motion.graph.sound import SOUND_RATE, heard_features
from mien.motion.graph.standing_in import stand_ins
from mien.motion.mouth.mouth_space import mouth_space_of
from mien.text.pronunciation import dictionary_entries

NEIGHBOURS = 1000
FEATURE_NOISE = 0.3
"""Standard deviations of a feature (features are normalised to one)."""
POSE_NOISE = 0.3
"""Millimetres over the points of the mouth."""
SIZES = (1_000, 10_000, 100_000, 1_000_000)


def recorded_chains(folder: str | Path) -> tuple[list[RecordedChain], int]:
    """Every take of a corpus as the graph takes it, and how many points are behind a pose."""
    takes = list(Corpus(folder))
    space = mouth_space_of(takes)
    flat = [space.rows_of(take) for take in takes]
    seen = np.concatenate([rows[np.isfinite(rows).all(axis=1)] for rows in flat])
    code = MotionCode().fit(seen)
    chains = [
        RecordedChain(
            take.name,
            take.phones,
            take.emotion,
            heard_features(take.audio, take.phones),
            SOUND_RATE,
            code.encode(rows),
            take.markers.rate,
        )
        for take, rows in zip(takes, flat, strict=True)
    ]
    return chains, space.points


@dataclass(frozen=True)
class English:
    """Draws English sentences as phones."""

    words: tuple[str, ...]
    tail: tuple[str, ...]
    follow: np.ndarray
    tail_shares: np.ndarray
    pronounced: dict[str, tuple[str, ...]]

    @classmethod
    def load(cls) -> English:
        import pocketsphinx

        model = pocketsphinx.NGramModel.readfile(pocketsphinx.get_model_path("en-us/en-us.lm.bin"))
        probability, value = model.prob, pocketsphinx.LogMath().exp
        phones = dict(dictionary_entries())
        often = {word: share for word in phones if (share := value(probability([word]))) > 1e-30}
        words = heapq.nlargest(NEIGHBOURS, often, key=lambda word: often[word])
        # One column more: any other word. The model takes the later word first.
        follow = np.array([[value(probability([after, before])) for after in words] for before in words])
        follow = np.concatenate([follow, np.maximum(1 - follow.sum(axis=1, keepdims=True), 0.0)], axis=1)
        tail = [word for word in often if word not in set(words)]
        shares = np.array([often[word] for word in tail])
        return cls(
            tuple(words),
            tuple(tail),
            np.cumsum(follow / follow.sum(axis=1, keepdims=True), axis=1),
            np.cumsum(shares / shares.sum()),
            {word: tuple(phones[word]) for word in often},
        )

    def sentences(self, random: np.random.Generator) -> Iterator[tuple[str, ...]]:
        """Phones of one sentence after another, pauses at both ends."""
        while True:
            before = int(random.integers(len(self.words)))
            said: list[str] = ["SIL"]
            for _ in range(int(random.integers(6, 14))):
                place = min(int(np.searchsorted(self.follow[before], random.random())), len(self.words))
                if place < len(self.words):
                    said += self.pronounced[self.words[place]]
                    before = place
                else:
                    other = min(int(np.searchsorted(self.tail_shares, random.random())), len(self.tail) - 1)
                    said += self.pronounced[self.tail[other]]
                    before = int(random.integers(len(self.words)))
            yield (*said, "SIL")


def grammar_graph(real: AnimeGraph, size: int, random: np.random.Generator, features_file: Path) -> AnimeGraph:
    """Recorded chains drawn with replacement until there are ``size`` nodes; the last one is cut."""
    bounds = np.flatnonzero(np.concatenate([~real.follows, [True]]))
    sources: list[np.ndarray] = []
    chains: list[np.ndarray] = []
    count = 0
    while count < size:
        chosen = int(random.integers(len(bounds) - 1))
        nodes = np.arange(bounds[chosen], bounds[chosen + 1])
        chains.append(np.full(len(nodes), len(chains)))
        sources.append(nodes)
        count += len(nodes)
    return _made(real, np.concatenate(sources)[:size], np.concatenate(chains)[:size], None, random, features_file)


def english_graph(
    real: AnimeGraph, english: English, size: int, random: np.random.Generator, features_file: Path
) -> AnimeGraph:
    """Drawn sentences until there are ``size`` nodes; the last one is cut."""
    labels: list[str] = []
    chains: list[int] = []
    for number, said in enumerate(english.sentences(random)):
        labels += said
        chains += [number] * len(said)
        if len(labels) >= size:
            break
    phones = np.array(labels[:size])
    sources = np.empty(size, dtype=np.int64)
    for label in np.unique(phones):
        where = np.flatnonzero(phones == label)
        sources[where] = random.choice(_recorded(real, str(label)), len(where))
    return _made(real, sources, np.array(chains[:size]), phones, random, features_file)


def _recorded(real: AnimeGraph, label: str) -> np.ndarray:
    recorded = frozenset((symbol, "") for symbol in real.symbols)
    numbers = [real.symbols.index(name) for name in stand_ins(label, None, recorded)[0]]
    return np.flatnonzero(np.isin(real.phones, numbers))


def _made(
    real: AnimeGraph,
    sources: np.ndarray,
    chains: np.ndarray,
    labels: np.ndarray | None,
    random: np.random.Generator,
    features_file: Path,
) -> AnimeGraph:
    symbols, phones = real.symbols, real.phones[sources]
    if labels is not None:
        symbols, phones = (tuple(str(name) for name in np.unique(labels)), np.unique(labels, return_inverse=True)[1])
    counts = real.feature_counts[sources]
    starts = np.cumsum([0, *counts])
    features = np.lib.format.open_memmap(features_file, "w+", np.float32, (int(starts[-1]), real.features.shape[1]))
    block = 50_000
    for first in range(0, len(sources), block):  # in blocks, so that memory stays small
        part = sources[first : first + block]
        rows = np.concatenate([real.features_of(node) for node in part])
        noise = random.standard_normal(rows.shape, dtype=np.float32) * np.float32(FEATURE_NOISE)
        features[starts[first] : starts[min(first + block, len(sources))]] = rows + noise
    features.flush()
    features = np.lib.format.open_memmap(features_file, "r")
    features[
        :: 4096 // features.itemsize // features.shape[1]
    ].sum()  # read once: a page of a file not yet read is slow
    axes = real.entries.shape[1]
    spread = np.float32(POSE_NOISE * np.sqrt(real.markers / axes))
    poses = [
        values[sources] + spread * random.standard_normal((len(sources), axes), dtype=np.float32)
        for values in (real.entries, real.exits)
    ]
    return AnimeGraph(
        symbols=symbols,
        emotion_names=real.emotion_names,
        takes=("made",),
        markers=real.markers,
        feature_rate=real.feature_rate,
        motion_rate=real.motion_rate,
        phones=phones.astype(np.int16),
        emotions=real.emotions[sources],
        chains=chains.astype(np.int32),
        take_of=np.zeros(len(sources), dtype=np.int32),
        starts=real.starts[sources],
        durations=real.durations[sources],
        entries=poses[0],
        exits=poses[1],
        features=features,
        feature_starts=starts[:-1],
        feature_counts=counts,
        motion=np.zeros((1, axes), dtype=np.float32),
        motion_starts=np.zeros(len(sources), dtype=np.int64),
        motion_counts=np.ones(len(sources), dtype=np.int32),
        take_motion=np.array([0, 1]),
    )


def recorded_questions(chains: Sequence[RecordedChain], length: int, count: int) -> list[SpokenPhones]:
    """Takes one after the other, cut into stretches of ``length`` phones."""
    asked: list[SpokenPhones] = []
    waiting: list[SpokenPhones] = []
    for chain in chains:
        waiting.append(spoken_phones(chain.phones, chain.features, chain.feature_rate))
        if sum(len(part) for part in waiting) >= length:
            asked.append(_run_together(waiting).part(0, length))
            waiting = []
        if len(asked) == count:
            break
    return asked


def english_questions(
    real: AnimeGraph, sentences: Sequence[tuple[str, ...]], length: int, count: int, random: np.random.Generator
) -> list[SpokenPhones]:
    """Sentences of a script as phones, each sounding like some recorded phone, in stretches of ``length``."""
    said = [label for sentence in sentences for label in sentence]
    asked: list[SpokenPhones] = []
    for first in range(0, len(said) - length + 1, length):
        labels = said[first : first + length]
        nodes = [int(random.choice(_recorded(real, label))) for label in labels]
        asked.append(
            SpokenPhones(
                tuple(labels),
                tuple(
                    real.features_of(node)
                    + FEATURE_NOISE * random.standard_normal(real.features_of(node).shape).astype(np.float32)
                    for node in nodes
                ),
                tuple(float(real.durations[node]) for node in nodes),
            )
        )
        if len(asked) == count:
            break
    return asked


def _run_together(parts: Sequence[SpokenPhones]) -> SpokenPhones:
    return SpokenPhones(
        tuple(phone for part in parts for phone in part.phones),
        tuple(rows for part in parts for rows in part.features),
        tuple(seconds for part in parts for seconds in part.durations),
    )


def real_graph(chains: Sequence[RecordedChain], markers: int) -> AnimeGraph:
    """The graph of the recordings themselves."""
    return build_graph(chains, markers)
