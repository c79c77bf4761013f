"""What each step of cleaning does to real motion (grid-s1) and to damage planted in it.

    python benchmarks/cleaning.py            writes docs/tables/cleaning.md
    python benchmarks/cleaning.py --every 9  takes every ninth recording only

Needs the shared recordings (MIEN_DATA, or ../shared/data beside the clone).
"""

from __future__ import annotations

import argparse
import os
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from tests.capture.cleaning.grid import LIPS, MOUTH, Grid  # noqa: E402

from mien.capture.cleaning.gaps import GapSettings, fill_gaps  # noqa: E402
from mien.capture.cleaning.lag import Lag, lag_from_sound  # noqa: E402
from mien.capture.cleaning.resample import resample  # noqa: E402
from mien.capture.cleaning.spikes import remove_spikes  # noqa: E402
from mien.capture.cleaning.swaps import mend_swaps  # noqa: E402
from mien.capture.cleaning.tracker_jitter import JitterSettings, jitter, low_passed, smooth_group  # noqa: E402
from mien.core.timeline import FrameRate  # noqa: E402
from mien.core.tracks import MarkerTrack  # noqa: E402

Floats = NDArray[np.float64]
CLOSED_MM = 0.75
IRISES = {str(n) for n in range(468, 478)}
# A set as sparse as one glued on by hand: 32 of the landmarks.
SPARSE = (
    "33",
    "133",
    "362",
    "263",
    "168",
    "6",
    "1",
    "4",
    "151",
    "9",
    "70",
    "105",
    "107",
    "336",
    "334",
    "300",
    "50",
    "280",
    "205",
    "425",
    "61",
    "291",
    "0",
    "17",
    "13",
    "14",
    "37",
    "267",
    "84",
    "314",
    "152",
    "199",
)


def closures(track: MarkerTrack, words: list[tuple[float, float, str]]) -> list[float]:
    """Smallest opening of the lips at each bilabial with speech on both sides, mm."""
    one, other = (track.positions[:, track.names.index(name)] for name in LIPS)
    opening = np.linalg.norm(one - other, axis=1)
    fps, found = track.rate.fps, []
    for number, (start, end, word) in enumerate(words):
        spans = [(start - 0.06, start + 0.08)] if number > 1 and word in ("blue", "by", "b", "p") else []
        spans += [(end - 0.12, end + 0.04)] if word == "m" and number < len(words) - 1 else []
        found += [float(opening[round(a * fps) : round(b * fps) + 1].min()) for a, b in spans]
    return found


def filters() -> dict[str, Callable[[MarkerTrack], MarkerTrack]]:
    """Ways to take out jitter, by name."""

    def every(smooth: Callable[[Floats], Floats]) -> Callable[[MarkerTrack], MarkerTrack]:
        return lambda track: MarkerTrack(track.names, smooth(np.array(track.positions)), track.rate)

    ways = {"none": every(lambda p: p)}
    for hz in (6.0, 8.0, 10.0):
        ways[f"Butterworth {hz:g} Hz on every marker"] = every(lambda p, hz=hz: low_passed(p, FrameRate.of(25), hz))
    for window, order in ((5, 2), (7, 4)):
        name = f"Savitzky-Golay, {window} frames, order {order}"
        ways[name] = every(lambda p, w=window, o=order: savgol_filter(p, w, o, axis=0))
    for hz in (4.0, 6.0, 8.0):
        block = JitterSettings(translation_hz=hz, window=0.0)
        ways[f"block translation {hz:g} Hz"] = lambda track, s=block: smooth_group(track, MOUTH, s)
    for still, moving in ((8.0, 20.0), (15.0, 30.0), (25.0, 60.0)):
        mixed = JitterSettings(still=still, moving=moving)
        default = " (default)" if mixed == JitterSettings() else ""
        name = f"block 6 Hz, shape at rest below {still:g} to {moving:g} mm/s{default}"
        ways[name] = lambda track, s=mixed: smooth_group(track, MOUTH, s)
    return ways


