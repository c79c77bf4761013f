"""Head motion from prosody: as learned from a corpus's head poses, beside the hand-made rule, on takes held out.

    python benchmarks/head_motion.py CORPUS [--takes 450]

writes ``docs/tables/head_motion.md``. *Learned* is `mien.motion.alive.head_motion`, its ridge chosen on takes of its
own;
*performed* is the same as large as a line gets it. *Rule* is `mien.motion.alive.visual_prosody` at full strength,
*sway*
the drift of `mien.motion.alive.idle`.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.core.channels import ALL, HEAD
from mien.core.files import replace_when_complete
from mien.core.utterance import Utterance
from mien.corpus.recordings import Corpus
from mien.corpus.take import Take
from mien.motion.alive.head_motion import GAIN, RATE, LearnedHead
from mien.motion.alive.idle import HEAD_SWAY, HEAD_TIME
from mien.motion.alive.visual_prosody import HandMadeProsody
from mien.motion.drift import smooth_drift
from mien.speech.stressed_vowels import stressed_words

TABLE = Path(__file__).parent.parent / "docs" / "tables" / "head_motion.md"
RIDGES = (1e1, 1e2, 1e3, 1e4, 1e5)
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Said:
    """One take: features (frames, columns); recorded angles, those of the rule and of the sway, (frames, 3) degrees."""

    features: Floats
    angles: Floats
    rule: Floats
    sway: Floats


def said_in(take: Take, number: int) -> Said | None:
    found = LearnedHead().speaking(take)
    if found is None:
        return None
    features, angles = found
    rate = take.markers.rate
    times = rate.times(len(take.markers))
    utterance = Utterance(take.text, take.audio, take.words, take.phones, "en-US", "aligned", ())
    random = np.random.default_rng(number)
    ruled = HandMadeProsody(1.0).perform(utterance, stressed_words(utterance), rate, random)[
        :, [ALL.index(name) for name in HEAD]
    ]
    ruled = np.vstack([ruled, np.zeros((max(0, len(times) - len(ruled)), 3))])[: len(times)]
    sway = np.stack([HEAD_SWAY[name] * smooth_drift(times, HEAD_TIME, random) for name in HEAD], axis=1)
    inside = (times >= take.words.intervals[0].start - 0.1) & (times <= take.words.intervals[-1].end + 0.1)

    def about_mean(curve: Floats) -> Floats:
        return np.asarray(curve[inside] - curve[inside].mean(axis=0))

    return Said(features, angles, about_mean(ruled), about_mean(sway))


def learned_from(said: list[Said], ridge: float) -> LearnedHead:
    rows, angles = np.concatenate([s.features for s in said]), np.concatenate([s.angles for s in said])
    return LearnedHead(ridge).fit_frames(rows, angles)


def predicted(head: LearnedHead, one: Said) -> Floats:
    found = head.predict(one.features)
    return np.asarray(found - found.mean(axis=0))


def explained(said: list[Said], curves: list[Floats]) -> Floats:
    """Share of the recorded variance, per angle."""
    left = sum(((s.angles - c) ** 2).sum(axis=0) for s, c in zip(said, curves, strict=True))
    return np.asarray(1 - left / sum((s.angles**2).sum(axis=0) for s in said))


def row_of(name: str, said: list[Said], curves: list[Floats]) -> str:
    recorded, made = np.concatenate([s.angles for s in said]), np.concatenate(curves)
    share = explained(said, curves)
    together = [np.corrcoef(recorded[:, k], made[:, k])[0, 1] if made[:, k].std() > 1e-9 else 0.0 for k in range(3)]
    speed = np.mean([np.linalg.norm(np.diff(c, axis=0), axis=1).mean() * RATE for c in curves])
    cells = [name, *(f"{100 * v:.1f}" for v in share), *(f"{r:.2f}" for r in together)]
    cells += [*(f"{s:.2f}" for s in made.std(axis=0)), f"{speed:.1f}"]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("corpus", help="a corpus with head poses, made by 'mien corpus import'")
    parser.add_argument("--takes", type=int, default=450, help="how many takes to use (default 450)")
    given = parser.parse_args()
    takes = list(Corpus(given.corpus))
    takes = takes[:: max(1, len(takes) // given.takes)]
    said = [one for number, take in enumerate(takes) if (one := said_in(take, number)) is not None]
    tested, chosen_on, kept = said[::5], said[1::5], [s for k, s in enumerate(said) if k % 5 > 1]

    def fault(strength: float) -> float:
        head = learned_from(kept, strength)
        return -float(explained(chosen_on, [predicted(head, s) for s in chosen_on]).mean())

    strength = min(RIDGES, key=fault)
    model = learned_from([*kept, *chosen_on], strength)
    learned = [predicted(model, s) for s in tested]
    head = ["head motion", *(f"{a}, % explained" for a in ("yaw", "pitch", "roll"))]
    head += [
        *(f"{a}, correlation" for a in ("yaw", "pitch", "roll")),
        *(f"{a}, sd °" for a in ("yaw", "pitch", "roll")),
    ]
    head.append("speed, °/s")
    lines = [
        "# Head motion",
        "",
        "Written by `python benchmarks/head_motion.py CORPUS`. Head angles of one speaker in three-second commands,",
        f"about their mean in each take; {len(said) - len(tested)} takes learned from, {len(tested)} held out, "
        f"ridge {strength:g}.",
        "Explained below 0: farther from the recording than a head that holds still.",
        "",
        f"| {' | '.join(head)} |",
        "|" + " --- |" * len(head),
        row_of("recorded", tested, [s.angles for s in tested]),
        row_of("still", tested, [np.zeros_like(s.angles) for s in tested]),
        row_of("learned", tested, learned),
        row_of("learned, as performed", tested, [GAIN * curve for curve in learned]),
        row_of("rule", tested, [s.rule for s in tested]),
        row_of("sway", tested, [s.sway for s in tested]),
    ]
    with replace_when_complete(TABLE) as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
