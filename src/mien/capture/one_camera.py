"""Speech that one camera saw: how far the jaw opens behind the lips, and how far the lips come forward.

A tracker infers much of a chin from the lips: of GRID it reports 5 mm of lowering at an /s/, where the speaker's teeth
all but meet, and behind shut lips. A chin that follows the lips whatever the jaw does is no evidence of a jaw. What
was solved with it is therefore taken as an upper bound, of which a part is believed (`believed`), and the lips are
solved again without the chin: what the jaw no longer gives, the lips give, as in people, who bare their lower teeth at
/s/ and /iy/. Where the tracker reports the lips' depth at all (`reported_depth`), that has a say too: a jaw turns the
lower lip back as it lowers it, muscles of the lips do not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mien.capture.knowledge import knowledge, source_named
from mien.capture.layouts import Layout
from mien.capture.person import Person, fit_person
from mien.capture.solver import Priors, Solved, Solver
from mien.core.tracks import MarkerTrack

__all__ = ["believed", "fit_speaker", "reported_depth", "solve_spoken"]

Floats = NDArray[np.float64]

_BEHIND = 0.25
"""Hand-made: how much of a jaw that is open behind shut lips is believed."""
_LIPS, _FIRST = 0.22, 0.55
"""Hand-made: how much of jawOpen the lips do instead at most, and their share of the first of it."""
_ROUND = 0.5
"""Hand-made: mouthPucker at which the lips do nothing of the jaw's: round lips do not bare the lower teeth."""
_DEEP = 0.15
"""Share of the lips' motion in depth from which it has a say, and how much it then counts beside height."""
_DEPTH_COUNTS = 0.5
_FRAMES = 800


def believed(jaw: Floats, close: Floats, pucker: Floats | float = 0.0) -> tuple[Floats, Floats]:
    """How far jawOpen and mouthClose are believed that were solved from a tracker's lips and chin.

    Of equal parts of the two, which hardly move the lips, `_BEHIND` stays; of the rest of the jaw the lips do much of
    the first and little of the last: a mouth that is wide open has an open jaw. Round lips do less of it.

    Examples
    --------
    >>> jaw, close = believed(np.array([0.28, 0.35, 0.8]), np.array([0.11, 0.06, 0.0]))
    >>> jaw.round(2).tolist(), close.round(2).tolist()
    ([0.1, 0.16, 0.59], [0.03, 0.02, 0.0])
    """
    taken = np.minimum((1 - _BEHIND) * close, jaw)
    left = jaw - taken
    lips = _LIPS * np.tanh(_FIRST * left / _LIPS) * (1 - np.clip(np.asarray(pucker) / _ROUND, 0.0, 1.0))
    return left - lips, close - taken


def reported_depth(person: Person, tracks: Sequence[MarkerTrack]) -> float:
    """How much of the lips' motion in depth a tracker reports, beside what height and side say: a slope, 0 at least."""
    frames = np.concatenate([t.positions[:, [t.names.index(name) for name in person.markers]] for t in tracks])
    frames = frames[np.isfinite(frames).all(axis=(1, 2))][:_FRAMES]
    lips = person.region == [region.name for region in knowledge().regions].index("lips")
    if len(frames) < 2 or not lips.any():
        return 0.0
    weights = Solver(person).solve(frames, float(tracks[0].rate.fps)).weights
    asked = ((frames - person.neutral) @ person.turn.T)[:, lips, 2]
    shown = np.einsum("tc,cm->tm", weights, person.basis[:, lips, 2])
    asked, shown = asked - asked.mean(axis=0), shown - shown.mean(axis=0)
    return max(0.0, float((asked * shown).sum() / max((shown**2).sum(), 1e-9)))


def fit_speaker(tracks: Sequence[MarkerTrack], layout: Layout | str, source: str = "tracker") -> Person:
    """`mien.capture.fit_person` of somebody in speech: what a tracker reports of depth is measured as well."""
    person = fit_person(tracks, layout, source)
    return replace(person, depth=reported_depth(person, tracks)) if source == "tracker" else person


def solve_spoken(person: Person, positions: Floats, fps: float, priors: Priors | None = None) -> Solved:
    """As `Solver.solve`, of a person in speech whom a tracker saw."""
    first = Solver(person, priors).solve(positions, fps)
    if not {"jawOpen", "mouthClose"} <= set(person.channels):
        return first
    jaw, close = (person.channels.index(name) for name in ("jawOpen", "mouthClose"))
    most = np.ones_like(first.weights)
    pucker = first.weights[:, person.channels.index("mouthPucker")] if "mouthPucker" in person.channels else 0.0
    opened, most[:, close] = believed(first.weights[:, jaw], first.weights[:, close], pucker)
    most[:, jaw] = np.maximum(opened - most[:, close], 0.0)  # the solver's mouthClose opens the jaw too
    chin = [region.name for region in knowledge().regions].index("chin")
    source = source_named(person.source)
    if person.depth > _DEEP:
        source = replace(source, gain=(*source.gain[:2], 1.0), weight=(*source.weight[:2], _DEPTH_COUNTS))
    bare = replace(person, region=np.where(person.region == chin, -1, person.region))
    return Solver(bare, priors, source).solve(positions, fps, most)
