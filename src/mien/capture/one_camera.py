"""Speech that one camera saw: how far the jaw opens behind the lips, and how far the lips come forward.

A tracker infers much of a chin from the lips: of GRID it reports 5 mm of lowering at an /s/, where the speaker's teeth
all but meet, and behind shut lips. A chin that follows the lips whatever the jaw does is no evidence of a jaw. The lips
are: a jaw lowers the lower one alone, as at /a/, while the muscles that part lips over shut teeth, as at /s/ and /i/,
raise the upper one too. How much of the lower lip's way is the jaw's was learned from the curves of a production rig
(`[jaw]` of ``assets/capture/solver.toml``). The lips are then solved again without the chin below such a jaw
(`believed`). Where the tracker reports the lips' depth at all (`reported_depth`), that has a say too: a jaw turns the
lower lip back as it lowers it, muscles of the lips do not.

Seen from the front, round lips that part are narrow lips over an open jaw. A part of such an opening is taken for a
funnel (`rounded_lips`, hand-made), so that lips come forward and round.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fnmatch import fnmatchcase

import numpy as np
from numpy.typing import NDArray

from mien.capture.knowledge import knowledge, source_named
from mien.capture.layouts import Layout
from mien.capture.person import Person, fit_person
from mien.capture.solver import Priors, Solved, Solver
from mien.core.tracks import MarkerTrack

__all__ = ["believed", "fit_speaker", "reported_depth", "reported_raising", "solve_spoken"]

Floats = NDArray[np.float64]

_JAW = ("jawOpen", "mouthClose")
_FUNNEL, _FROM, _PARTS = 2.5, 0.1, 0.75
"""Hand-made: mouthFunnel of lips for one of mouthPucker from where on, and its share at most of what a jaw opens."""
_DEEP = 0.15
"""Share of the lips' motion in depth from which it has a say, and how much it then counts beside height."""
_DEPTH_COUNTS = 0.5
_FRAMES = 800
_WIDE, _LOWERED_MM = 0.9, 3.0
_PEOPLE = 0.1
"""Hand-made: from which quantile of the lower lip's lowering on a mouth is wide open, and from how many mm; and how
much of that way people raise the upper lip themselves."""


def believed(person: Person, weights: Floats) -> tuple[Floats, Floats]:
    """How far jawOpen and mouthClose are believed that were solved from a tracker's lips and chin.

    Parameters
    ----------
    person : Person
        Whose lips, jawOpen and mouthClose are known.
    weights : ndarray, shape (frames, channels)
        As solved with the chin.

    Returns
    -------
    jaw, close : ndarray, shape (frames,)
        jawOpen as far as the lips speak for it, never more than solved; mouthClose at most: what lips that are apart by
        less than such a jaw gives may have of it.
    """
    lips, known = next(seen for seen in person.openings if seen.opening.name == "mouth"), knowledge().jaw
    counted = [not fnmatchcase(name, "*Smile*") and not fnmatchcase(name, "noseSneer*") for name in person.channels]
    height = person.basis[:, :, lips.opening.axis] * np.array(counted)[:, None]
    raising, lowering = (height @ np.maximum(lips.rows, 0.0), height @ np.minimum(lips.rows, 0.0))
    raised, lowered = (np.einsum("tc,c->t", weights, way) for way in (raising, lowering))
    jaw = person.channels.index("jawOpen")
    opened = known.lower * lowered - known.upper * np.maximum(raised - person.raised * np.maximum(lowered, 0.0), 0.0)
    opened = np.clip(opened / lowering[jaw], 0.0, weights[:, jaw])
    return opened, np.clip(opened - (raised + lowered) / lowering[jaw], 0.0, opened)


