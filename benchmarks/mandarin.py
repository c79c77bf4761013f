"""How near the performer `mandarin` comes to recordings of its own speaker that it has not seen, beside the others.

    python benchmarks/mandarin.py CACHE        writes docs/tables/mandarin.md

Needs facegood-mandarin (MIEN_DATA, or ../shared/data beside the clone). CACHE is the folder of tools/learn_mandarin.py.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tools")]

from learn_mandarin import LAYOUT, RATE, heard_right, takes_of  # noqa: E402

from mien.capture.layouts import load_layout  # noqa: E402
from mien.core import channels  # noqa: E402
from mien.core.timeline import Tier  # noqa: E402
from mien.core.utterance import PAUSE, Utterance  # noqa: E402
from mien.corpus.take import Take  # noqa: E402
from mien.face.library import load_face  # noqa: E402
from mien.face.marker_sites import place_markers  # noqa: E402
from mien.face.retargeting import basis_at  # noqa: E402
from mien.motion.learning import LearningSettings, learn  # noqa: E402
from mien.motion.mouth.hand_made_mouth import HandMadeMouth  # noqa: E402
from mien.motion.mouth.learned_mouth import LearnedMouth  # noqa: E402
from mien.motion.performer import MouthModel  # noqa: E402
from mien.motion.performers import load_performer  # noqa: E402

DATA = Path(os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data")) / "facegood-mandarin"
HELD_OUT = ("1114_2_05", "1114_3_16")
AROUND = 0.07  # seconds about a phone that count as speech
Floats = NDArray[np.float64]


class OnFace:
    """Landmarks of the mouth on the default face under channels."""

    def __init__(self) -> None:
        layout, face = load_layout(LAYOUT), load_face("default")
        placed = place_markers(face, layout, layout.markers)
        self.rest, self.basis = placed.places, basis_at(face, placed.sites, channels.WEIGHTS)
        where = {number: layout.markers.index(name) for number, name in layout.landmarks.items()}
        self.upper, self.lower, self.right, self.left = (where[number] for number in (13, 14, 61, 291))
        self.mouth = [layout.markers.index(name) for name in layout.groups["mouth"]]

    def places(self, weights: Floats) -> Floats:
        """Landmarks, shape (frames, landmarks, 3), mm."""
        return np.asarray(self.rest + np.einsum("fc,cmd->fmd", weights[:, : len(channels.WEIGHTS)], self.basis))

    def opening(self, places: Floats) -> Floats:
        """Of the lips, mm."""
        return np.asarray(places[:, self.upper, 1] - places[:, self.lower, 1])

    def width(self, places: Floats) -> Floats:
        """Of the lips, mm."""
        return np.asarray(np.abs(places[:, self.left, 0] - places[:, self.right, 0]))


def row(name: str, mouth: MouthModel, takes: list[Take], face: OnFace) -> str:
    """How a mouth does on takes, in speech, over all their frames together."""
    shown, recorded = [], []
    for take in takes:
        assert take.channels is not None
        speech = Utterance("", take.audio, Tier("words", ()), take.phones, "en-US", "recognised")
        made = mouth.perform(speech, RATE).values[: len(take.channels)]
        times = RATE.times(len(made))
        spoken = [(p.start - AROUND, p.end + AROUND) for p in take.phones if p.label != PAUSE]
        inside = np.any([(times >= start) & (times < end) for start, end in spoken], axis=0)
        shown.append(face.places(made[inside]))
        recorded.append(face.places(take.channels.values[: len(made)][inside]))
    one, truth = np.concatenate(shown), np.concatenate(recorded)
    away = (one - truth)[:, face.mouth]
    away -= away.mean(axis=0)
    cells = []
    for measure in (face.opening, face.width):
        made, wanted = measure(one), measure(truth)
        cells += [f"{np.corrcoef(made, wanted)[0, 1]:.2f}", f"{made.std() / wanted.std():.2f}"]
    return f"| {name} | {' | '.join(cells)} | {np.sqrt((away**2).sum(axis=-1).mean()):.2f} |"


def main() -> None:
    """Learn from five recordings, measure on two."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cache", type=Path, help="the folder of tools/learn_mandarin.py")
    cache, face = parser.parse_args().cache, OnFace()
    names = sorted(path.stem for path in (DATA / "audio").glob("*.flac"))
    seen = [heard_right(take) for name in names if name not in HELD_OUT for take in takes_of(DATA, cache, name)]
    takes = [take for name in HELD_OUT for take in takes_of(DATA, cache, name)]
    learned = learn(seen, LearningSettings(speech_model="coarticulation"), name="mandarin")
    rows = [
        row("mandarin, learned from the other five", LearnedMouth(learned), takes, face),
        row("default (GRID speaker 1)", load_performer("default").mouth, takes, face),
        row("hand-made mouth", HandMadeMouth(), takes, face),
    ]
    print("\n".join(rows))
    (ROOT / "docs" / "tables" / "mandarin.md").write_text(
        "# The performer mandarin on recordings that it has not seen\n\n"
        f"Written by `python benchmarks/mandarin.py CACHE`. Two of the seven recordings ({', '.join(HELD_OUT)}),\n"
        f"{len(takes)} utterances, performed from the phones that the recogniser hears; both on the default face.\n"
        "Spread: 1 as recorded. RMS over the mouth's landmarks, constant offsets removed.\n\n"
        "| | opening r | spread | width r | spread | RMS, mm |\n| --- | --- | --- | --- | --- | --- |\n"
        + "\n".join(rows)
        + "\n",
        encoding="utf-8",
    )


if __name__ == "__main__":
    main()
