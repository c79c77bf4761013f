"""The graph in a performer's file: what is large is packed into small whole numbers, kept as it is, and mapped.

Arrays of motion, poses, sound and residuals stand in the archive uncompressed, so that opening a performer reads none
of them and using its graph maps them into memory; all others are compressed.
"""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.limits import array_header, array_of
from mien.motion.graph.compact import FEATURE_STEP, packed, unpacked
from mien.motion.graph.costs import SearchWeights
from mien.motion.graph.graph import AnimeGraph
from mien.motion.graph.graph_motion import GraphMotion, GraphMotionSettings
from mien.motion.graph.motion_code import MotionCode
from mien.motion.graph.recorded_residuals import FitWeights, RecordedResiduals
from mien.motion.mouth.lip_closure import LipClosure
from mien.motion.mouth.mouth_space import MouthSpace

__all__ = ["PREFIX", "RecordedSpeech", "graph_arrays", "graph_content", "is_mapped", "mapped_array", "recorded_speech"]

PREFIX = "graph/"
_POSES = ("motion", "entries", "exits")
_MAPPED = (*_POSES, "features", "residuals")
_TOLD = ("symbols", "emotion_names", "takes", "markers", "feature_rate", "motion_rate")

Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class RecordedSpeech:
    """Recorded motion of a performer; read when it is first used.

    Attributes
    ----------
    has_residuals : bool
        Whether what the recordings did beside the learned curves was learned too.
    emotions : tuple of str
        In which speech was recorded.
    """

    has_residuals: bool
    emotions: tuple[str, ...]
    _read: Callable[[], tuple[GraphMotion, RecordedResiduals | None]]

    @classmethod
    def of(cls, motion: GraphMotion, residuals: RecordedResiduals | None) -> RecordedSpeech:
        """What was just learned."""
        return cls(residuals is not None, motion.graph_.emotion_names, lambda: (motion, residuals))

    @cached_property
    def _parts(self) -> tuple[GraphMotion, RecordedResiduals | None]:
        return self._read()

    @property
    def motion(self) -> GraphMotion:
        """The graph, with what is needed to search and to join it."""
        return self._parts[0]

    @property
    def residuals(self) -> RecordedResiduals | None:
        """What the recordings did beside the learned curves."""
        return self._parts[1]


def is_mapped(name: str) -> bool:
    """Whether an array of the archive is kept uncompressed.

    Examples
    --------
    >>> is_mapped("graph/motion"), is_mapped("graph/phones"), is_mapped("speech/closing")
    (True, False, False)
    """
    return name.startswith(PREFIX) and name.removeprefix(PREFIX) in _MAPPED


def graph_content(recorded: RecordedSpeech) -> dict[str, Any]:
    """What ``performer.json`` tells of the graph."""
    motion, residuals, graph = recorded.motion, recorded.residuals, recorded.motion.graph_
    content: dict[str, Any] = {name: getattr(graph, name) for name in _TOLD}
    content |= {
        "settings": asdict(motion.settings),
        "weights": asdict(motion.weights_),
        "evenness": motion.evenness_,
        "share": motion.code_.share_,
    }
    if residuals is not None:
        content["residual_weights"] = asdict(residuals.weights_)
        content["residual_weights_without_sound"] = asdict(residuals.deaf_weights_)
    return content


def graph_arrays(recorded: RecordedSpeech) -> Arrays:
    """Arrays of the archive."""
    motion, residuals, graph = recorded.motion, recorded.residuals, recorded.motion.graph_
    arrays = {name: value for name, value in graph.to_arrays().items() if name not in (*_TOLD, *_MAPPED)}
    arrays |= {name: packed(getattr(graph, name), motion.steps_, np.int16) for name in _POSES}
    steps = np.full(graph.features.shape[1], FEATURE_STEP, dtype=np.float32)
    arrays |= {"features": packed(graph.features, steps, np.int8), "steps": motion.steps_}
    arrays |= {"mean": motion.code_.mean_, "axes": motion.code_.axes_, "mixing": motion.code_.mixing_}
    arrays |= {"cut_offs": motion.cut_offs_}
    if residuals is not None:
        arrays["residuals"] = packed(residuals.residuals_, residuals.steps_, np.int8)
        arrays["residual_steps"] = residuals.steps_
    return {PREFIX + name: value for name, value in arrays.items()}


def recorded_speech(
    content: Mapping[str, Any], read: Callable[[str], NDArray[Any]], mouth: MouthSpace, closure: LipClosure
) -> tuple[GraphMotion, RecordedResiduals | None]:
    """The way back.

    Parameters
    ----------
    content : mapping
        As `graph_content` gave it.
    read : callable
        Gives an array of `graph_arrays` by its name.
    mouth : MouthSpace
        In what the performer learned.
    closure : LipClosure
        The performer's.
    """
    steps, heard = read(PREFIX + "steps"), np.float32(FEATURE_STEP)
    named: Arrays = {name: np.array(content[name]) for name in _TOLD}
    for field in fields(AnimeGraph):
        if field.name not in _TOLD:
            named[field.name] = read(PREFIX + field.name)
    named |= {name: unpacked(named[name], steps) for name in _POSES}
    named["features"] = unpacked(named["features"], np.full(named["features"].shape[1], heard))
    given = dict(content["settings"])
    weights = given.pop("weights")
    settings = GraphMotionSettings(**given, weights=None if weights is None else SearchWeights(**weights))
    motion = GraphMotion(settings)
    motion.mouth_, motion.steps_, motion.closure_ = mouth, steps, closure
    motion.code_ = MotionCode(settings.share, settings.seed)
    mean, axes, mixing = (read(PREFIX + name) for name in ("mean", "axes", "mixing"))
    motion.code_.restore(mean, axes, mixing, content["share"])
    motion.cut_offs_ = read(PREFIX + "cut_offs")
    motion.restore(AnimeGraph.from_arrays(named), SearchWeights(**content["weights"]), content["evenness"])
    if "residual_weights" not in content:
        return motion, None
    steps = read(PREFIX + "residual_steps")
    residuals = RecordedResiduals(motion.graph_).restore(
        unpacked(read(PREFIX + "residuals"), steps),
        steps,
        FitWeights(**content["residual_weights"]),
        FitWeights(**content["residual_weights_without_sound"]),
    )
    return motion, residuals


def mapped_array(path: Path, archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    """An array of an archive, mapped into memory where it is kept uncompressed, else read.

    Raises
    ------
    KeyError, ValueError, OSError
        If it is not there or damaged.
    """
    entry = archive.getinfo(name + ".npy")
    with archive.open(entry) as file:
        if entry.compress_type != zipfile.ZIP_STORED:
            return array_of(file, entry.file_size, f"{path}, {name}")
        shape, fortran, kind, inside = array_header(file, entry.file_size, f"{path}, {name}")
    if kind.hasobject or not np.prod(shape):
        return np.zeros(shape, dtype=kind)
    with path.open("rb") as raw:  # the entry's own head: 30 bytes, its name, and what else it says
        raw.seek(entry.header_offset + 26)
        lengths = np.frombuffer(raw.read(4), dtype="<u2")
    offset = entry.header_offset + 30 + int(lengths.sum()) + inside
    return np.memmap(path, dtype=kind, mode="r", offset=offset, shape=shape, order="F" if fortran else "C")
