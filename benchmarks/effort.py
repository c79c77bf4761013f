"""How far two takes of one sentence, neutral and strongly angry, open the jaw: with the voice's effort and without.

    python benchmarks/effort.py             writes docs/tables/effort.md
    python benchmarks/effort.py --actors 3

Needs ravdess-half (MIEN_DATA, or ../shared/data beside the clone): to measure with, nothing is learned from it.
"""

from __future__ import annotations

import argparse
import os
from collections import defaultdict
from pathlib import Path

import numpy as np
from scipy.signal import butter, sosfilt

from mien.core.audio import Audio
from mien.core.timeline import FrameRate
from mien.core.utterance import PAUSE
from mien.formats.sound_files import read_audio
from mien.motion.effort import DECIBELS
from mien.motion.performer import Performer
from mien.motion.performers import load_performer
from mien.pipeline.inputs import spoken_recording
from mien.pipeline.options import with_heard_effort
from mien.pipeline.perform import perform
from mien.speech.pitch import level_contour
from mien.speech.vocal_effort import read_effort
from mien.text.score import Score

ROOT = Path(__file__).parent.parent
DATA = Path(os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data")) / "ravdess-half"
SENTENCE = "Kids are talking by the door."
RATE = FrameRate.of(30)
NEUTRAL, ANGRY = "01-01", "05-02"


def measured(path: Path, performer: Performer) -> tuple[float, float, float, float]:
    """Level of the voice in dBFS, its effort, and the mean jawOpen in speech without effort and with."""
    spoken = spoken_recording(path, performer, text=SENTENCE)
    speech = spoken.utterance
    heard, _ = with_heard_effort(Score(), spoken)
    times = RATE.times(RATE.frames_covering(speech.duration))
    said = [(phone.start, phone.end) for phone in speech.phones if phone.label != PAUSE]
    inside = np.any([(times >= start) & (times < end) for start, end in said], axis=0)
    jaws = [
        perform(speech, score, performer, RATE).channels.channel("jawOpen")[: len(times)][inside].mean()
        for score in (Score(), heard)
    ]
    level = float(np.percentile(level_contour(speech.audio).decibels, 95))
    return level, 1 + read_effort(speech.audio, DECIBELS).decibels / DECIBELS, float(jaws[0]), float(jaws[1])


def coloured(sound: Audio) -> dict[str, Audio]:
    """A recording as other microphones and rooms would have it."""
    x, rate = sound.samples.astype(np.float64), sound.rate
    noise = np.random.default_rng(0).normal(size=len(x)) * np.sqrt((x[np.abs(x) > 0.04 * np.abs(x).max()] ** 2).mean())
    band = sosfilt(butter(4, [300, 3400], "bandpass", fs=rate, output="sos"), x)
    dull = sosfilt(butter(1, 1500, "lowpass", fs=rate, output="sos"), x)
    bright = x + sosfilt(butter(1, 1000, "highpass", fs=rate, output="sos"), x)
    made = {
        "as it is": x,
        "26 dB quieter": 0.05 * x,
        "telephone band": band,
        "dull (low-pass 1.5 kHz, 6 dB an octave)": dull,
        "bright (+6 dB above 1 kHz)": bright,
        "white noise at 20 dB": x + 0.1 * noise,
        "white noise at 10 dB": x + 0.316 * noise,
    }
    return {name: Audio(y.astype(np.float32), rate) for name, y in made.items()}


def under_colours(actors: int) -> str:
    """Rows: mean and extremes of the effort over the actors."""
    read = defaultdict[tuple[str, str], list[float]](list)
    for kind in (NEUTRAL, ANGRY):
        for actor in range(1, actors + 1):
            sound = read_audio(DATA / f"03-01-{kind}-01-01-{actor:02d}.flac")[0]
            for name, other in coloured(sound).items():
                read[name, kind].append(1 + read_effort(other, DECIBELS).decibels / DECIBELS)
    rows = []
    for name in dict.fromkeys(name for name, _ in read):
        cells = [f"{np.median(f):.2f} ({min(f):.2f} to {max(f):.2f})" for f in (read[name, NEUTRAL], read[name, ANGRY])]
        rows.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(rows)


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--actors", type=int, default=12)
    performer = load_performer("default")
    lines, ratios = [], []
    actors = parser.parse_args().actors
    for actor in range(1, actors + 1):
        calm, angry = (measured(DATA / f"03-01-{kind}-01-01-{actor:02d}.flac", performer) for kind in (NEUTRAL, ANGRY))
        plain, shown = angry[2] / calm[2], angry[3] / calm[3]
        ratios.append((plain, shown))
        read = f"{angry[0] - calm[0]:.0f} | {calm[1]:.2f} | {angry[1]:.2f}"
        lines.append(f"| {actor:02d} | {read} | {calm[3]:.3f} | {angry[3]:.3f} | {plain:.2f} | {shown:.2f} |")
        print(lines[-1], flush=True)
    plain, with_effort = np.median(ratios, axis=0)
    enough = sum(ratio >= 1.5 for _, ratio in ratios)
    (ROOT / "docs" / "tables" / "effort.md").write_text(
        "# Effort heard in a voice\n\n"
        "Written by `python benchmarks/effort.py`. Actors of ravdess-half (even numbers: women) say one sentence,\n"
        "neutral and in strong anger; the default performer speaks it, `jawOpen` is its mean over the speech. The\n"
        "levels differ as shown; the reader of effort does not see them.\n\n"
        "| actor | levels differ, dB | effort neutral | angry | jawOpen neutral | angry | ratio, off | ratio |\n"
        "| --- | --- | --- | --- | --- | --- | --- | --- |\n"
        + "\n".join(lines)
        + f"\n\nMedian ratio {plain:.2f} without effort, {with_effort:.2f} with it; at least 1.5 in {enough} of "
        f"{len(ratios)}.\n\nThe same recordings in other colours, at other levels and in noise: effort, median (least\n"
        "to most).\n\n"
        "| | neutral | angry |\n| --- | --- | --- |\n" + under_colours(actors) + "\n",
        encoding="utf-8",
    )


if __name__ == "__main__":
    main()
