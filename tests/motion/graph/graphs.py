"""Small graphs and questions to them, and the paper's own search as a referee."""

from __future__ import annotations

import heapq

import numpy as np

from mien.core.timeline import FrameRate, Interval, Tier
from mien.motion.graph.audio_distance import audio_distance
from mien.motion.graph.graph import RecordedChain, build_graph
from mien.motion.graph.query import spoken_phones

SOUND, MOTION = FrameRate.of(50), FrameRate.of(25)
MARKERS = 2


def tier_of(labels, durations):
    ends = np.cumsum(durations)
    return Tier(
        "phones",
        tuple(
            Interval(float(end - length), float(end), label)
            for end, length, label in zip(ends, durations, labels, strict=True)
        ),
    )


def speech(random, labels, coefficients=3):
    """A tier of phones and features for it."""
    tier = tier_of(labels, random.uniform(0.03, 0.15, len(labels)))
    frames = SOUND.frames_covering(tier.intervals[-1].end)
    return tier, random.standard_normal((frames, coefficients)).cumsum(axis=0) * 0.5


def small_graph(seed, chains, alphabet, emotions=("neutral",), instants=False, axes=4):
    """A graph of random chains; every phone of the alphabet need not be there."""
    random = np.random.default_rng(seed)
    takes = []
    for number, length in enumerate(chains):
        tier, features = speech(random, random.choice(list(alphabet), length).tolist())
        frames = MOTION.frames_covering(tier.intervals[-1].end)
        motion = random.standard_normal((frames, axes)).cumsum(axis=0)
        emotion = emotions[number % len(emotions)]
        takes.append(RecordedChain(f"take{number}", tier, emotion, features, SOUND, motion, MOTION))
    return build_graph(takes, MARKERS, instants)


def small_question(seed, length, alphabet, emotion=None):
    random = np.random.default_rng(seed)
    tier, features = speech(random, random.choice(list(alphabet), length).tolist())
    return spoken_phones(tier, features, SOUND, emotion)


def recorded_question(graph, seed, length):
    """Phones as they follow one another in the graph, for long runs; their sound is new."""
    random = np.random.default_rng(seed)
    first = int(random.integers(max(1, len(graph) - length)))
    labels = [graph.symbols[phone] for phone in graph.phones[first : first + length]]
    tier, features = speech(random, labels)
    return spoken_phones(tier, features, SOUND)


def plain_cost(graph, asked, weights, nodes):
    """Cost of a way, written down from the definition once more."""
    total = 0.0
    for place, node in enumerate(nodes):
        total += weights.audio_of(asked.phones[place]) * audio_distance(asked.features[place], graph.features_of(node))
        ratio = max(float(graph.durations[node]), 0.005) / max(asked.durations[place], 0.005)
        total += weights.duration * abs(np.log(ratio))
        if asked.emotions is not None and not weights.emotion_is_filter:
            total += weights.emotion * (graph.emotion_names[graph.emotions[node]] != asked.emotions[place])
        if place:
            total += transition(graph, weights, nodes[place - 1], node)
    return total


def transition(graph, weights, before, after):
    rms = np.sqrt(((graph.exits[before].astype(float) - graph.entries[after]) ** 2).sum() / graph.markers)
    recorded = after == before + 1 and graph.chains[before] == graph.chains[after]
    if recorded:
        return weights.join * rms if weights.join_everywhere else 0.0
    return weights.jump + weights.join * rms


def priority_queue_search(graph, asked, weights):
    """Section 4.2 of the paper, step by step: a queue of partial sequences, the cheapest extended first."""
    nodes_of = {s: np.flatnonzero(graph.phones == k).tolist() for k, s in enumerate(graph.symbols)}
    best, best_cost = None, np.inf
    queue = [(plain_cost(graph, asked, weights, [node]), (node,)) for node in nodes_of[asked.phones[0]]]
    heapq.heapify(queue)
    alone = {}
    while queue:  # (4)
        cost, sequence = heapq.heappop(queue)  # (2)
        if len(sequence) == len(asked):  # (3)
            queue = [entry for entry in queue if entry[0] <= cost]
            heapq.heapify(queue)
            if cost < best_cost:
                best, best_cost = sequence, cost
            continue
        place = len(sequence)
        for node in nodes_of[asked.phones[place]]:
            if (place, node) not in alone:
                alone[place, node] = plain_cost(graph, asked.part(place, place + 1), weights, [node])
            further = cost + transition(graph, weights, sequence[-1], node) + alone[place, node]
            heapq.heappush(queue, (further, (*sequence, node)))
    return best, best_cost
