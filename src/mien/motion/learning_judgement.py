"""Judgement before learning: who speaks, how much is there, which takes must stay out, and what cannot be learned.

Everything is said with names and numbers; what would spoil the result is left out or refused.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mien.capture.layouts import load_layout
from mien.core.audio import Audio
from mien.core.errors import InputError, Note, unknown_name
from mien.corpus.face_loss import MOST_LOST, share_lost
from mien.corpus.recordings import Corpus
from mien.corpus.speech_inventory import inventory_of
from mien.corpus.take import Take
from mien.motion.expression.expression_motion import Twins, expressive_displacement, find_twins
from mien.motion.maps.emotion_maps import LEAST_SENTENCES

__all__ = ["MIXED", "Judgement", "faces_apart", "judge", "judge_corpus", "variance_ratio"]

Floats = NDArray[np.float64]
Progress = Callable[[int, int], None]

MIXED = "mixed"
"""What ``--speakers`` says where several people may share one mouth."""
FEW_MINUTES = 2.0
"""Minutes of speech below which a mouth is learned with a warning."""
_NAMED = 3
_FEWEST_MARKERS = 3
_ANOTHER_FACE = 6.0
"""Millimetres (RMS over the markers of cheeks and jaw) by which takes show different people: any two of 120 takes of
one speaker differ by 4.0 at most, takes of another speaker of the same corpus by 8.0 at least."""
_STRAY = 0.1
"""Share of the takes up to which another face is a doubt about those takes, and not another person."""


@dataclass(frozen=True)
class Judgement:
    """What is learned from, and what should be known of it.

    Attributes
    ----------
    takes : tuple of Take
        Neutral ones, for speech.
    felt : tuple of Take
        Expressive ones.
    twins : tuple of Take
        Those of them that have a neutral twin: expressions are learned from them.
    notes : tuple of Note
    """

    takes: tuple[Take, ...]
    felt: tuple[Take, ...]
    twins: tuple[Take, ...]
    notes: tuple[Note, ...]


def judge(takes: Sequence[Take], felt: Sequence[Take] = (), *, speakers: str = "one") -> Judgement:
    """Judge what would be learned from.

    Parameters
    ----------
    takes : sequence of Take
        Neutral ones.
    felt : sequence of Take
        Expressive ones.
    speakers : str
        ``"one"``: there must be one; ``"mixed"``: several people may share one mouth; else the name of the one to
        learn from.

    Raises
    ------
    InputError
        If several people are among them and ``speakers`` is not ``"mixed"``, nobody has the name, or no take is left.
    """
    if speakers not in ("one", MIXED):
        known = sorted({take.speaker for take in (*takes, *felt) if take.speaker})
        if speakers not in known:
            raise unknown_name("speaker", speakers, known)
        takes, felt = ([take for take in some if take.speaker == speakers] for some in (takes, felt))
    notes = [*_people([*takes, *felt], mixed=speakers == MIXED)]
    kept, lost = _seen(takes)
    felt, more = _seen(felt)
    notes += lost + more
    if not kept and not felt:
        raise InputError(
            f"no take is left to learn from: in all {len(lost) + len(more)} of them the face was lost in more than "
            f"{MOST_LOST:.0%} of the frames; record again"
        )
    said = inventory_of(take.phones for take in kept or felt)
    few = said.seconds / 60 < FEW_MINUTES
    notes.append(
        Note(
            "warning" if few else "note",
            f"{said.seconds / 60:.1f} minutes of speech in {said.takes} takes"
            + (f": at least {FEW_MINUTES:g} are needed, and twenty are good" if few else ""),
        )
    )
    notes.append(Note("warning" if said.missing_phones else "note", f"phones: {said.phones_line}"))
    notes.append(Note("note", f"phone pairs: {said.pairs_line}"))
    twins, more = _twins(kept, felt)
    with_twin = tuple(pair.expressive for pair in twins)
    return Judgement(tuple(kept), tuple(felt), with_twin, (*notes, *more, *_maps(kept, twins)))


def judge_corpus(corpus: Corpus, *, speakers: str = "one", progress: Progress | None = None) -> Judgement:
    """Judge all takes of a corpus, without keeping their sound; those that cannot be read are left out.

    Raises
    ------
    InputError
        As `judge`.
    """
    neutral: list[Take] = []
    felt: list[Take] = []
    for number, name in enumerate(corpus.names, start=1):
        try:
            take = corpus.take(name)
        except InputError:
            continue  # the check of the corpus says so
        light = replace(take, audio=Audio.silence(take.duration, 1000))
        (neutral if take.emotion in ("", "neutral") else felt).append(light)
        if progress is not None:
            progress(number, len(corpus))
    if not neutral and not felt:
        raise InputError(corpus.unfinished or f"{corpus.folder}: it has no take to learn from")
    return judge(neutral, felt, speakers=speakers)


def variance_ratio(twins: Twins) -> float:
    """Variance of the mouth after its twin's words were taken out, over that before.

    Below 1 the twin explains the words; above 1 subtracting it adds motion that neither take has: it is no twin.

    Raises
    ------
    InputError
        If the two do not say the same.
    """
    felt = twins.expressive
    left = expressive_displacement(twins)
    mouth = set(load_layout(felt.layout).groups["mouth"])
    columns = [place for place, name in enumerate(felt.markers.names) if name in mouth]
    spoken = [phone for phone in felt.phones if phone.label != "SIL"]
    times = felt.markers.rate.times(len(felt.markers))
    held = (times >= spoken[0].start) & (times < spoken[-1].end) if spoken else np.ones(len(times), dtype=bool)
    before = felt.markers.positions[held][:, columns]
    return float(left[:, columns].var(axis=0).sum() / max(float(np.nanvar(before, axis=0).sum()), 1e-12))


def faces_apart(takes: Sequence[Take]) -> list[list[str]]:
    """Takes by the faces that they show, largest group first: those whose cheeks and jaw lie alike.

    Takes of other layouts than the first, and those without three such markers, are left out.
    """
    groups: list[tuple[Floats, list[str]]] = []
    for take in takes:
        if take.layout != takes[0].layout or take.markers.names != takes[0].markers.names:
            continue
        lower = set(load_layout(take.layout).groups["lower"])
        places = take.markers.positions[:, [name in lower for name in take.markers.names]]
        seen = places[np.isfinite(places).all(axis=(1, 2))]
        if places.shape[1] < _FEWEST_MARKERS or not len(seen):
            continue
        face = np.median(seen, axis=0)
        away = [float(np.sqrt(((face - first) ** 2).sum(axis=1).mean())) for first, _ in groups]
        if away and min(away) < _ANOTHER_FACE:
            groups[int(np.argmin(away))][1].append(take.name)
        else:
            groups.append((face, [take.name]))
    return sorted((members for _, members in groups), key=len, reverse=True)


def _people(takes: Sequence[Take], *, mixed: bool) -> list[Note]:
    """Refuse several people in one mouth, by their names or by their faces."""
    counts = Counter(take.speaker or "(not named)" for take in takes)
    faces = faces_apart(takes) if len(counts) == 1 else []
    if len(counts) > 1:
        what = f"{len(counts)} speakers: " + ", ".join(f"{who} {n} takes" for who, n in sorted(counts.items()))
    elif len(faces) > 1 and len(takes) - len(faces[0]) <= _STRAY * len(takes):
        strays = [name for members in faces[1:] for name in members]
        said = "show a face unlike that of the others: another person, or badly tracked?"
        return [Note("warning", f"{len(strays)} takes {said} {_listed(strays)}")]
    elif len(faces) > 1:
        what = f"{len(faces)} faces that are not one person's: " + ", ".join(
            f"{members[0]} and {len(members) - 1} more" if len(members) > 1 else members[0] for members in faces[:4]
        )
    else:
        return []
    if not mixed:
        raise InputError(
            f"one mouth cannot be learned from {what}; name one (--speakers NAME), leave the others out "
            "(--exclude-names), or say --speakers mixed"
        )
    return [Note("warning", f"one mouth is learned from {what}")]


def _seen(takes: Iterable[Take]) -> tuple[list[Take], list[Note]]:
    """Takes whose face was seen, and a warning for each other one."""
    kept, notes = [], []
    for take in takes:
        share = share_lost(take)
        if share > MOST_LOST:
            said = f"the face was lost in {share:.0%} of its frames (at most {MOST_LOST:.0%})"
            notes.append(Note("warning", f"left out: take {take.name!r}: {said}"))
        else:
            kept.append(take)
    return kept, notes


def _twins(takes: Sequence[Take], felt: Sequence[Take]) -> tuple[list[Twins], list[Note]]:
    """Expressive takes with a twin that is one; a warning for all without, and for each twin that is none."""
    found, notes = find_twins([*takes, *felt]), []
    with_twin = {pair.expressive.name for pair in found}
    alone = [take for take in felt if take.name not in with_twin]
    if alone:
        kinds = ", ".join(f"{name} {n}" for name, n in sorted(Counter(take.emotion for take in alone).items()))
        notes.append(
            Note(
                "warning",
                f"no expression is learned from {len(alone)} expressive takes ({kinds}) without a neutral take of the "
                f"same sentence by the same speaker: {_listed(take.name for take in alone)}",
            )
        )
    kept = []
    for pair in found:
        try:
            ratio = variance_ratio(pair)
        except InputError:
            kept.append(pair)  # learning says why it cannot be used
            continue
        if ratio > 1.0:
            said = f"its mouth's variance grows {ratio:.2f} times (at most 1) without that of {pair.neutral.name!r}"
            notes.append(
                Note("warning", f"no expression is learned from {pair.expressive.name!r}: {said}: they do not match")
            )
        else:
            kept.append(pair)
    return kept, notes


def _maps(takes: Sequence[Take], twins: Sequence[Twins]) -> list[Note]:
    """Why no map from one emotion to another can be learned; nothing where one can."""
    if not twins:
        return []
    said: dict[str, set[tuple[str, str]]] = {"neutral": set()}
    holed = 0
    for take in (*takes, *(pair.expressive for pair in twins)):
        if np.isfinite(take.markers.positions).all():
            said.setdefault(take.emotion or "neutral", set()).add(_sentence(take))
        else:
            holed += 1
    names = sorted(said)
    shared = {(a, b): len(said[a] & said[b]) for i, a in enumerate(names) for b in names[i + 1 :]}
    if any(count >= LEAST_SENTENCES for count in shared.values()):
        return []
    if not shared:
        return [Note("warning", "no emotion map is learned: every expressive take lacks a marker")]
    most = max(shared, key=lambda both: shared[both])
    return [
        Note(
            "warning",
            f"no emotion map is learned: {most[0]} and {most[1]} share {shared[most]} "
            f"sentence{'s' if shared[most] != 1 else ''}, {LEAST_SENTENCES} are needed"
            + (f" ({holed} takes lack a marker and do not count)" if holed else ""),
        )
    ]


def _sentence(take: Take) -> tuple[str, str]:
    return take.speaker, take.sentence or " ".join(word.label.lower() for word in take.words)


def _listed(names: Iterable[str]) -> str:
    every = list(names)
    more = f" and {len(every) - _NAMED} more" if len(every) > _NAMED else ""
    return ", ".join(every[:_NAMED]) + more