def rounded_lips(person: Person, weights: Floats, opened: Floats) -> tuple[Floats, Floats]:
    """How far jawOpen and mouthFunnel are believed of round lips: seen from the front, both open them alike.

    Of what pucker and jaw were solved to do together, lips that come forward and part do some: mouthFunnel as far as
    mouthPucker, for which the jaw opens less.
    """
    pucker, funnel, jaw = (person.channels.index(name) for name in ("mouthPucker", "mouthFunnel", "jawOpen"))
    lips = next(seen for seen in person.openings if seen.opening.name == "mouth")
    parts = person.basis[:, :, lips.opening.axis] @ lips.rows
    gap = np.clip(weights @ parts, 0.0, opened * parts[jaw])
    found = np.minimum(_FUNNEL * np.maximum(weights[:, pucker] - _FROM, 0.0), _PARTS * gap / parts[funnel])
    return opened - found * parts[funnel] / parts[jaw], np.minimum(found + weights[:, funnel], 1.0)


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


def reported_raising(person: Person, tracks: Sequence[MarkerTrack]) -> float:
    """How much the upper lip is reported to rise for each lowering of the lower one by a jaw, beyond what people do.

    Lips are furthest apart by the jaw, which leaves the upper one where it is. Of faces that it knows little of, such
    as drawn ones, a tracker then lays a part of the opening on the upper lip.
    """
    mouth = [seen for seen in person.openings if seen.opening.name == "mouth"]
    frames = np.concatenate([t.positions[:, [t.names.index(name) for name in person.markers]] for t in tracks])
    frames = frames[np.isfinite(frames).all(axis=(1, 2))]
    if len(frames) < 2 or not mouth:
        return 0.0
    rows, axis = mouth[0].rows, mouth[0].opening.axis
    height = ((frames - person.neutral) @ person.turn.T)[:, :, axis]
    raised, lowered = height @ np.maximum(rows, 0.0), height @ np.minimum(rows, 0.0)
    wide = lowered >= max(np.quantile(lowered, _WIDE), _LOWERED_MM)
    return max(0.0, float(np.quantile(raised[wide] / lowered[wide], 0.25)) - _PEOPLE) if wide.any() else 0.0


def fit_speaker(tracks: Sequence[MarkerTrack], layout: Layout | str, source: str = "tracker") -> Person:
    """`mien.capture.fit_person` of somebody in speech: what a tracker reports of depth and upper lips is measured."""
    person = fit_person(tracks, layout, source)
    if source != "tracker":
        return person
    return replace(person, depth=reported_depth(person, tracks), raised=reported_raising(person, tracks))


def solve_spoken(person: Person, positions: Floats, fps: float, priors: Priors | None = None) -> Solved:
    """As `Solver.solve`, of a person in speech whom a tracker saw."""
    first = Solver(person, priors).solve(positions, fps)
    if not set(_JAW) <= set(person.channels) or not any(seen.opening.name == "mouth" for seen in person.openings):
        return first
    opened, shut = believed(person, first.weights)
    done = {"jawOpen": opened}
    if {"mouthPucker", "mouthFunnel"} <= set(person.channels):
        done["jawOpen"], done["mouthFunnel"] = rounded_lips(person, first.weights, opened)
        shut = np.minimum(shut, done["jawOpen"])
    chin = [region.name for region in knowledge().regions].index("chin")
    source = source_named(person.source)
    if person.depth > _DEEP:
        source = replace(source, gain=(*source.gain[:2], 1.0), weight=(*source.weight[:2], _DEPTH_COUNTS))
    rest = [number for number, name in enumerate(person.channels) if name not in done]
    others = [number for number in range(len(person.channels)) if number not in rest]
    bare = replace(
        person,
        region=np.where(person.region == chin, -1, person.region),
        channels=tuple(person.channels[number] for number in rest),
        basis=person.basis[rest],
    )
    weights, most = np.zeros_like(first.weights), np.ones((len(opened), len(rest)))
    weights[:, others] = np.stack([done[person.channels[number]] for number in others], axis=1)
    most[:, bare.channels.index("mouthClose")] = shut
    taken = np.einsum("tc,cmk->tmk", weights[:, others], person.basis[others])
    found = Solver(bare, priors, source).solve(positions, fps, most, taken)
    weights[:, rest] = found.weights
    return Solved(weights, found.missed)
