"""Marker files in and out of ``mien recolor``."""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import numpy as np

from mien.animation.animation import Animation, imported
from mien.api.recoloring import recolor, recolor_markers, shown_markers
from mien.core.errors import InputError
from mien.core.files import check_writable, replace_when_complete
from mien.core.tracks import MarkerTrack
from mien.corpus.readers import detect
from mien.corpus.readers.raw_recordings import Raw
from mien.corpus.recipes import Recipe
from mien.formats.livelink import read_livelink
from mien.motion.performers import load_performer

__all__ = ["is_marker_output", "recolored_file", "write_markers"]

_TO_MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "": 1.0}


def is_marker_output(path: str) -> bool:
    """Whether a file of that name holds markers: ``.npz``, or ``.markers.csv`` (a plain ``.csv`` is of Live Link)."""
    return path.lower().endswith((".npz", ".markers.csv"))


def recolored_file(path: Path, options: argparse.Namespace) -> Animation:
    """A file of markers, or a Live Link recording, in another emotion."""
    reader = detect(path)
    if reader.name == "livelink":
        channels, notes = read_livelink(path)
        moved = imported(channels, path.stem, notes)
        return recolor(moved, options.to, options.performer or "default", options.way)
    if options.way in ("hand-made", "authored"):
        raise InputError("bare markers change by a learned map alone: their face is not known; give no --way hand-made")
    raw = _read(path)
    performer = load_performer(options.performer or "default")
    track = MarkerTrack(raw.markers.names, raw.markers.positions * _TO_MM[raw.units], raw.markers.rate)
    changed = recolor_markers(track, options.to, performer, options.source or "neutral", options.seed)
    return shown_markers(changed, options.to, performer, raw.audio, path.stem, options.seed)


def _read(path: Path) -> Raw:
    reader = detect(path)
    found = [one for one in reader.find(path) if one.motion == path]
    if not found:
        raise InputError(f"{path}: no markers found in it")
    raw = reader.read(found[0], Recipe("as it is", "markers as the file has them", reader.name))
    if raw.units not in _TO_MM:
        raise InputError(f"{path}: markers in {raw.units} cannot be changed; import them first (mien corpus import)")
    return raw


def write_markers(track: MarkerTrack, path: str) -> None:
    """Write markers in mm, as `mien corpus import` reads them: ``.npz`` or ``.csv``."""
    target = check_writable(path)
    with replace_when_complete(target) as unfinished:
        if target.suffix.lower() == ".npz":
            rate = np.array([track.rate.fraction.numerator, track.rate.fraction.denominator])
            with unfinished.open("wb") as file:
                np.savez_compressed(file, markers=track.positions, names=np.array(track.names), rate=rate, units="mm")
            return
        with unfinished.open("w", encoding="utf-8", newline="") as text:
            rows = csv.writer(text, lineterminator="\n")
            rows.writerow(["time", *(f"{name}_{axis}" for name in track.names for axis in "xyz")])
            for time, frame in zip(track.rate.times(len(track)), track.positions, strict=True):
                cells = [f"{value:.4f}" if np.isfinite(value) else "" for value in frame.ravel()]
                rows.writerow([f"{time:.6f}", *cells])
