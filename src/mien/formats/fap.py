"""``.fap``: MPEG-4 face animation parameters, measured on a face's feature points, in the text form of FAP players.

::

    # remarks, as many as wanted
    2.1 NAME FPS FRAMES
    0 0 1 1 ... (68 masks)         a mask and a line of values per frame
    FRAME VALUE VALUE ...          one value per set mask, in order

A set mask 1 has four values (viseme 1, viseme 2, blend 0..63, definition), a set mask 2 six (expression 1, intensity
0..63, expression 2, intensity 0..63, initial face, definition). Values 3 to 68 are whole numbers in units of the face
(FAPU): 1/1024 of a distance, or 1/100000 radian. Source: ISO/IEC 14496-2, Annex C; the text form is that of the MPEG-4
reference software and of the players that followed it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.animation.animation import Animation
from mien.core.assets import asset_table
from mien.core.border import guarded
from mien.core.channels import HEAD
from mien.core.errors import InputError, Note
from mien.core.files import replace_when_complete
from mien.core.limits import check_size
from mien.core.plain_text import read_plain_text
from mien.core.timeline import FrameRate
from mien.core.utterance import PAUSE
from mien.face.library import load_face
from mien.face.marker_sites import load_marker_places, place_markers
from mien.face.model import Face
from mien.face.retargeting import Site, basis_at

__all__ = [
    "COUNT", "FapTrack", "fap_table", "fap_track", "fap_units", "read_fap", "write_fap", "write_fap_track",
]  # fmt: skip

COUNT = 68
VERSION = "2.1"
_HIGH = (4, 6)  # values of parameters 1 and 2

Ints = NDArray[np.int64]


@cache
def fap_table() -> dict[str, Any]:
    """``assets/mpeg4/faps.toml``: parameters, feature points, expressions and visemes."""
    return asset_table("mpeg4/faps.toml")


@dataclass(frozen=True, eq=False)
class FapTrack:
    """Face animation parameters over time.

    Attributes
    ----------
    values : ndarray of int, shape (frames, 68)
        Column k is parameter k + 1; the first two are unused (see ``visemes`` and ``expressions``).
    masks : ndarray of bool, shape (frames, 68)
        Which parameters a frame holds.
    visemes : ndarray of int, shape (frames, 4)
        Viseme 1 and 2, blend (63: all of viseme 1), definition flag.
    expressions : ndarray of int, shape (frames, 6)
        Expression 1, its intensity (0..63), expression 2, its intensity, initial-face flag, definition flag.
    rate : FrameRate
    name : str
    """

    values: Ints
    masks: NDArray[np.bool_]
    visemes: Ints
    expressions: Ints
    rate: FrameRate
    name: str = "mien"

    def __len__(self) -> int:
        return len(self.values)

    def emotions(self) -> NDArray[np.float64]:
        """Intensity 0..1 of the six basic expressions (joy, sadness, anger, fear, disgust, surprise), (frames, 6)."""
        found = np.zeros((len(self), 6))
        for which, strength in ((0, 1), (2, 3)):
            chosen, level = self.expressions[:, which], self.expressions[:, strength] / 63
            frames = np.flatnonzero((chosen >= 1) & (chosen <= 6) & self.masks[:, 1])
            found[frames, chosen[frames] - 1] = np.maximum(found[frames, chosen[frames] - 1], level[frames])
        return np.clip(found, 0, 1)


def write_fap_track(track: FapTrack, path: str | Path) -> None:
    """Write parameters as a ``.fap`` file.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    name = "_".join(track.name.split()) or "mien"
    lines = [f"{VERSION} {name} {_spelt(track.rate)} {len(track)}"]
    for frame in range(len(track)):
        lines += [" ".join("1" if mask else "0" for mask in track.masks[frame]), _frame_line(track, frame)]
    with replace_when_complete(path) as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def _spelt(rate: FrameRate) -> str:
    whole = rate.fraction.denominator == 1
    return str(rate.fraction.numerator) if whole else f"{float(rate.fraction):.9g}"


def _frame_line(track: FapTrack, frame: int) -> str:
    mask = track.masks[frame]
    numbers = [frame]
    if mask[0]:
        numbers += track.visemes[frame].tolist()
    if mask[1]:
        numbers += track.expressions[frame].tolist()
    numbers += track.values[frame, 2:][mask[2:]].tolist()
    return " ".join(str(number) for number in numbers)


