"""What of a foreign face is driven by which channels, and what turns: the one place that decides.

A target gets its meaning from the user's own table, from the expressions of a VRM that bind it, or from its name. Then
each mesh is looked at as a whole, so that nothing moves twice: a target that does a channel's work exactly is not
helped by joined or split ones, rich shapes make visemes superfluous, and whole-face expressions are a last resort.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.channels import MOUTH, TONGUE
from mien.core.errors import InputError
from mien.core.tracks import ChannelTrack
from mien.face.foreign.gltf_document import GltfDocument, read_gltf
from mien.face.foreign.rig_names import KINDS, Match, OwnNames, name_tables, own_names, recognised, words
from mien.face.foreign.rig_nodes import Turning, turning_nodes
from mien.face.foreign.target_geometry import Likeness
from mien.face.foreign.vrm import VrmExpression, is_vrm, vrm_expressions, vrm_gaze_by_shapes

__all__ = ["EMPTY", "UNKNOWN", "UNNAMED", "Drive", "DrivenMesh", "DrivenTarget", "ForeignFace", "foreign_face"]

UNKNOWN, UNNAMED = "its name is not known", "it has no name"
EMPTY = "it is empty: it moves nothing"
"""Why a target stays still."""

Floats = NDArray[np.float64]
_NOTHING = 1e-7
"""Units of the file, metres as glTF has it: a target that moves less moves nothing."""
_RICH = 10
"""Channels of the mouth from which on a mesh has shapes rich enough to do without visemes."""
_SPEECH = {"jawOpen", "mouthFunnel", "mouthPucker", "mouthClose"}
_SHAPED = tuple(name for name in MOUTH if name not in TONGUE and name != "tongueOut")


@dataclass(frozen=True)
class Drive:
    """One of the things that move a target: ``share`` x the sum of weight x channel, held in 0..1.

    Attributes
    ----------
    match : Match
    share : float
    binary : bool
        Whether the sum counts as 0 below a half and as 1 from there on.
    name : str
        Of the VRM expression that it is, or "".
    """

    match: Match
    share: float = 1.0
    binary: bool = False
    name: str = ""

    def value(self, track: ChannelTrack) -> Floats:
        """Its weight in every frame, before ``share``, shape (frames,)."""
        recipe = self.match.recipe
        value = np.clip(track.select(tuple(recipe)).values @ np.array(list(recipe.values())), 0.0, 1.0)
        return np.where(value >= 0.5, 1.0, 0.0) if self.binary else value


@dataclass(frozen=True)
class DrivenTarget:
    """One morph target: ``drives`` is empty where it stays still, and ``still`` says why then."""

    name: str
    drives: tuple[Drive, ...]
    still: str = ""


@dataclass(frozen=True)
class DrivenMesh:
    """One mesh and its targets; ``number`` is its place in the document."""

    number: int
    name: str
    targets: tuple[DrivenTarget, ...]

    @property
    def moves(self) -> bool:
        """Whether any target is driven."""
        return any(target.drives for target in self.targets)


@dataclass(frozen=True)
class ForeignFace:
    """A recognised face.

    Attributes
    ----------
    document : GltfDocument
    meshes : tuple of DrivenMesh
        All meshes, in the document's order.
    turning : Turning
        What turns, how far, and where the face looks.
    overrides : tuple of VrmExpression
        Driven expressions that hold blinks or mouth shapes back while they show.
    proposals : mapping of str to Likeness
        Targets without a known name, as ``mesh/target``, that move like a channel and are not used for it.
    """

    document: GltfDocument
    meshes: tuple[DrivenMesh, ...]
    turning: Turning
    overrides: tuple[VrmExpression, ...] = ()
    proposals: Mapping[str, Likeness] = field(default_factory=dict)
    arms: bool = True
    """Whether arms that stand out to the sides are lowered."""

    @property
    def jaw_turns(self) -> bool:
        """Whether a bone opens the mouth: there is one of the jaw, and no shape does it."""
        drives = [drive for mesh in self.meshes for target in mesh.targets for drive in target.drives]
        return "jaw" in self.turning.nodes and not any(d.match.recipe.get("jawOpen", 0) > 0 for d in drives)

    @property
    def moves(self) -> bool:
        """Whether any morph target is driven, or a bone opens the mouth."""
        return self.jaw_turns or any(mesh.moves for mesh in self.meshes)

    def require_motion(self) -> None:
        """Refuse a face of which nothing could move.

        Raises
        ------
        InputError
            Naming what the face has instead.
        """
        if self.moves:
            return
        names = [target.name for mesh in self.meshes for target in mesh.targets if target.name]
        if not any(mesh.targets for mesh in self.meshes):
            told = "has no morph targets and no jaw bone: nothing could move ('mien face fit' gives a head its shapes)"
            raise InputError(f"{self.document.path} {told}")
        if all(target.still == EMPTY for mesh in self.meshes for target in mesh.targets):
            raise InputError(f"{self.document.path}: all its morph targets are empty: nothing could move")
        told = f"its targets are {', '.join(names[:5])} ..." if names else "its targets have no names"
        raise InputError(
            f"{self.document.path} has no morph target with a known name, {told}: nothing could move; "
            "give a table of your own with --names (docs/faces.md)"
        )

    def weights(self, mesh: DrivenMesh, track: ChannelTrack, rest: Sequence[float] | None = None) -> Floats:
        """Weights of a mesh's targets over time, shape (frames, targets), 0..1; what is not driven keeps ``rest``."""
        values = np.tile(np.asarray(rest or [0.0] * len(mesh.targets), dtype=np.float64), (len(track), 1))
        held = self._held(track)
        for column, target in enumerate(mesh.targets):
            if target.drives:
                total = np.zeros(len(track))
                for drive in target.drives:
                    total += drive.share * drive.value(track) * held[_held_by(drive)]
                values[:, column] = np.clip(total, 0.0, 1.0)
        return values

    def _held(self, track: ChannelTrack) -> dict[str, Floats]:
        """What expressions leave of mouth shapes and blinks in every frame (VRM 1, overrides)."""
        left = {"": np.ones(len(track)), "mouth": np.ones(len(track)), "blink": np.ones(len(track))}
        showing = {d.name: d for m in self.meshes for t in m.targets for d in t.drives if d.name}
        for expression in self.overrides:
            if expression.name in showing:
                value = showing[expression.name].value(track)
                for part, kind in (("mouth", expression.mouth), ("blink", expression.blink)):
                    if kind == "blend":
                        left[part] = left[part] * (1.0 - value)
                    elif kind == "block":
                        left[part] = np.where(value > 0, 0.0, left[part])
        return left


