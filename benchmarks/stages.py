"""How long each stage of ``mien animate`` takes, and how that grows with the length of the recording.

    python benchmarks/stages.py            writes docs/tables/speed.md
    python benchmarks/stages.py --seconds 15 --print-only

The recording is made by the default voice, so that anyone can run this. Read ratios, not absolutes: every figure is
processing time over sound length (real-time factor), all taken in one run on one machine.
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from mien.animation.animation import Animation
from mien.core import channels
from mien.core.audio import Audio
from mien.core.timeline import FrameRate
from mien.face.library import load_face
from mien.face.posing import Poser
from mien.face.render.renderer import Renderer
from mien.formats.video import write_frames, write_video
from mien.motion.performer import Performer
from mien.motion.performers import load_performer
from mien.pipeline.perform import perform
from mien.speech.align import align
from mien.speech.synthesis import synthesise
from mien.text.score import EmotionSpan, Score

PASSAGE = (
    "The rainbow is a division of white light into many beautiful colours. These take the shape of a long round arch, "
    "with its path high above, and its two ends apparently beyond the horizon. People look, but no one ever finds the "
    "pot of gold. When a man looks for something beyond his reach, his friends say he is looking for the pot of gold "
    "at the end of the rainbow. Throughout the centuries people have explained the rainbow in various ways. Some have "
    "accepted it as a miracle without physical explanation. Others have tried to explain it as a thing of nature. "
    "Many believed that it was a bridge from this world to the next, or a sign of good weather to come. "
)
ROOT = Path(__file__).parent.parent
RATE = FrameRate.of(30)
SCORE = Score((EmotionSpan("happy", 0.5),))


def recording(sentences: int) -> tuple[Audio, str]:
    """The first sentences of the passage, as often as needed, spoken by the default voice."""
    parts = [part.strip() + "." for part in (PASSAGE * 3).split(".") if part.strip()][:sentences]
    text = " ".join(parts)
    return synthesise(text).audio, text


def stages(audio: Audio, text: str, performer: Performer) -> dict[str, float]:
    """Seconds per stage."""
    spent: dict[str, float] = {}
    clock = time.perf_counter()

    def lap(stage: str) -> None:
        nonlocal clock
        now = time.perf_counter()
        spent[stage], clock = now - clock, now

    utterance = align(audio, text)
    lap("align")
    animation = perform(utterance, SCORE, performer, RATE)
    lap("motion")
    face = load_face("default")
    poser, renderer = Poser(face, channels.ALL), Renderer(face)
    lap("load face")
    posed = [poser.pose(row) for row in animation.channels.values[:90]]
    lap("pose")
    spent["pose"] *= len(animation.channels) / 90
    pictures = [renderer.render(picture) for picture in posed]
    lap("render")
    with tempfile.TemporaryDirectory() as folder:
        sound = Audio(audio.samples[: 3 * audio.rate], audio.rate)
        write_frames(iter(pictures), RATE.fraction, sound, Path(folder) / "line.mp4", (1280, 720))
    lap("encode")
    for stage in ("render", "encode"):
        spent[stage] *= len(animation.channels) / 90
    with tempfile.TemporaryDirectory() as folder:
        write_video(animation, face, Path(folder) / "line.mp4")
    lap("pose + render + encode, in parallel")
    return spent


def warm_up(performer: Performer) -> None:
    """Compile what is compiled on first use, so that it does not count."""
    animation: Animation = perform(synthesise("Papa."), SCORE, performer, RATE)
    with tempfile.TemporaryDirectory() as folder:
        write_video(animation, load_face("default"), Path(folder) / "line.mp4")


def start_up() -> float:
    """Median seconds of ``mien --help`` as a whole process."""
    runs = []
    for _ in range(7):
        clock = time.perf_counter()
        subprocess.run([sys.executable, "-m", "mien", "--help"], check=True, capture_output=True)
        runs.append(time.perf_counter() - clock)
    return float(np.median(runs))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sentences", type=int, nargs="+", default=[3, 6, 13], help="lengths to try")
    parser.add_argument("--print-only", action="store_true")
    options = parser.parse_args()
    performer = load_performer()
    warm_up(performer)
    columns = []
    for sentences in options.sentences:
        audio, text = recording(sentences)
        columns.append((audio.duration, stages(audio, text, performer)))
    head = "| stage | " + " | ".join(f"{duration:.0f} s of speech" for duration, _ in columns) + " |"
    lines = [
        "# Speed of `mien animate`",
        "",
        "Written by `python benchmarks/stages.py`. Processing time over sound length (real time is 1).",
        f"1280x720, 30 frames/s, {os.cpu_count()} shared cores, {platform.machine()}.",
        "",
        head,
        "| --- |" + " --- |" * len(columns),
    ]
    for stage in columns[0][1]:
        lines.append(f"| {stage} | " + " | ".join(f"{spent[stage] / d:.3f}" for d, spent in columns) + " |")
    lines += ["", f"`mien --help` as a whole process, median of 7: {start_up():.2f} s.", ""]
    table = "\n".join(lines)
    print(table)
    if not options.print_only:
        (ROOT / "docs" / "tables").mkdir(parents=True, exist_ok=True)
        (ROOT / "docs" / "tables" / "speed.md").write_text(table, encoding="utf-8")


if __name__ == "__main__":
    main()
