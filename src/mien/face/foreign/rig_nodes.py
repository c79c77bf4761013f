"""Nodes of a foreign face: where they stand at rest, which of them are the head and the eyes, where the face looks."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.face.foreign.gltf_document import GltfDocument
from mien.face.foreign.rig_names import OwnNames, name_tables
from mien.face.foreign.vrm import is_vrm, vrm_bones, vrm_eye_degrees

__all__ = ["PARTS", "Turning", "local_matrix", "lowered_arms", "parts_of", "turning_nodes", "world_matrices"]

Floats = NDArray[np.float64]
PARTS = {"head": "head", "eyeLeft": "left eye", "eyeRight": "right eye"}
"""What should turn on any face, in words."""
_HANGING = 0.8  # of an arm's length: lower hands hang already
_FOUND = (*PARTS, "neck", "jaw", "armLeft", "armRight")


@dataclass(frozen=True)
class Turning:
    """What turns.

    Attributes
    ----------
    nodes : mapping of str to int
        Nodes for ``head``, ``neck``, ``eyeLeft`` and ``eyeRight`` (the speaker's own), ``jaw``, ``armLeft`` and
        ``armRight``, as far as there are any.
    by_shapes : tuple of str
        Those of the eyes that have nodes and are not turned by them, because shapes of the eyeballs do it.
    degrees : mapping of str to float
        How far an eye turns ``Up``, ``Down``, ``In`` and ``Out`` at weight 1 of its channels.
    facing : {1, -1}
        Whether the face looks along +z or -z of the file.
    """

    nodes: Mapping[str, int] = field(default_factory=dict)
    degrees: Mapping[str, float] = field(default_factory=dict)
    facing: int = 1
    by_shapes: tuple[str, ...] = ()


def turning_nodes(document: GltfDocument, own: OwnNames | None = None) -> Turning:
    """Find the head, the eyes and the way the face looks: as the user or the VRM says, else by names and places.

    Raises
    ------
    InputError
        If the user's table names a node that there is not.
    """
    own = own or OwnNames()
    nodes = _by_names(document) | vrm_bones(document) | _own_nodes(document, own)
    nodes = {part: node for part, node in nodes.items() if part in _FOUND}
    if "neck" in nodes and (
        "head" not in nodes or nodes["head"] not in set(document.below(nodes["neck"])) - {nodes["neck"]}
    ):
        del nodes["neck"]
    degrees = {**name_tables()["eyes"], **vrm_eye_degrees(document), **own.eyes}
    return Turning(nodes, degrees, _facing(document, nodes, own))


def _own_nodes(document: GltfDocument, own: OwnNames) -> dict[str, int]:
    found = {}
    names = [str(node.get("name", "")) for node in document.list_of("nodes")]
    for part, name in own.nodes.items():
        if name and name not in names:
            raise InputError(f"{document.path} has no node {name!r}, which your names give for {part}")
        if name:
            found[part] = names.index(name)
    return found


def _by_names(document: GltfDocument) -> dict[str, int]:
    given_names = [str(node.get("name", "")).lower() for node in document.list_of("nodes")]
    plain = [re.sub(r"[\W_]", "", name) for name in given_names]
    last = [re.sub(r"[\W_]", "", re.split(r"[:|]", name)[-1]) for name in given_names]  # without a namespace
    joints = {j for skin in document.list_of("skins") for j in skin.get("joints", []) if isinstance(j, int)}
    found = {}
    for part, names in name_tables()["nodes"].items():
        for name in names:
            places = [place for place in range(len(plain)) if name in (plain[place], last[place])]
            places = [place for place in places if _turns_by_itself(document, place, part)]
            if places:  # of two nodes of one name the joint is the one that moves something
                found[part] = next((place for place in places if place in joints), places[0])
                break
    return found


def _turns_by_itself(document: GltfDocument, place: int, part: str) -> bool:
    """Whether turning a node turns what it is named for about its own place: a bone, or a mesh that stands there."""
    node = document.list_of("nodes")[place]
    if "skin" in node:
        return False
    if part.startswith("arm"):
        return "mesh" not in node and bool(node.get("children"))
    if "mesh" in node and part == "head":  # teeth and eyes beside it would stay behind
        below, nodes = set(document.below(place)), document.list_of("nodes")
        if any("mesh" in other and number not in below for number, other in enumerate(nodes)):
            return False
    if "mesh" not in node or any(node.get("translation", ())):
        return True
    matrix = node.get("matrix")
    return matrix is not None and any(matrix[12:15])


def _facing(document: GltfDocument, nodes: Mapping[str, int], own: OwnNames) -> int:
    if own.faces:
        return 1 if own.faces == "+z" else -1
    if is_vrm(document) == 0:
        return -1
    if {"eyeLeft", "eyeRight"} <= set(nodes):
        world = world_matrices(document)
        across = world[nodes["eyeLeft"]][:3, 3] - world[nodes["eyeRight"]][:3, 3]
        forward = world[nodes["eyeLeft"]][:3, 3] + world[nodes["eyeRight"]][:3, 3]
        if "head" in nodes:
            forward = forward - 2 * world[nodes["head"]][:3, 3]
            if across[0] < 0 and forward[2] < 0 and -across[0] > 0.5 * float(np.linalg.norm(across)):
                return -1
    return 1


def local_matrix(node: Mapping[str, Any]) -> Floats:
    """A node's own matrix, (4, 4), acting on columns."""
    from scipy.spatial.transform import Rotation

    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    turn = np.array(node.get("rotation", [0.0, 0.0, 0.0, 1.0]), dtype=np.float64)
    matrix = np.eye(4)
    if np.linalg.norm(turn) > 0:
        matrix[:3, :3] = Rotation.from_quat(turn).as_matrix()
    matrix[:3, :3] *= np.array(node.get("scale", [1.0, 1.0, 1.0]), dtype=np.float64)
    matrix[:3, 3] = node.get("translation", [0.0, 0.0, 0.0])
    return matrix


def world_matrices(document: GltfDocument, turned: Mapping[int, Floats] | None = None) -> Floats:
    """Matrices of all nodes at rest, shape (nodes, 4, 4), from their own axes to the file's.

    ``turned`` gives some nodes other matrices of their own.
    """
    nodes, parents = document.list_of("nodes"), document.parents()
    result = np.tile(np.eye(4), (max(len(nodes), 1), 1, 1))
    done: set[int] = set()
    for start in range(len(nodes)):
        way = []
        place: int | None = start
        while place is not None and place not in done:
            way.append(place)
            place = parents.get(place)
        for node in reversed(way):
            own = turned[node] if turned and node in turned else local_matrix(nodes[node])
            result[node] = result[parents[node]] @ own if node in parents else own
            done.add(node)
    return result


def parts_of(matrix: Floats) -> tuple[list[float], list[float], list[float]] | None:
    """Translation, rotation (x, y, z, w) and scale of a matrix; None if it is sheared, flat or mirrored."""
    from scipy.spatial.transform import Rotation

    scale = np.linalg.norm(matrix[:3, :3], axis=0)
    if not np.all(scale > 1e-9):
        return None
    turn = matrix[:3, :3] / scale
    if np.abs(turn.T @ turn - np.eye(3)).max() > 1e-4 or np.linalg.det(turn) < 0:
        return None
    return matrix[:3, 3].tolist(), Rotation.from_matrix(turn).as_quat().tolist(), scale.tolist()


def lowered_arms(document: GltfDocument, nodes: Mapping[str, int]) -> dict[int, Floats]:
    """Own matrices (4, 4) by node with which arms that stand out to the sides (T- and A-poses) hang down."""
    from scipy.spatial.transform import Rotation

    found = {}
    world = world_matrices(document) if {"armLeft", "armRight"} & set(nodes) else np.zeros((0, 4, 4))
    for part in ("armLeft", "armRight"):
        children = document.list_of("nodes")[nodes[part]].get("children", []) if part in nodes else []
        if not children:
            continue
        node = nodes[part]
        arm = max((world[child][:3, 3] - world[node][:3, 3] for child in children), key=lambda v: float(v @ v))
        length = float(np.linalg.norm(arm))
        if length < 1e-9 or arm[1] < -_HANGING * length or abs(arm[0]) < 0.3 * length:
            continue  # hangs already, or does not stand out sideways
        goal = np.array([np.sign(arm[0]) * 0.25, -1.0, 0.0])
        axis = np.cross(arm / length, goal / np.linalg.norm(goal))
        angle = np.arctan2(np.linalg.norm(axis), arm @ goal / length / np.linalg.norm(goal))
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_rotvec(axis / max(float(np.linalg.norm(axis)), 1e-9) * angle).as_matrix()
        parent = document.parents().get(node)
        above = np.eye(4) if parent is None else world[parent]
        posed = world[node].copy()
        posed[:3, :3] = turn[:3, :3] @ world[node][:3, :3]
        found[node] = np.asarray(np.linalg.solve(above, posed))
    return found