@guarded("a FAP file")
def read_fap(path: str | Path) -> FapTrack:
    """Read a ``.fap`` file.

    Raises
    ------
    InputError
        If the file is missing or no FAP file, or a line does not fit (file and line are named).
    """
    path = Path(path)
    text, _ = read_plain_text(path, "a FAP file")
    lines = iter(
        (number, line.split("#", 1)[0].split()) for number, line in enumerate(text.splitlines(), 1)
        if line.split("#", 1)[0].strip()
    )  # fmt: skip
    name, rate, frames = _header(path, lines)
    check_size("frames", frames, path)
    if frames > max(1000, len(text) // (2 * COUNT)):  # a mask takes two characters a parameter
        raise InputError(f"{path}: {frames} frames promised, {len(text)} characters there: is it cut short?")
    values, masks = np.zeros((frames, COUNT), np.int64), np.zeros((frames, COUNT), np.bool_)
    visemes, expressions = np.zeros((frames, 4), np.int64), np.zeros((frames, 6), np.int64)
    for frame in range(frames):
        number, mask = _whole_numbers(path, lines, f"the masks of frame {frame} of {frames}")
        if len(mask) != COUNT or not set(mask) <= {0, 1}:
            raise InputError(f"{path}:{number}: expected {COUNT} masks of 0 or 1, got {len(mask)} numbers")
        masks[frame] = np.array(mask, dtype=np.bool_)
        number, given = _whole_numbers(path, lines, f"the values of frame {frame} of {frames}")
        expected = 1 + sum(_HIGH[k] if k < 2 else 1 for k in np.flatnonzero(masks[frame]))
        if len(given) != expected:
            raise InputError(
                f"{path}:{number}: the masks ask for a frame number and {expected - 1} values, got {len(given)} numbers"
            )
        rest = given[1:]
        if masks[frame, 0]:
            visemes[frame], rest = rest[:4], rest[4:]
        if masks[frame, 1]:
            expressions[frame], rest = rest[:6], rest[6:]
        values[frame, 2:][masks[frame, 2:]] = rest
    if (more := next(lines, None)) is not None:
        raise InputError(f"{path}:{more[0]}: more follows after the {frames} frames that the first line speaks of")
    return FapTrack(values, masks, visemes, expressions, rate, name)


def _header(path: Path, lines: Iterator[tuple[int, list[str]]]) -> tuple[str, FrameRate, int]:
    number, words = next(lines, (1, []))
    try:
        version, name, fps, frames = words[0], " ".join(words[1:-2]), words[-2], int(words[-1])
        if len(words) < 4 or not version.startswith("2") or frames < 0:
            raise ValueError
        return name, FrameRate.of(fps), frames
    except (IndexError, ValueError, InputError) as problem:
        told = " ".join(words)[:60]
        raise InputError(f"{path}:{number}: expected '2.1 NAME FPS FRAMES', got {told!r}") from problem


def _whole_numbers(path: Path, lines: Iterator[tuple[int, list[str]]], what: str) -> tuple[int, list[int]]:
    found = next(lines, None)
    if found is None:
        raise InputError(f"{path}: ends before {what}")
    try:
        return found[0], [int(word.removesuffix(".0")) for word in found[1]]
    except ValueError as problem:
        raise InputError(f"{path}:{found[0]}: expected whole numbers ({problem})") from problem


# ------------------------------------------------------------------ from an animation

Floats = NDArray[np.float64]
_AXES = {"x": 0, "y": 1, "z": 2}
_ANGLE_UNIT = 1e-5  # radian


def write_fap(animation: Animation, face: Face, path: str | Path, high_level: bool = False) -> tuple[Note, ...]:
    """Write an animation as face animation parameters.

    Parameters
    ----------
    animation : Animation
    face : Face
        On whose feature points displacements are measured; the units are its own distances. A face without the points
        for the units is replaced by the default face, and a note says so: parameters are meant to fit any face.
    path : path-like
    high_level : bool
        Write parameters 1 (visemes, from the phones) and 2 (expressions, from the score) instead of the low-level ones:
        a player that gets both would move twice.

    Raises
    ------
    InputError
        If the animation has no frames.
    OutputError
        If the file cannot be written.
    """
    if len(animation.channels) == 0:
        raise InputError(f"cannot write {path}: the animation has no frames")
    notes: tuple[Note, ...] = ()
    if not high_level:
        face, notes = _measurable(face)
    track = fap_track(animation, face, high_level)
    write_fap_track(track, path)
    if high_level:
        return ()
    lacking = [int(k) for k in fap_table()["fap"] if not track.masks[0, int(k) - 1]]
    names = ", ".join(fap_table()["fap"][str(k)]["name"] for k in lacking)
    return (
        *notes,
        Note("note", f"parameters that nothing on face {face.name!r} moves or shows are masked out: {names}"),
    )


def _measurable(face: Face) -> tuple[Face, tuple[Note, ...]]:
    """The face itself where it has the points that units are measured between, else the default face and a note."""
    try:
        fap_units(face)
    except InputError as problem:
        return load_face(), (Note("note", f"{problem}; measured on the default face instead"),)
    return face, ()


def fap_units(face: Face) -> dict[str, float]:
    """Face animation parameter units of a face, mm (``AU``: radian): 1/1024 of its distances.

    Examples
    --------
    >>> from mien.face.library import load_face
    >>> round(1024 * fap_units(load_face("default"))["ES"])
    58
    """
    places = _places(face)
    eyes = {eye.side: np.array(eye.centre) for eye in face.eyes}
    wanted = ("3.1", "3.3", "9.15", "2.2", "8.3", "8.4")
    missing = [point for point in wanted if point not in places]
    if missing or set(eyes) != {"Left", "Right"}:
        raise InputError(
            f"face {face.name!r} lacks feature points {', '.join(missing) or 'of two eyes'}: FAP units need them"
        )
    distances = {
        "IRISD": places["3.1"][1] - places["3.3"][1],
        "ES": float(np.linalg.norm(eyes["Left"] - eyes["Right"])),
        "ENS": (eyes["Left"][1] + eyes["Right"][1]) / 2 - places["9.15"][1],
        "MNS": places["9.15"][1] - places["2.2"][1],
        "MW": places["8.3"][0] - places["8.4"][0],
    }
    unusable = [name for name, length in distances.items() if not length > 0]
    if unusable:
        raise InputError(f"face {face.name!r}: {', '.join(unusable)} must be distances above 0 mm")
    return {name: float(length) / 1024 for name, length in distances.items()} | {"AU": _ANGLE_UNIT}


def fap_track(animation: Animation, face: Face, high_level: bool = False) -> FapTrack:
    """An animation as face animation parameters; see `write_fap`."""
    track = animation.channels
    frames = len(track)
    values, masks = np.zeros((frames, COUNT)), np.zeros((frames, COUNT), np.bool_)
    visemes, expressions = np.zeros((frames, 4), np.int64), np.zeros((frames, 6), np.int64)
    if high_level:
        visemes, expressions = _visemes(animation), _expressions(animation)
        masks[:, :2] = True
    else:
        units, points = fap_units(face), _points(face)
        moved = _displacements(animation, face, points)
        angles = _angles(animation, face)
        for number, facts in fap_table()["fap"].items():
            column, name, unit = int(number) - 1, facts["name"], units[facts["unit"]]
            sign, axis = facts["positive"][0], facts["positive"][1:]
            if name in angles:
                values[:, column] = angles[name] / unit
            elif axis in _AXES and facts["point"] in moved:
                values[:, column] = (1 if sign == "+" else -1) * moved[facts["point"]][:, _AXES[axis]] / unit
            else:
                continue
            masks[:, column] = True
    whole = np.rint(values).astype(np.int64)
    return FapTrack(whole, masks, visemes, expressions, animation.rate, animation.provenance.performer)


def _places(face: Face) -> dict[str, Floats]:
    parts = {part.name: part for part in face.parts}
    return {point: parts[part].vertices[v].astype(np.float64) for point, (part, v) in _points(face).items()}


def _points(face: Face) -> dict[str, Site]:
    """Where MPEG-4's feature points are on a face: by its named sites, else by `mien.face.marker_sites`."""
    found: dict[str, Site] = {
        point: face.sites[site] for point, site in fap_table()["site"].items() if site in face.sites
    }
    parts = {part.name: part for part in face.parts}
    with suppress(InputError):  # a face on which the markers find no place keeps its named sites alone
        placed = place_markers(face, load_marker_places("mpeg4-32"))
        for point, site in zip(placed.names, placed.sites, strict=True):
            found.setdefault(point, site)
    if "tongue" in parts:
        forward = parts["tongue"].vertices[:, 2]
        found["6.1"] = ("tongue", int(np.argmax(forward)))
        middle = np.abs(forward - (forward.max() + forward.min()) / 2) < 4.0
        upper = np.where(middle, parts["tongue"].vertices[:, 1], -np.inf)
        found["6.2"] = ("tongue", int(np.argmax(upper)))
    return found


def _displacements(animation: Animation, face: Face, points: dict[str, Site]) -> dict[str, Floats]:
    """Of every feature point over time, (frames, 3) mm, the head and the eyeballs left out."""
    eyeballs = {eye.part for eye in face.eyes}
    kept = {point: site for point, site in points.items() if site[0] not in eyeballs}
    names = [name for name in animation.channels.names if name not in HEAD]
    basis = basis_at(face, list(kept.values()), names)
    moved = np.einsum("tk,kmd->tmd", animation.channels.select(names).values, basis)
    return {point: moved[:, number] for number, point in enumerate(kept)}


def _angles(animation: Animation, face: Face) -> dict[str, Floats]:
    """Head and eyeballs in radians, as the parameters count them: pitch down, yaw left, roll right."""
    yaw, pitch, roll = np.radians(animation.channels.select(HEAD).values.T)
    found = {"head_pitch": -pitch, "head_yaw": yaw, "head_roll": -roll}
    for eye in face.eyes:
        names = [f"eyeLook{way}{eye.side}" for way in ("Out", "In", "Up", "Down")]
        out, inward, up, down = animation.channels.select(names).values.T
        to_the_left = (out * eye.look_out - inward * eye.look_in) * (1 if eye.side == "Left" else -1)
        letter = eye.side[0].lower()
        found[f"yaw_{letter}_eyeball"] = np.radians(to_the_left)
        found[f"pitch_{letter}_eyeball"] = np.radians(down * eye.look_down - up * eye.look_up)
    return found


def _visemes(animation: Animation) -> NDArray[np.int64]:
    """Viseme of the phone at each frame and of the next one, blended over the phone's second half."""
    number = {phone: int(k) for k, phones in fap_table()["viseme"].items() for phone in phones}
    phones = [phone for phone in animation.utterance.phones if phone.end > phone.start]
    found = np.zeros((len(animation.channels), 4), np.int64)
    found[:, 2] = 63
    times = animation.rate.times(len(found))
    for index, phone in enumerate(phones):
        inside = np.flatnonzero((times >= phone.start) & (times < phone.end))
        after = phones[index + 1].label if index + 1 < len(phones) else PAUSE
        passed = (times[inside] - phone.start) / (phone.end - phone.start)
        found[inside, 0], found[inside, 1] = number.get(phone.label, 0), number.get(after, 0)
        found[inside, 2] = np.rint(63 * np.clip(1.5 - passed, 0, 1))
    return found


def _expressions(animation: Animation) -> NDArray[np.int64]:
    """The two strongest emotions of the score at each frame that MPEG-4 has a number for."""
    number = {emotion: int(k) for k, emotion in fap_table()["expression"].items()}
    times = animation.rate.times(len(animation.channels))
    strength = np.zeros((len(times), 7))
    for span in animation.score.emotions:
        if span.name in number:
            start = 0.0 if span.start is None else span.start
            end = np.inf if span.end is None else span.end
            inside = (times >= start) & (times < end)
            column = number[span.name]
            strength[inside, column] = np.maximum(strength[inside, column], span.intensity_at(times[inside]))
    order = np.argsort(-strength, axis=1, kind="stable")[:, :2]
    level = np.rint(63 * np.clip(np.take_along_axis(strength, order, axis=1), 0, 1)).astype(np.int64)
    order = np.where(level > 0, order, 0)
    found = np.zeros((len(times), 6), np.int64)
    found[:, [0, 2]], found[:, [1, 3]] = order, level
    return found