def jitter_rows(grid: Grid, tracks: dict[str, MarkerTrack]) -> list[str]:
    """One line per filter."""
    rows = []
    for name, smooth in filters().items():
        depths, calm, opening_change = [], [], []
        for take, track in tracks.items():
            words, after = grid.words(take), smooth(track)
            depths += closures(after, words)
            mouth = [track.names.index(marker) for marker in MOUTH]
            pause = slice(0, round(words[0][1] * track.rate.fps) - 4)
            if pause.stop >= 8:
                calm.append(jitter(after.positions[pause][:, mouth]) ** 2)
            opening_change.append(np.mean((closure_curve(after) - closure_curve(track)) ** 2))
        depth = np.array(depths)
        rows.append(
            f"| {name} | {np.sqrt(np.mean(calm)):.3f} | {np.median(depth):.2f} | {np.quantile(depth, 0.9):.2f} | "
            f"{np.mean(depth < CLOSED_MM):.1%} | {np.sqrt(np.mean(opening_change)):.2f} |"
        )
    head = (
        f"| filter | jitter, mm | median depth, mm | 90 % depth, mm | closed ({len(depth)}) | change of opening, mm |"
    )
    return [head, *rows]


def closure_curve(track: MarkerTrack) -> Floats:
    """Opening of the lips over time, mm."""
    one, other = (track.positions[:, track.names.index(name)] for name in LIPS)
    return np.asarray(np.linalg.norm(one - other, axis=1))


def gap_rows(tracks: dict[str, MarkerTrack]) -> list[str]:
    """Error of filling gaps planted in speech, by length, for two ways and two marker sets."""
    rows = ["| gap, frames at 25/s | spline, 218 markers | PCA, 218 markers | spline, 32 markers | PCA, 32 markers |"]
    hidden = ("13", "14", "61", "17", "152", "105")
    for length in (1, 2, 3, 5, 10, 20):
        cells = []
        for names in (None, SPARSE):
            for settings in (GapSettings(short=99.0), GapSettings(short=0.0)):
                squares: list[float] = []
                for track in list(tracks.values())[::20]:
                    columns = [track.names.index(n) for n in names or track.names]
                    truth = MarkerTrack([track.names[c] for c in columns], track.positions[:, columns], track.rate)
                    for marker in (truth.names.index(n) for n in hidden):
                        holed = truth.positions.copy()
                        holed[32 : 32 + length, marker] = np.nan
                        filled, _ = fill_gaps(MarkerTrack(truth.names, holed, truth.rate), settings)
                        off = (filled.positions - truth.positions)[32 : 32 + length, marker]
                        squares += list((off**2).sum(axis=1))
                cells.append(f"{np.sqrt(np.mean(squares)):.2f}")
        rows.append(f"| {length} | {' | '.join(cells)} |")
    return rows


def damage_rows(tracks: dict[str, MarkerTrack]) -> list[str]:
    """Spikes and swaps found in the recordings as they are, and of those planted."""
    random = np.random.default_rng(0)
    false: Counter[str] = Counter()
    found: Counter[str] = Counter()
    for track in tracks.values():
        _, spikes = remove_spikes(track)
        false["spike, irises"] += sum(r.markers[0] in IRISES for r in spikes)
        false["spike, elsewhere"] += sum(r.markers[0] not in IRISES for r in spikes)
        false["swap"] += len(mend_swaps(track)[1])
        marker, frame = track.names.index(MOUTH[random.integers(len(MOUTH))]), int(random.integers(5, 65))
        length, height = int(random.integers(1, 4)), float(random.uniform(5, 15))
        direction = random.normal(size=3)
        broken = track.positions.copy()
        broken[frame : frame + length, marker] += height * direction / np.linalg.norm(direction)
        _, spikes = remove_spikes(MarkerTrack(track.names, broken, track.rate))
        own = [r for r in spikes if r.markers == (track.names[marker],)]
        found["spike"] += any(r.first <= frame and r.last >= frame + length - 1 for r in own)
        found["extra"] += sum(r.markers[0] not in IRISES for r in spikes if r not in own)
        one, other = (track.names.index(n) for n in random.choice([n for n in SPARSE if n != "13"], 2, replace=False))
        broken = track.positions.copy()
        broken[frame : frame + 9, [one, other]] = broken[frame : frame + 9, [other, one]]
        found["swap"] += mend_swaps(MarkerTrack(track.names, broken, track.rate))[0] == track
    count, places = len(tracks), sum(t.positions.shape[0] * t.positions.shape[1] for t in tracks.values())
    return [
        "| what | figure |",
        "| --- | --- |",
        f"| spikes seen in {count} takes ({places:,} marker places), irises left out | {false['spike, elsewhere']} |",
        f"| the same at the irises, whose edge the tracker loses in a blink | {false['spike, irises']} |",
        f"| swaps seen in the takes as recorded | {false['swap']} |",
        f"| spikes of 5 to 15 mm planted at the mouth for 1 to 3 frames, found whole | {found['spike']} of {count} |",
        f"| wrong repairs beside them | {found['extra']} |",
        f"| swaps planted for 9 frames and undone to the bit | {found['swap']} of {count} |",
    ]


