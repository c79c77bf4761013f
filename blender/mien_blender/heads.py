"""Which objects make up a head, and what of them mien gets to see."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import bpy
import numpy as np
from mathutils import Matrix, Quaternion

from .head_file import Node, Shapes

UP = Matrix(((1, 0, 0), (0, 0, 1), (0, -1, 0)))
"""From Blender's axes (z up) to glTF's (y up)."""


@dataclass(frozen=True)
class Member:
    """One thing of a head that moves: an object, or a bone of one.

    ``turn`` is its turn in the world at rest (glTF's axes), ``basis`` the turn that its own channels hold at rest.
    """

    object: bpy.types.Object
    bone: str = ""
    turn: Quaternion = field(default_factory=Quaternion)
    basis: Quaternion = field(default_factory=Quaternion)

    @property
    def keys(self) -> list:
        """Its shape keys, but for the first."""
        data = self.object.data
        shapes = None if self.bone else getattr(data, "shape_keys", None)
        return [] if shapes is None or not shapes.use_relative else list(shapes.key_blocks)[1:]


def objects_of(chosen: bpy.types.Object) -> list[bpy.types.Object]:
    """All objects of the head to which an object belongs: those under one parent, and those its bones bend."""
    top = _top(chosen)
    found = [top, *top.children_recursive]
    bones = {one for one in found if one.type == "ARMATURE"}
    for one in bpy.context.scene.objects:
        if one not in found and any(m.type == "ARMATURE" and m.object in bones for m in one.modifiers):
            found.append(one)
    return found


def _top(one: bpy.types.Object) -> bpy.types.Object:
    bent = next((m.object for m in one.modifiers if m.type == "ARMATURE" and m.object), None)
    one = one if one.parent or bent is None else bent
    while one.parent is not None:
        one = one.parent
    return one


def has_shapes(chosen: bpy.types.Object | None) -> bool:
    """Whether anything of the head has shape keys."""
    return chosen is not None and any(Member(one).keys for one in objects_of(chosen))


def members_of(chosen: bpy.types.Object) -> tuple[list[Member], list[Node]]:
    """A head's moving things and, one to one, the nodes that stand for them in the file for mien."""
    members, nodes = [], []
    posed = [one.data for one in objects_of(chosen) if one.type == "ARMATURE" and one.data.pose_position == "POSE"]
    for bones in posed:  # what hangs on bones is seen where it is at rest
        bones.pose_position = "REST"
    bpy.context.view_layer.update()
    for one in objects_of(chosen):
        place, turn, _ = one.matrix_world.decompose()
        still, basis = _at_rest(one)
        turn = turn @ basis.inverted() @ still
        own = Quaternion(UP.to_quaternion() @ turn)
        members.append(Member(one, "", own, still))
        nodes.append(Node(one.name, UP @ place, _xyzw(own), _shapes(one, own, UP @ place)))
        if one.type == "ARMATURE":
            for bone in one.data.bones:
                matrix = one.matrix_world @ bone.matrix_local
                own = UP.to_quaternion() @ matrix.to_quaternion()
                members.append(Member(one, bone.name, own))
                nodes.append(Node(bone.name, UP @ matrix.translation, _xyzw(own), joint=True))
    for bones in posed:
        bones.pose_position = "POSE"
    return members, nodes


def _at_rest(one: bpy.types.Object) -> tuple[Quaternion, Quaternion]:
    """An object's own turn before any performance of mien's, and its turn now."""
    now = one.rotation_quaternion.copy() if one.rotation_mode == "QUATERNION" else one.matrix_basis.to_quaternion()
    held = one.get("mien_rest")
    return (Quaternion(held) if held is not None else now), now


def _shapes(one: bpy.types.Object, turn: Quaternion, place) -> Shapes | None:
    member = Member(one)
    if one.type != "MESH" or not len(one.data.vertices):
        return None
    turn_back = turn.to_matrix().inverted()
    whole = np.array(turn_back @ UP @ one.matrix_world.to_3x3())
    offset = np.array(turn_back @ (UP @ one.matrix_world.translation - place))
    mesh = one.data
    count = len(mesh.vertices)

    def read(points: object) -> np.ndarray:
        flat = np.empty(3 * count, np.float32)
        points.foreach_get("co", flat)
        return flat.reshape(-1, 3)

    keys = member.keys
    rest = read(mesh.shape_keys.key_blocks[0].data if keys else mesh.vertices)
    mesh.calc_loop_triangles()
    triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    targets = []
    for key in keys:
        moved = read(key.data) - (
            rest if key.relative_key == mesh.shape_keys.key_blocks[0] else read(key.relative_key.data)
        )
        targets.append((key.name, moved @ whole.T, float(np.clip(key.value, 0.0, 1.0))))
    return Shapes(rest @ whole.T + offset, triangles.reshape(-1, 3), targets)


def _xyzw(turn: Quaternion) -> tuple[float, float, float, float]:
    return turn.x, turn.y, turn.z, turn.w


def meshes_of(chosen: bpy.types.Object) -> Iterator[bpy.types.Object]:
    """The head's meshes."""
    return (one for one in objects_of(chosen) if one.type == "MESH")