def _held_by(drive: Drive) -> str:
    """Which of VRM's groups an expression belongs to, by its preset."""
    if drive.name.lower() in ("aa", "ih", "ou", "ee", "oh"):
        return "mouth"
    return "blink" if drive.name.lower() in ("blink", "blinkleft", "blinkright") else ""


def foreign_face(source: str | Path | GltfDocument, names: OwnNames | str | Path | None = None) -> ForeignFace:
    """Read and recognise a face in a ``.glb``, ``.vrm`` or ``.gltf`` file.

    Parameters
    ----------
    source : path-like or GltfDocument
    names : OwnNames or path-like, optional
        A table of the user's own.

    Raises
    ------
    InputError
        If a file cannot be read or does not hold together.
    """
    document = source if isinstance(source, GltfDocument) else read_gltf(source)
    own = names if isinstance(names, OwnNames) else own_names(names) if names is not None else OwnNames()
    try:
        return _recognised(document, own)
    except (KeyError, IndexError, TypeError, AttributeError, ValueError, OverflowError) as problem:
        told = f"{document.path}: its meshes, nodes or extensions do not hold together ({problem!r})"
        raise InputError(told) from problem


def _recognised(document: GltfDocument, own: OwnNames) -> ForeignFace:
    expressions = vrm_expressions(document)
    found = [_meanings(document, number, expressions, own) for number in range(len(document.list_of("meshes")))]
    rich = any(_mouth_channels(mesh) >= _RICH for mesh in found)
    meshes = tuple(_settled(mesh, rich) for mesh in found)
    driven = {drive.name for mesh in meshes for target in mesh.targets for drive in target.drives}
    overrides = tuple(e for e in expressions if e.name in driven and (e.mouth != "none" or e.blink != "none"))
    turning = turning_nodes(document, own)
    if any(_is_eyeball(document, mesh) and _looks(document, mesh) for mesh in meshes):
        eyes = tuple(part for part in turning.nodes if part.startswith("eye") and part not in own.nodes)
        nodes = {part: node for part, node in turning.nodes.items() if part not in eyes}
        turning = replace(turning, nodes=nodes, by_shapes=eyes)
    return ForeignFace(document, meshes, turning, overrides)


