"""A face of any maker, driven: keys are appended, everything else in the file stays as it is.

Source: glTF 2.0 specification, section 3.11 (animations).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from mien.core.errors import InputError, Note
from mien.core.files import replace_when_complete
from mien.core.tracks import ChannelTrack
from mien.face.foreign.known_face import known_face
from mien.face.foreign.recognition import ForeignFace
from mien.face.foreign.rig_names import OwnNames
from mien.face.foreign.rig_nodes import local_matrix, parts_of
from mien.formats.appended_glb import AppendedGlb
from mien.formats.turning_nodes import turns_of_nodes

__all__ = ["NAME", "drive_glb"]

NAME = "mien"
"""Of the animation: the first of the file, since players that are not asked play the first."""


def drive_glb(
    track: ChannelTrack,
    source: str | Path | ForeignFace,
    path: str | Path,
    names: OwnNames | str | Path | None = None,
    clip: str = NAME,
) -> tuple[Note, ...]:
    """Write a face again with the weights of a track, and its head and eyes turning, as the first of its animations.

    An animation that an earlier run of mien put there is replaced; others are kept.

    Parameters
    ----------
    track : ChannelTrack
    source : path-like or ForeignFace
        A ``.glb``, ``.vrm`` or ``.gltf`` file.
    path : path-like
        A ``.glb`` file.
    names : OwnNames or path-like, optional
        A table of the user's own (``docs/faces.md``).
    clip : str
        Name of the animation.

    Returns
    -------
    tuple of Note
        Which of the head and the eyes were not found among its nodes, and what of the file could not be taken along.

    Raises
    ------
    InputError
        If it cannot be read, has no morph target with a known name, or would be overwritten.
    OutputError
        If the result cannot be written.
    """
    face = source if isinstance(source, ForeignFace) else known_face(source, names)
    if face.document.path.resolve() == Path(path).resolve():
        raise InputError(f"{path} is both read and written: give the output another name")
    face.require_motion()
    keys = AppendedGlb(face.document)
    try:
        notes = _add_animation(track, face, keys, clip)
    except (KeyError, IndexError, TypeError, AttributeError, ValueError) as problem:
        raise InputError(f"{face.document.path}: its nodes do not hold together ({problem!r})") from problem
    content = keys.packed()
    with replace_when_complete(path) as unfinished:
        unfinished.write_bytes(content)
    return (*keys.notes, *notes)


def _add_animation(track: ChannelTrack, face: ForeignFace, keys: AppendedGlb, clip: str) -> tuple[Note, ...]:
    document = keys.document
    keys.forget_animations(_ours)
    times = keys.add(track.rate.times(len(track)).astype(np.float32), "SCALAR", bounds=True)
    channels: list[dict[str, Any]] = []
    samplers: list[dict[str, Any]] = []

    def put(node: int, path: str, output: int) -> None:
        channels.append({"sampler": len(samplers), "target": {"node": node, "path": path}})
        samplers.append({"input": times, "interpolation": "LINEAR", "output": output})

    for number, node in enumerate(document.get("nodes", [])):
        if "mesh" in node and face.meshes[node["mesh"]].moves:
            mesh = face.meshes[node["mesh"]]
            rest = node.get("weights") or document["meshes"][node["mesh"]].get("weights")
            weights = face.weights(mesh, track, rest if rest and len(rest) == len(mesh.targets) else None)
            put(number, "weights", keys.add(weights.astype(np.float32).reshape(-1), "SCALAR"))
    turned, notes = turns_of_nodes(track, face)
    for number, turns in turned.items():
        _without_matrix(document["nodes"][number])
        put(number, "rotation", keys.add(turns.astype(np.float32), "VEC4"))
    if not face.jaw_turns and not any(channel["target"]["path"] == "weights" for channel in channels):
        raise InputError(f"{face.document.path}: no node shows the meshes that could move")
    there = document.setdefault("animations", [])
    there.insert(0, {"name": clip, "extras": {"mien": {}}, "channels": channels, "samplers": samplers})
    if len(there) > 1:
        told = f"the file has {len(there) - 1} animation(s) of its own, kept; the performance is first, named {clip!r}"
        notes = (*notes, Note("note", told))
    return notes


def _ours(animation: dict[str, Any]) -> bool:
    """Whether an earlier run of mien made an animation: by its name, or by what mien's own faces note in it."""
    extras = animation.get("extras")
    return animation.get("name") == NAME or (isinstance(extras, dict) and "mien" in extras)


def _without_matrix(node: dict[str, Any]) -> None:
    """Give a node that is to turn its parts: glTF lets no matrix be animated."""
    if "matrix" in node:
        parts = parts_of(local_matrix(node))
        if parts is not None:
            del node["matrix"]
            node["translation"], node["rotation"], node["scale"] = parts
