"""``.c3d``: markers on the face's skin over time, with the sound as an analog channel (c3d.org, the C3D user guide).

Markers are those of a layout (`mien.capture.layouts`), put on the face by `mien.face.marker_sites`; labels are the
layout's names, so that `mien corpus import` knows them. Millimetres, x to the speaker's left, y up, z forward, the head
turns. Frame 1 of the file is frame 0 of the animation and the start of the sound.
"""

from __future__ import annotations

import math
import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.animation.animation import Animation
from mien.core.channels import WEIGHTS
from mien.core.errors import InputError, Note, OutputError
from mien.core.files import replace_when_complete
from mien.core.temporary_folder import temporary_folder
from mien.core.tracks import MarkerTrack
from mien.face.deformers import poser_for
from mien.face.library import load_face
from mien.face.marker_sites import load_marker_places, place_markers
from mien.face.model import Face

__all__ = ["face_markers", "write_c3d"]

Floats = NDArray[np.float64]
_COUNTED = 65_535  # frames that the format's header can count


def face_markers(animation: Animation, face: Face, layout: str = "mediapipe-218") -> MarkerTrack:
    """Where a layout's markers are on a face that performs an animation.

    Parameters
    ----------
    animation : Animation
    face : Face
    layout : str
        One of `mien.capture.layouts.known_layouts`.

    Returns
    -------
    MarkerTrack
        Millimetres, in the axes of `mien.face.model`; the head's motion is in it.

    Raises
    ------
    InputError
        If the markers cannot be put on the face.
    """
    placed = place_markers(face, load_marker_places(layout))
    track = animation.channels
    known = set(WEIGHTS) | {name for part in face.parts for name in part.targets}
    poser = poser_for(face, [name for name in track.names if name in known or name.startswith("head")])
    number = {part.name: index for index, part in enumerate(face.parts)}
    parts = np.array([number[part] for part, _ in placed.sites])
    vertices = np.array([vertex for _, vertex in placed.sites])
    rows = track.select(poser.channel_names).values
    positions = np.empty((len(track), len(vertices), 3))
    for frame, row in enumerate(rows):
        posed = poser.pose(row)
        for part in np.unique(parts):
            positions[frame, parts == part] = posed.parts[part].vertices[vertices[parts == part]]
    return MarkerTrack(placed.names, positions, track.rate)


def write_c3d(
    animation: Animation, face: Face, path: str | Path, layout: str = "mediapipe-218", sound: bool = True
) -> tuple[Note, ...]:
    """Write the face's markers, and the sound, as C3D.

    Parameters
    ----------
    animation : Animation
    face : Face
        One on which the markers find no place is replaced by the default face, and a note says so.
    path : path-like
    layout : str
        Which markers.
    sound : bool
        Whether the sound goes along, resampled to a whole number of samples per frame as the format asks.

    Raises
    ------
    InputError
        If the animation has no frames.
    OutputError
        If the file cannot be written.
    """
    import ezc3d

    if len(animation.channels) == 0:
        raise InputError(f"cannot write {path}: the animation has no frames")
    notes: tuple[Note, ...] = ()
    try:
        markers = face_markers(animation, face, layout)
    except InputError as problem:
        notes = (Note("warning", f"{problem}; the markers are those of the default face"),)
        markers = face_markers(animation, load_face(), layout)
    file = ezc3d.c3d()
    point = file["parameters"]["POINT"]
    point["RATE"]["value"] = [markers.rate.fps]
    point["UNITS"]["value"] = ["mm"]
    point["LABELS"]["value"] = list(markers.names)
    file.add_parameter("POINT", "X_SCREEN", ["+X"])
    file.add_parameter("POINT", "Y_SCREEN", ["+Y"])
    file["data"]["points"] = np.concatenate(
        [markers.positions.transpose(2, 1, 0), np.ones((1, len(markers.names), len(markers)))]
    )
    if sound:
        samples, rate = _sound(animation, len(markers))
        analog = file["parameters"]["ANALOG"]
        analog["RATE"]["value"], analog["LABELS"]["value"] = [rate], ["Audio"]
        file["data"]["analogs"] = samples[None, None]
    file.add_parameter("MANUFACTURER", "SOFTWARE", ["mien"])
    file.add_parameter("MANUFACTURER", "VERSION_LABEL", [animation.provenance.version])
    file.add_parameter("MIEN", "SOUND_START", [0.0])
    file.add_parameter("MIEN", "SOUND_SECONDS", [float(animation.utterance.duration)])
    file.add_parameter("MIEN", "LAYOUT", [layout])
    if len(markers) > _COUNTED:
        notes += (Note("warning", f"{Path(path).name}: a C3D header counts {_COUNTED} frames, this one has more"),)
    with temporary_folder() as folder:  # the library opens no path beyond ASCII on every system
        made = folder / "a.c3d"
        file.write(str(made))
        content = made.read_bytes()
        if len(content) < 4 * sum(
            int(np.prod(array.shape)) for array in (file["data"]["points"], file["data"]["analogs"])
        ):
            raise OutputError(f"cannot write {path}: the disk of {folder} is full; free some space and run again")
        content = _with_analog_arrays(content)
    with replace_when_complete(path) as unfinished:
        unfinished.write_bytes(content)
    return notes