def _is_eyeball(document: GltfDocument, mesh: DrivenMesh) -> bool:
    """Whether a mesh is an eyeball by its name, or by that of a node that shows it."""
    shown = [str(node.get("name", "")) for node in document.list_of("nodes") if node.get("mesh") == mesh.number]
    tables = name_tables()
    for name in (mesh.name, *shown):
        parts = set(words(name))
        if parts & set(tables["eyeballs"]) and not parts & set(tables["not_eyeballs"]):
            return True
    return False


def _empty_targets(document: GltfDocument, number: int) -> list[bool]:
    """Which targets of a mesh move no vertex of any of its primitives: names that exporters keep without a shape."""
    primitives = document.list_of("meshes")[number]["primitives"]
    count = len(primitives[0].get("targets", []))
    return [all(_moves_nothing(document, primitive, place) for primitive in primitives) for place in range(count)]


def _moves_nothing(document: GltfDocument, primitive: Mapping[str, Any], place: int) -> bool:
    targets = primitive.get("targets", [])
    if place >= len(targets) or "POSITION" not in targets[place]:
        return True
    accessors, number = document.list_of("accessors"), targets[place]["POSITION"]
    facts = accessors[number] if isinstance(number, int) and 0 <= number < len(accessors) else {}
    bounds = [*facts.get("min", ()), *facts.get("max", ())]
    if bounds:
        return not any(abs(value) > _NOTHING for value in bounds)
    return bool(facts) and "bufferView" not in facts and "sparse" not in facts  # zeros, as glTF has it


def _looks(document: GltfDocument, mesh: DrivenMesh) -> bool:
    """Whether a mesh has driven gaze shapes that move something, as far as their bounds tell."""
    primitives = document.list_of("meshes")[mesh.number]["primitives"]
    for place, target in enumerate(mesh.targets):
        if not any(channel.startswith("eyeLook") for drive in target.drives for channel in drive.match.recipe):
            continue
        for primitive in primitives:
            number = primitive["targets"][place].get("POSITION", -1)
            accessors = document.list_of("accessors")
            facts = accessors[number] if 0 <= number < len(accessors) else {}
            if any(abs(value) > 1e-9 for value in (*facts.get("min", ()), *facts.get("max", ()))):
                return True
    return False


def target_names(document: GltfDocument, number: int) -> tuple[str, ...]:
    """Names of a mesh's morph targets, "" where it has none: from its extras, else from its accessors."""
    mesh = document.list_of("meshes")[number]
    primitive = mesh["primitives"][0]
    count = len(primitive.get("targets", []))
    for holder in (mesh, *mesh["primitives"]):
        extras = holder.get("extras")
        given = extras.get("targetNames") if isinstance(extras, dict) else None
        if isinstance(given, list) and given:
            names = [name if isinstance(name, str) else "" for name in given[:count]]
            return tuple(names + [""] * (count - len(names)))
    return tuple(_accessor_name(document, target) for target in primitive.get("targets", []))


def _accessor_name(document: GltfDocument, target: Mapping[str, Any]) -> str:
    accessors, place = document.list_of("accessors"), target.get("POSITION")
    if isinstance(place, int) and 0 <= place < len(accessors):
        return str(accessors[place].get("name", ""))
    return ""


def _meanings(document: GltfDocument, number: int, expressions: Sequence[VrmExpression], own: OwnNames) -> DrivenMesh:
    """All that a mesh's targets could mean, before redundant ones are told to keep still."""
    names = target_names(document, number)
    by_name = recognised(names)
    empty = _empty_targets(document, number)
    shaped = sum(
        match is not None and match.exact and match.kind == "shapes" and not nothing
        for match, nothing in zip(by_name, empty, strict=True)
    )
    bound = {} if shaped >= _RICH else _bound(document, number, expressions)
    targets = []
    for place, name in enumerate(names):
        if empty[place]:
            targets.append(DrivenTarget(name, (), EMPTY))
            continue
        if name in own.targets:
            recipe = own.targets[name]
            drives: tuple[Drive, ...] = (Drive(Match("your own names", "own", recipe)),) if recipe else ()
            targets.append(DrivenTarget(name, drives, "" if drives else "your own table leaves it still"))
            continue
        match = by_name[place]
        drives = tuple(bound.get(place, ())) or ((Drive(match),) if match else ())
        still = "" if drives else UNKNOWN if name else UNNAMED
        targets.append(DrivenTarget(name, drives, still))
    label = str(document.list_of("meshes")[number].get("name") or f"mesh {number}")
    return DrivenMesh(number, label, tuple(targets))


