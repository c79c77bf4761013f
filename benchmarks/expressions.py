"""The hand-made expressions beside real faces, and what is sampled from them beside its source.

::

    python benchmarks/expressions.py [--out docs/tables/expressions.md]

Speech: the default performer speaks `SENTENCES` with the default voice. Lips are shut where the upper inner lip (13) on
the face stands less than 0.75 mm higher above the lower (14) than at rest (`mien.metrics.closure`); upwards, since a
raised chin pushes the lower lip forward while it shuts. Strength is the mean
distance of all markers from the same line spoken neutral.

Displacements are means over the spoken lines, from the same lines spoken neutral, of the markers of layout
mediapipe-218 on the default face: brows (landmarks 55 285 and 70 300), lip corners (61 291), inner lips (13 14), lids
(159 145 and 386 374). Real faces: three actors, one sentence, 25 frames/s, a face tracker; displacement from the same
actor's neutral, mean of three. Speech is in both. Upper face: both brows and the lids; mouth: corner, width, opening;
cosine between ours and theirs; size: the length of ours over theirs, asymmetry left out. At a ceiling: the largest
share of frames in which one channel stands at 1 (blinks left out). Lips: distance of landmarks 13 and 14 in three
dimensions at the nearest frame of each /p b m/.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import mien
from mien.capture.layouts import load_layout
from mien.core import channels
from mien.core.files import replace_when_complete
from mien.core.timeline import FrameRate
from mien.core.utterance import Utterance
from mien.face.library import load_face
from mien.metrics.closure import ClosureCounts, closure_counts
from mien.motion.expression.expression_space import RATE, ExpressionSettings, ExpressionSpace
from mien.motion.expression.hand_made_performance import (
    hand_made_expression,
    hand_made_performance,
    hand_made_space,
    marker_basis,
)
from mien.motion.expression.patch_sampling import PatchSettings
from mien.motion.mouth.hand_made_mouth import MouthMotion
from mien.motion.performer import MouthModel
from mien.motion.performers import load_performer
from mien.pipeline.perform import perform
from mien.text.score import EmotionSpan, Score

Floats = NDArray[np.float64]
LAYOUT = "mediapipe-218"
SEEDS = 4
GRADES = (0.0, 0.25, 0.5, 0.75, 1.0)
SENTENCES = (
    "Maybe my baby brother bought the maple syrup.",
    "We may put my blue book by the bed.",
    "People become simple when they pamper a puppy.",
    "Bob promised to mop up the problem before summer.",
)
MEASURES = (
    "inner brow up",
    "outer brow up",
    "lip corner up",
    "mouth width",
    "lip opening",
    "lid gap",
    "corner asymmetry",
)
# Means of three actors, mm (see above). The mark * in the table: the same sign in all three.
REAL = {
    "angry": ("-5.4*", "-3.8*", "+0.3", "+1.8", "+7.3*", "-3.3*", "+0.8*"),
    "contempt": ("+3.5*", "+2.2*", "0.0", "+2.6*", "+4.5*", "-1.7", "+3.1*"),
    "disgusted": ("-5.0*", "-3.1*", "-0.7", "+8.1*", "+4.6*", "-3.0*", "+0.6"),
    "afraid": ("+3.8*", "+1.8*", "-3.2", "+4.6*", "+6.5*", "+1.7*", "+0.5"),
    "happy": ("+1.9", "+1.8", "+3.4*", "+11.5*", "+6.1*", "-1.8*", "+0.8*"),
    "sad": ("-0.4", "-2.1", "-2.8", "+5.9*", "+0.8", "-3.8*", "+0.3"),
    "surprised": ("+5.2*", "+3.2*", "-4.4*", "-1.4", "+6.2*", "+2.9*", "+0.1*"),
}


def measures(positions: Floats) -> Floats:
    """`MEASURES` of every sample, shape (samples, measures), mm; positions (samples, markers, 3)."""
    layout = load_layout(LAYOUT)

    def at(landmark: int) -> Floats:
        return positions[:, layout.markers.index(layout.landmarks[landmark])]

    def apart(one: int, other: int) -> Floats:
        return np.linalg.norm(at(one) - at(other), axis=1)

    columns = [
        (at(55)[:, 1] + at(285)[:, 1]) / 2,
        (at(70)[:, 1] + at(300)[:, 1]) / 2,
        (at(61)[:, 1] + at(291)[:, 1]) / 2,
        apart(61, 291),
        apart(13, 14),
        (apart(159, 145) + apart(386, 374)) / 2,
        np.abs(at(61)[:, 1] - at(291)[:, 1]),
    ]
    return np.stack(columns, axis=1)


class Stage:
    """The default performer, who speaks the same lines with every emotion."""

    def __init__(self) -> None:
        self.layout = load_layout(LAYOUT)
        self.basis = marker_basis(load_face("default"), LAYOUT, self.layout.markers)
        self.rate = FrameRate.of(50)
        self.said = [mien.say(text).utterance for text in SENTENCES]
        performer = load_performer("default")
        self.performer = replace(performer, mouth=_Once(performer.mouth))

    def values(self, *emotions: EmotionSpan) -> list[Floats]:
        score = Score(emotions)
        return [perform(line, score, self.performer, self.rate, seed=1).channels.values for line in self.said]

    def positions(self, values: Floats) -> Floats:
        return self.layout.places + (values @ self.basis).reshape(len(values), -1, 3)

    def lips_at_bilabials(self, made: list[Floats]) -> Floats:
        """Distance of the inner lips at the nearest frame of each /p b m/, mm."""
        upper, lower = (self.layout.markers.index(self.layout.landmarks[number]) for number in (13, 14))
        found = []
        for line, values in zip(self.said, made, strict=True):
            rows, times = self.positions(values), self.rate.times(len(values))
            apart = np.linalg.norm(rows[:, upper] - rows[:, lower], axis=1)
            for phone in line.phones:
                if phone.label in ("P", "B", "M"):
                    found.append(apart[(times >= phone.start - 0.01) & (times <= phone.end)].min())
        return np.array(found)


_UPPER, _MOUTH, _SIZED = (0, 1, 5), (2, 3, 4), (0, 1, 2, 3, 4, 5)
_BLINKS = [channels.ALL.index(f"eyeBlink{side}") for side in ("Left", "Right")]


def _cosine(one: Floats, other: Floats) -> float:
    return float(one @ other / np.linalg.norm(one) / np.linalg.norm(other))


def faces(stage: Stage) -> list[str]:
    neutral = stage.values()
    rest = measures(stage.positions(np.concatenate(neutral))).mean(axis=0)
    lines = [
        "## Displacement from neutral speech, mm: ours / real",
        "",
        "| emotion | " + " | ".join(MEASURES) + " | signs as in all three actors |",
        "| --- |" + " --- |" * (len(MEASURES) + 1),
    ]
    sizes = [
        "",
        "## Direction and size",
        "",
        "| emotion | cosine, upper face | cosine, mouth | size | at a ceiling | lips at /p b m/, mm: median | most |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for emotion in ("neutral", *(name for name in hand_made_expression().names if name != "neutral")):
        made = neutral if emotion == "neutral" else stage.values(EmotionSpan(emotion))
        values = np.concatenate(made)
        ours, cells = measures(stage.positions(values)).mean(axis=0) - rest, ["", "", ""]
        if emotion in REAL:
            real = REAL[emotion]
            theirs = np.array([float(figure.rstrip("*")) for figure in real])
            sure = [place for place, figure in enumerate(real) if "*" in figure]
            agree = sum(ours[place] * theirs[place] > 0 for place in sure)
            shown = [f"{mine:+.1f} / {figure}" for mine, figure in zip(ours, real, strict=True)]
            lines.append(f"| {emotion} | " + " | ".join(shown) + f" | {agree} of {len(sure)} |")
            size = np.linalg.norm(ours[list(_SIZED)]) / np.linalg.norm(theirs[list(_SIZED)])
            cells = [f"{_cosine(ours[list(part)], theirs[list(part)]):.2f}" for part in (_UPPER, _MOUTH)] + [
                f"{size:.2f}"
            ]
        full = (values[:, : len(channels.WEIGHTS)] >= 0.999).mean(axis=0)
        full[_BLINKS] = 0.0
        lips = stage.lips_at_bilabials(made)
        cells += [f"{full.max():.1%}", f"{np.median(lips):.2f}", f"{lips.max():.2f}"]
        sizes.append(f"| {emotion} | " + " | ".join(cells) + " |")
    return [*lines, *sizes, "", "`frustrated` was not among the measured emotions.", "", *_wander(stage)]


def _wander(stage: Stage) -> list[str]:
    layout = stage.layout
    lines = [
        "## Wander about the mean",
        "",
        "| emotion | upper face: sd mm | speed mm/s | mouth: sd mm | speed mm/s |",
        "| --- | --- | --- | --- | --- |",
    ]
    lines += ["| real, all emotions, as tracked | 0.96 (neutral 0.79) | 6 | 2.8 (speech included) | 18 |"]
    lines += ["| the same without the tracker's noise and the head's motion | 0.51 to 0.69 (neutral 0.42) | | | |"]
    groups = [
        [layout.markers.index(m) for m in layout.groups[name] if m not in layout.rigid] for name in ("upper", "mouth")
    ]
    for emotion in hand_made_expression().names:
        places = (hand_made_performance(emotion) @ stage.basis).reshape(-1, len(layout.markers), 3)
        motion, cells = layout.places + places, []
        for group in groups:
            part = motion[:, group]
            spread = np.sqrt(((part - part.mean(axis=0)) ** 2).sum(axis=2).mean())
            speed = np.linalg.norm(np.diff(part, axis=0), axis=2).mean() * RATE
            cells += [f"{spread:.2f}", f"{speed:.1f}"]
        lines.append(f"| {emotion} | " + " | ".join(cells) + " |")
    return lines


class _Once:
    """A mouth that moves once for each line: its motion does not depend on the emotion."""

    def __init__(self, mouth: MouthModel) -> None:
        self.mouth, self.kept = mouth, dict[int, MouthMotion]()

    def perform(self, utterance: Utterance, rate: FrameRate) -> MouthMotion:
        if id(utterance) not in self.kept:
            self.kept[id(utterance)] = self.mouth.perform(utterance, rate)
        return self.kept[id(utterance)]


def spoken(stage: Stage) -> list[str]:
    """Closures, strength and cost, on spoken lines."""
    layout, performer, rate, said = stage.layout, stage.performer, stage.rate, stage.said

    def positions(*emotions: EmotionSpan) -> list[Floats]:
        return [stage.positions(values) for values in stage.values(*emotions)]

    upper, lower = (layout.markers.index(layout.landmarks[number]) for number in (13, 14))
    apart = layout.places[upper, 1] - layout.places[lower, 1]

    def closures(moved: list[Floats]) -> ClosureCounts:
        counts = ClosureCounts(0, 0, 0, 0)
        for line, rows in zip(said, moved, strict=True):
            opening = rows[:, upper, 1] - rows[:, lower, 1] - apart
            counts += closure_counts(opening, rate.times(len(rows)), line.phones)
        return counts

    neutral = positions()
    plain = closures(neutral)
    lines = [
        "",
        "## Speaking with it",
        "",
        f"{len(SENTENCES)} lines with {plain.bilabials} bilabials between phones, 50 frames/s. F1 of closures without "
        f"emotion: {plain.f1:.2f} (recall {plain.recall:.2f}). Strength: mm from the neutral line.",
        "",
        "| emotion | F1 of closures in full | drop | recall | strength at "
        + " | at ".join(f"{i:g}" for i in GRADES)
        + " |",
        "| --- |" + " ---: |" * (3 + len(GRADES)),
    ]
    for emotion in hand_made_expression().names:
        if emotion == "neutral":
            continue
        graded = [positions(EmotionSpan(emotion, intensity)) for intensity in GRADES]
        full = closures(graded[-1])
        strength = [
            float(np.mean([np.linalg.norm(a - b, axis=2).mean() for a, b in zip(rows, neutral, strict=True)]))
            for rows in graded
        ]
        rising = all(after > before for before, after in pairwise(strength))
        cells = [f"{full.f1:.2f}", f"{plain.f1 - full.f1:+.2f}", f"{full.recall:.2f}", *(f"{s:.2f}" for s in strength)]
        lines.append(f"| {emotion} | " + " | ".join(cells) + (" |" if rising else " (not monotone) |"))
    score, seconds = Score((EmotionSpan("happy"),)), sum(line.duration for line in said)
    times = []
    for _ in range(3):
        began = time.perf_counter()
        for line in said:
            performer.expression.perform(score, line.duration, rate, np.random.default_rng(0))
        times.append(time.perf_counter() - began)
    return [*lines, "", f"Cost of an expression: {1000 * min(times) / seconds:.1f} ms per second of animation."]


def sampling() -> list[str]:
    space = hand_made_space()
    shares = space.space_.variances_ / space.space_.variances_.sum() * space.space_.share_
    lines = [
        "",
        "## The space, and ten seconds sampled from it",
        "",
        f"Three components keep {space.space_.share_:.1%} of the variance ("
        + ", ".join(f"{share:.1%}" for share in shares)
        + f"). Means over all emotions and {SEEDS} seeds, 10 s each; "
        "spread, speed and its change as ratios to the source's.",
        "",
        "| patches | joints | no patch fitted | copied on | spread | speed | change of speed |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    tried = {
        "paper: 30 / 5 / 0.03, place alone": PatchSettings(velocity=0.0, fresh=False),
        "default: the same, speed matched, nothing copied on": PatchSettings(),
        "tolerance 0.1": PatchSettings(tolerance=0.1),
        "paper's, from four seconds of source": PatchSettings(velocity=0.0, fresh=False),
        "default, from four seconds of source": PatchSettings(),
    }
    for name, settings in tried.items():
        lines.append(f"| {name} | " + " | ".join(_sampled(space, settings, 480 if "four" in name else None)) + " |")
    return lines


def _sampled(space: ExpressionSpace, settings: PatchSettings, rows: int | None) -> list[str]:
    cut = ExpressionSpace(ExpressionSettings(patches=settings))
    cut.space_ = space.space_
    cut.curves_ = {name: (curves[0][:rows],) for name, curves in space.curves_.items()}
    cut.carried_ = {name: (carried[0][:rows],) for name, carried in space.carried_.items()}
    joints, stretched, copied = 0, 0, 0
    ratios: list[list[float]] = []
    for emotion in cut.emotions:
        source = cut.curves_[emotion][0]
        for seed in range(SEEDS):
            new = cut.sample(emotion, 10.0, np.random.default_rng(seed))
            joints += new.patches.joints
            stretched += new.patches.stretched
            copied += new.patches.copied
            ratios.append(
                [
                    _size(np.diff(new.curve, order, axis=0)) / _size(np.diff(source, order, axis=0))
                    for order in (0, 1, 2)
                ]
            )
    means = np.mean(ratios, axis=0)
    return [str(joints), f"{stretched / joints:.1%}", f"{copied / joints:.1%}", *(f"{mean:.2f}" for mean in means)]


def _size(rows: Floats) -> float:
    return float(np.sqrt(((rows - rows.mean(axis=0)) ** 2).sum(axis=1).mean()))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("docs/tables/expressions.md"))
    given = parser.parse_args()
    head = [
        "# The hand-made expressions",
        "",
        "Written by `python benchmarks/expressions.py`; definitions stand at its head.",
        "",
    ]
    stage = Stage()
    with replace_when_complete(given.out) as unfinished:
        unfinished.write_text("\n".join([*head, *faces(stage), *spoken(stage), *sampling()]) + "\n", encoding="utf-8")
    print(given.out.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