def resampling_rows(tracks: dict[str, MarkerTrack]) -> list[str]:
    """Error of going to another rate and back, mm RMS over the mouth."""
    rows = ["| there and back | error, mm |", "| --- | --- |"]
    for fps in (30, 50, 60, 120):
        squares = []
        for track in list(tracks.values())[::10]:
            mouth = [track.names.index(n) for n in MOUTH]
            back = resample(resample(track, FrameRate.of(fps)), track.rate)
            squares.append(((back.positions[: len(track)] - track.positions)[:, mouth] ** 2).sum(axis=2).mean())
        rows.append(f"| 25 to {fps} to 25 | {np.sqrt(np.mean(squares)):.3f} |")
    return rows


def lag_line(lag: Lag, takes: int) -> str:
    return (
        f"Motion behind sound, from the loudness ({takes} takes): {lag.seconds * 1000:+.1f} ms, standard error "
        f"{lag.error * 1000:.1f} ms, correlation {lag.fit:.2f}, confidence {lag.confidence:.2f}."
    )


def report(grid: Grid, every: int) -> str:
    tracks = {name: grid.normalised(name) for name in grid.names[::every]}
    tracks = {name: track for name, track in tracks.items() if np.isfinite(track.positions).all()}
    jitters = jitter_rows(grid, tracks)
    gaps = gap_rows(tracks)
    lag = lag_from_sound(list(tracks.values()), [grid.audio(name) for name in tracks], LIPS)
    return "\n".join(
        [
            "# Cleaning of recorded motion",
            "",
            f"Written by `python benchmarks/cleaning.py` on grid-s1: {len(tracks)} takes without lost frames (--every",
            f"{every}), normalised by the similarity fit of the data's README. 25 frames a second.",
            "",
            "## Jitter and closures",
            "",
            "Jitter: root mean square of the second difference of the mouth's 48 markers before the first word. Depth:",
            "the smallest lip opening at a bilabial with speech on both sides; closed: below",
            f"{CLOSED_MM} mm. A good filter lowers the first column and leaves the others as they are without it.",
            "",
            jitters[0],
            "| --- | --- | --- | --- | --- | --- |",
            *jitters[1:],
            "",
            "## Gaps",
            "",
            "Error of filling, mm RMS, in gaps planted in speech at two lip middles, a corner, the lower lip's edge,",
            "the chin and a brow, one at a time. The tracker lays a mesh on the face, so its landmarks tell more of",
            "each other than glued markers would; at 120 frames a second three frames span less than one does here.",
            "",
            gaps[0],
            "| --- | --- | --- | --- | --- |",
            *gaps[1:],
            "",
            "## Spikes and swaps",
            "",
            *damage_rows(tracks),
            "",
            "## Other frame rates",
            "",
            *resampling_rows(tracks),
            "",
            "## Lag",
            "",
            lag_line(lag, len(tracks)),
            "",
        ]
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--every", type=int, default=3)
    parser.add_argument("--print-only", action="store_true")
    chosen = parser.parse_args()
    data = Path(os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data"))
    text = report(Grid(data), chosen.every)
    print(text)
    if not chosen.print_only:
        (ROOT / "docs" / "tables" / "cleaning.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