def _with_analog_arrays(content: bytes) -> bytes:
    """``ANALOG:SCALE`` and ``OFFSET`` of a single channel as arrays of one, as the user guide has them.

    ezc3d writes one number without dimensions, which other readers (PyPI's ``c3d``) refuse. A parameter is: length of
    its name, group, name, bytes to the next one, type, number of dimensions, dimensions, values, description.
    """
    begin = 512 * (content[0] - 1)
    blocks = content[begin + 2]
    out, place = bytearray(content[begin : begin + 4]), begin + 4
    groups: dict[str, int] = {}
    data_start = None
    while content[place]:
        (count, group), name_at = struct.unpack_from("bb", content, place), place + 2
        step_at = name_at + abs(count)
        name = content[name_at:step_at].decode("ascii", "replace")
        (step,) = struct.unpack_from("<h", content, step_at)
        rest = content[step_at + 2 : step_at + step]
        if group < 0:
            groups[name] = -group
        elif group == groups.get("ANALOG") and name in ("SCALE", "OFFSET") and rest[1] == 0:
            rest = rest[:1] + b"\x01\x01" + rest[2:]
        elif group == groups.get("POINT") and name == "DATA_START":
            data_start = len(out) + 2 + abs(count) + 2 + 2
        out += content[place:step_at] + struct.pack("<h", len(rest) + 2) + rest
        place = step_at + step
    needed = -(-(len(out) + 1) // 512)
    header = bytearray(content[:begin])
    if needed > blocks and data_start is not None:
        out[2] = needed
        first = struct.unpack_from("<H", header, 16)[0] + needed - blocks
        struct.pack_into("<H", header, 16, first)
        struct.pack_into("<h", out, data_start, first)
    out += bytes(512 * max(needed, blocks) - len(out))
    return bytes(header) + bytes(out) + content[begin + 512 * blocks :]


def _sound(animation: Animation, frames: int) -> tuple[Floats, float]:
    """Samples for every frame, and their rate: the next multiple of the frame rate above the sound's own.

    Both rates are kept in 32 bits. Where their quotient would not be whole then (59.94), the multiple is a power of
    two, since readers such as PyPI's c3d refuse any other.
    """
    import soxr

    audio, fps = animation.utterance.audio, animation.rate.fps
    each = math.ceil(audio.rate / fps - 1e-9)
    if float(np.float32(each * fps)) != each * float(np.float32(fps)):
        each = 2 ** math.ceil(math.log2(each))
    samples = np.asarray(soxr.resample(audio.samples, audio.rate, each * fps, quality="HQ"), dtype=np.float64)
    filled = np.zeros(frames * each)
    filled[: min(len(samples), len(filled))] = samples[: len(filled)]
    return filled, each * fps
