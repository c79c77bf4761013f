"""Recordings made up for tests: a face that talks a little and turns its head, in the formats that readers know."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.capture.layouts import load_layout
from mien.core.audio import Audio
from mien.core.timeline import FrameRate, Interval, Tier, timecode
from mien.face.posing import head_rotation
from mien.formats.textgrid import write_textgrid

LAYOUT = load_layout("mpeg4-32")
RATE = FrameRate.of(60)
SECONDS = 2.0
PHONES = (("SIL", 0.5), ("B", 0.1), ("IH", 0.2), ("N", 0.2), ("M", 0.2), ("AA", 0.3), ("SIL", 0.5))
_MARKED = 61.25
Floats = NDArray[np.float64]


def opening() -> Floats:
    """Lip opening over time, mm: closed, two words, closed."""
    time = RATE.times(round(SECONDS * RATE.fps))
    return np.asarray(np.where((time > 0.5) & (time < 1.5), 8.0 * np.sin((time - 0.5) * 2 * np.pi) ** 2, 0.0))


def still() -> Floats:
    """Markers in the head, mm, shape (frames, 32, 3): the lower lip and chin go down with the opening."""
    positions = np.tile(LAYOUT.places, (len(opening()), 1, 1))
    lower = LAYOUT.index(["8.2", "8.7", "8.8", "2.10", "2.1"])
    positions[:, lower, 1] -= opening()[:, None]
    wave = np.sin(np.arange(len(positions)) / 9.0)[:, None]
    positions[:, LAYOUT.index(["4.3", "4.4"]), 1] += 2.0 * wave
    return positions


def moving(seed: int = 0) -> Floats:
    """The same with a turning, shifting head, mm."""
    random = np.random.default_rng(seed)
    phase, shift = random.uniform(0, 6, 3), random.normal(0, 40, 3)
    frames = still()
    for number, frame in enumerate(frames):
        yaw, pitch, roll = 8.0 * np.sin(number / 40.0 + phase)
        frames[number] = frame @ head_rotation(yaw, pitch, roll).T + shift + [number * 0.05, 0, 0]
    return frames


def sound(seconds: float = SECONDS) -> Audio:
    time = np.arange(round(seconds * 16_000)) / 16_000
    return Audio(0.3 * np.sin(2 * np.pi * 180 * time) * ((time > 0.5) & (time < 1.5)), 16_000)


def write_speech(folder: Path, name: str, seconds: float = SECONDS) -> None:
    """Sound, and a TextGrid with words and phones, so that nothing has to be aligned."""
    folder.mkdir(parents=True, exist_ok=True)
    sound(seconds).write(folder / f"{name}.wav")
    now, intervals = 0.0, []
    for label, length in PHONES:
        intervals.append(
            Interval(now, now + length, label.lower() if label == "SIL" else label + ("1" * (label in ("IH", "AA"))))
        )
        now += length
    words = Tier("words", (Interval(0.5, 1.0, "bin"), Interval(1.0, 1.5, "ma")))
    write_textgrid((words, Tier("phones", tuple(intervals))), SECONDS, folder / f"{name}.TextGrid")


def write_csv(folder: Path, name: str, positions: Floats | None = None, times: Floats | None = None) -> Path:
    positions = moving() if positions is None else positions
    times = RATE.times(len(positions)) if times is None else times
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.csv"
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["time", *(f"{marker}_{axis}" for marker in LAYOUT.markers for axis in "xyz")])
        for time, frame in zip(times, positions, strict=True):
            writer.writerow([f"{time:.6f}", *("" if np.isnan(v) else f"{v:.6f}" for v in frame.ravel())])
    return path


def write_npz(folder: Path, name: str, positions: Floats | None = None, fps: float = RATE.fps) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.npz"
    np.savez(path, markers=moving() if positions is None else positions, names=np.array(LAYOUT.markers), fps=fps)
    return path


def write_c3d(
    folder: Path,
    name: str,
    positions: Floats | None = None,
    *,
    fps: float = RATE.fps,
    units: str = "mm",
    analog: Audio | None = None,
) -> Path:
    import ezc3d

    positions = moving() if positions is None else positions
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.c3d"
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [fps or _MARKED]
    file["parameters"]["POINT"]["UNITS"]["value"] = [units]
    file["parameters"]["POINT"]["LABELS"]["value"] = list(LAYOUT.markers)
    points = np.ones((4, len(LAYOUT.markers), len(positions)))
    points[:3] = positions.transpose(2, 1, 0)
    file["data"]["points"] = points
    if analog is not None:
        file["parameters"]["ANALOG"]["RATE"]["value"] = [float(analog.rate)]
        file["parameters"]["ANALOG"]["LABELS"]["value"] = ["Audio"]
        samples = analog.samples[: len(positions) * (analog.rate // round(fps or 60))]
        file["data"]["analogs"] = samples[None, None].astype(np.float64)
    file.write(str(path))
    if not fps:  # the writer refuses it, so it is put in afterwards
        path.write_bytes(path.read_bytes().replace(np.float32(_MARKED).tobytes(), np.float32(0).tobytes()))
    return path


def write_livelink(folder: Path, name: str) -> Path:
    from mien.formats.livelink import COLUMNS

    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.csv"
    jaw = opening() / 20.0
    lines = [",".join(COLUMNS)]
    for frame, weight in enumerate(jaw):
        values = ["0.0"] * (len(COLUMNS) - 2)
        values[COLUMNS.index("JawOpen") - 2] = f"{weight:.6f}"
        values[COLUMNS.index("HeadYaw") - 2] = "0.1"
        lines.append(",".join([timecode(frame, RATE), "61", *values]))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def write_grid(folder: Path, names: tuple[str, ...]) -> Path:
    """Tracked arrays as the GRID recipe reads them, every landmark of the layout."""
    layout = load_layout("mediapipe-218")
    counts = {}
    for seed, name in enumerate(names):
        random = np.random.default_rng(seed)
        frames = np.tile(layout.places * [1, -1, -1], (50, 1, 1)) * 0.7 + [180, 140, 0]
        frames[10:30, layout.index(["2.3", "8.2", "2.1"]), 1] += 6.0
        counts[name] = np.round((frames + random.normal(0, 0.05, frames.shape)) * 64).astype(np.int16)
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(folder / "markers.npz", **counts)
    ids = [number for number, _ in sorted(layout.landmarks.items(), key=lambda item: layout.markers.index(item[1]))]
    about = {
        "landmark_ids": ids,
        "fps": 25,
        "position_scale": 64,
        "arkit_names": ["_neutral", "jawOpen"],
        "arkit_scale": 255,
    }
    (folder / "meta.json").write_text(json.dumps(about), encoding="utf-8")
    weights = {name: np.tile(np.array([[9, 51]], np.uint8), (50, 1)) for name in names}
    np.savez(folder / "arkit.npz", **weights)
    return folder