def _bound(document: GltfDocument, number: int, expressions: Sequence[VrmExpression]) -> dict[int, list[Drive]]:
    """What VRM's expressions make of a mesh's targets."""
    matches = recognised([expression.name for expression in expressions])
    gaze = is_vrm(document) is not None and not vrm_gaze_by_shapes(document)
    bound: dict[int, list[Drive]] = {}
    for expression, match in zip(expressions, matches, strict=True):
        if match is None or (gaze and expression.name.lower().startswith("look")):
            continue
        if match.kind == "emotions" and expression.mouth == "block":
            continue  # it would stop the mouth as soon as it shows
        for mesh, target, share in expression.binds:
            if mesh == number:
                bound.setdefault(target, []).append(Drive(match, share, expression.binary, expression.name))
    return bound


def _mouth_channels(mesh: DrivenMesh) -> int:
    """How many of the mouth's channels finer shapes than visemes move."""
    moved = {c for t in mesh.targets for d in t.drives if d.match.kind in ("own", "shapes") for c in d.match.recipe}
    return len(moved & set(_SHAPED))


def _settled(mesh: DrivenMesh, rich: bool) -> DrivenMesh:
    """The mesh with every channel's work done once."""
    targets = _without_wholes(mesh.targets)
    shapes = {c for t in targets for d in t.drives if d.match.kind in ("own", "shapes") for c in _raised(d.match)}
    visemes = [d for t in targets for d in t.drives if d.match.kind == "visemes"]
    opens = "jawOpen" in shapes or not any("jawOpen" in _raised(drive.match) for drive in visemes)
    by_shapes = (opens and (_mouth_channels(mesh) >= _RICH or rich)) or not visemes
    done: set[str] = set()
    kept: dict[int, list[Drive]] = {place: [] for place in range(len(targets))}
    why: dict[int, str] = {}
    for kind in ("own", *KINDS):
        new: set[str] = set()
        # Tables are told apart, too: names of two conventions for one channel would move it twice.
        drives = [(p, d) for p, t in enumerate(targets) for d in t.drives if d.match.kind == kind]
        for title in _by_size([d.match.convention for _, d in drives]):
            group: set[str] = set()
            for place, drive in drives:
                if drive.match.convention != title:
                    continue
                raised = _raised(drive.match)
                reason = _reason(kind, raised, done | new, by_shapes)
                if reason:
                    why[place] = reason
                else:
                    kept[place].append(drive)
                    group |= raised
            new |= group
        done |= new
    settled = tuple(
        replace(target, drives=tuple(kept[place]), still=target.still if kept[place] else why.get(place, target.still))
        for place, target in enumerate(targets)
    )
    return replace(mesh, targets=settled)


def _raised(match: Match) -> set[str]:
    """The channels whose work a target does: those that weigh much in it."""
    most = max(match.recipe.values(), default=0.0)
    return {channel for channel, weight in match.recipe.items() if weight > 0.3 * most}


def _by_size(titles: Sequence[str]) -> list[str]:
    return sorted(dict.fromkeys(titles), key=lambda title: -titles.count(title))


def _reason(kind: str, raised: set[str], done: set[str], by_shapes: bool) -> str:
    """Why a target that is known stays still; "" if it does not."""
    if kind == "own":
        return ""
    if kind == "visemes":
        return "the mesh has finer shapes of the mouth" if by_shapes else ""
    if kind == "shapes" and not by_shapes and raised & _SPEECH:
        return "the mesh has visemes that do this"
    if raised <= done:
        return "other targets of the mesh do this already"
    return ""


def _without_wholes(targets: Sequence[DrivenTarget]) -> tuple[DrivenTarget, ...]:
    """Where a target is a channel itself, halves and parts of that channel do not move with it as well."""
    whole = {c for t in targets for d in t.drives if d.match.exact for c in d.match.recipe}
    result = []
    for target in targets:
        drives, twice = [], False
        for drive in target.drives:
            match = drive.match
            if match.exact or match.kind not in ("shapes", "spare"):
                drives.append(drive)
                continue
            rest = {channel: weight for channel, weight in match.recipe.items() if channel not in whole}
            twice = not rest
            if rest:
                drives.append(replace(drive, match=replace(match, recipe=rest)))
        still = "the mesh has the whole shape as well" if twice and not drives else target.still
        result.append(replace(target, drives=tuple(drives), still=still))
    return tuple(result)
