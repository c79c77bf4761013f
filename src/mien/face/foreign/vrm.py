"""What a VRM avatar says of itself: its expressions, its head and eyes, how far they look, where it faces.

Sources: VRM 0.0 schema (``VRM.blendShapeMaster``, ``humanoid``, ``firstPerson``) and VRMC_vrm-1.0 (``expressions``,
``humanoid``, ``lookAt``), vrm-c/vrm-specification. Avatars of VRM 0 look along -z of the file, those of VRM 1 along +z.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from mien.core.errors import InputError
from mien.face.foreign.gltf_document import GltfDocument

__all__ = [
    "VrmExpression",
    "is_vrm",
    "vrm_bones",
    "vrm_expressions",
    "vrm_eye_degrees",
    "vrm_gaze_by_shapes",
    "vrm_painted",
    "vrm_springs",
]

_PARTS = {
    "head": "head", "neck": "neck", "leftEye": "eyeLeft", "rightEye": "eyeRight", "jaw": "jaw",
    "leftUpperArm": "armLeft", "rightUpperArm": "armRight",
}  # fmt: skip
_RANGES = {  # of VRM 1 and VRM 0
    "In": ("rangeMapHorizontalInner", "lookAtHorizontalInner"),
    "Out": ("rangeMapHorizontalOuter", "lookAtHorizontalOuter"),
    "Down": ("rangeMapVerticalDown", "lookAtVerticalDown"),
    "Up": ("rangeMapVerticalUp", "lookAtVerticalUp"),
}


@dataclass(frozen=True)
class VrmExpression:
    """One expression.

    Attributes
    ----------
    name : str
        Of the preset, or the author's own.
    binds : tuple of (mesh, target, share)
        What it moves: share 0..1 at weight 1.
    binary : bool
        Whether it is either off or on.
    mouth, blink : {"none", "block", "blend"}
        What it does to mouth shapes and blinks while it shows.
    """

    name: str
    binds: tuple[tuple[int, int, float], ...]
    binary: bool = False
    mouth: str = "none"
    blink: str = "none"


def is_vrm(document: GltfDocument) -> int | None:
    """The version, 0 or 1, of a VRM avatar; None for other files."""
    extensions = document.json.get("extensions", {})
    return 1 if "VRMC_vrm" in extensions else 0 if "VRM" in extensions else None


def vrm_expressions(document: GltfDocument) -> tuple[VrmExpression, ...]:
    """All expressions that move morph targets, in the file's order.

    Raises
    ------
    InputError
        If they name nodes, meshes or targets that there are not.
    """
    try:
        return (*_of_version_1(document), *_of_version_0(document))
    except (KeyError, IndexError, TypeError, AttributeError, ValueError) as problem:
        raise InputError(f"{document.path}: its VRM expressions do not hold together ({problem!r})") from problem


def _extension(document: GltfDocument, name: str) -> Mapping[str, Any]:
    found = document.json.get("extensions", {}).get(name, {})
    return found if isinstance(found, dict) else {}


def _of_version_1(document: GltfDocument) -> Iterator[VrmExpression]:
    expressions = _extension(document, "VRMC_vrm").get("expressions") or {}
    for group in ("preset", "custom"):
        for name, facts in (expressions.get(group) or {}).items():
            binds = tuple(
                (document.list_of("nodes")[bind["node"]]["mesh"], bind["index"], float(bind.get("weight", 1.0)))
                for bind in facts.get("morphTargetBinds") or []
            )
            _check_binds(document, binds)
            if binds:
                mouth, blink = facts.get("overrideMouth", "none"), facts.get("overrideBlink", "none")
                yield VrmExpression(name, binds, bool(facts.get("isBinary", False)), mouth, blink)


def _of_version_0(document: GltfDocument) -> Iterator[VrmExpression]:
    for facts in (_extension(document, "VRM").get("blendShapeMaster") or {}).get("blendShapeGroups") or []:
        preset = str(facts.get("presetName") or "")
        name = str(facts.get("name") or "") if preset in ("", "unknown") else preset
        binds = tuple(
            (bind["mesh"], bind["index"], float(bind.get("weight", 100.0)) / 100.0)
            for bind in facts.get("binds") or []
            if bind.get("mesh", -1) >= 0  # the exporter of UniVRM leaves -1 for what it could not find
        )
        _check_binds(document, binds)
        if binds:
            yield VrmExpression(name, binds, bool(facts.get("isBinary", False)))


def _check_binds(document: GltfDocument, binds: tuple[tuple[int, int, float], ...]) -> None:
    for mesh, target, _ in binds:
        if mesh < 0 or target < 0:
            raise IndexError(f"mesh {mesh}, target {target}")
        document.list_of("meshes")[mesh]["primitives"][0]["targets"][target]


def vrm_bones(document: GltfDocument) -> dict[str, int]:
    """Nodes of the head, the eyes, the jaw and the upper arms, as the avatar names them."""
    found = {}
    one = (_extension(document, "VRMC_vrm").get("humanoid") or {}).get("humanBones") or {}
    zero = (_extension(document, "VRM").get("humanoid") or {}).get("humanBones") or []
    pairs = [(bone, facts) for bone, facts in one.items()] if isinstance(one, dict) else []
    if isinstance(zero, list):
        pairs += [(facts.get("bone"), facts) for facts in zero if isinstance(facts, dict)]
    for bone, facts in pairs:
        node = facts.get("node") if isinstance(facts, dict) else None
        if bone in _PARTS and isinstance(node, int) and 0 <= node < len(document.list_of("nodes")):
            found[_PARTS[bone]] = node
    return found


def vrm_gaze_by_shapes(document: GltfDocument) -> bool:
    """Whether the avatar looks about by expressions rather than by turning its eyes."""
    one = (_extension(document, "VRMC_vrm").get("lookAt") or {}).get("type")
    zero = (_extension(document, "VRM").get("firstPerson") or {}).get("lookAtTypeName")
    return one == "expression" or zero == "BlendShape"


def vrm_eye_degrees(document: GltfDocument) -> dict[str, float]:
    """How far its eyes turn at most, degrees, as far as it says so and looks by bones."""
    if vrm_gaze_by_shapes(document):
        return {}
    found = {}
    one = _extension(document, "VRMC_vrm").get("lookAt") or {}
    zero = _extension(document, "VRM").get("firstPerson") or {}
    for way, (name, old_name) in _RANGES.items():
        degrees = (one.get(name) or {}).get("outputScale", (zero.get(old_name) or {}).get("yRange"))
        if isinstance(degrees, (int, float)) and 1.0 <= degrees <= 90.0:
            found[way] = float(degrees)
    return found


def vrm_painted(document: GltfDocument) -> tuple[str, ...]:
    """Names of expressions that move textures or colours of materials, which is not followed."""
    one = _extension(document, "VRMC_vrm").get("expressions") or {}
    found = []
    for group in ("preset", "custom"):
        for name, facts in (one.get(group) or {}).items() if isinstance(one, dict) else ():
            if isinstance(facts, dict) and (facts.get("textureTransformBinds") or facts.get("materialColorBinds")):
                found.append(str(name))
    zero = (_extension(document, "VRM").get("blendShapeMaster") or {}).get("blendShapeGroups") or []
    found += [
        str(f.get("name") or f.get("presetName")) for f in zero if isinstance(f, dict) and f.get("materialValues")
    ]
    return tuple(found)


def vrm_springs(document: GltfDocument) -> int:
    """How many chains of bones (hair, clothes) the avatar wants to swing; they are kept, but drawn still."""
    one = _extension(document, "VRMC_springBone").get("springs")
    zero = (_extension(document, "VRM").get("secondaryAnimation") or {}).get("boneGroups")
    return sum(len(chains) for chains in (one, zero) if isinstance(chains, list))
