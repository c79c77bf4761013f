"""What mien makes of a foreign face: what moves by what, what is missing and what that costs, what stays still."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

from mien.core.assets import asset_table
from mien.face.foreign.drawn import not_drawn
from mien.face.foreign.gltf_document import GltfDocument
from mien.face.foreign.known_face import FEWEST, LEAST_MOUTH, Reach, all_targets, known_face, mouth_share, reach
from mien.face.foreign.recognition import EMPTY, UNKNOWN, UNNAMED, DrivenTarget, ForeignFace
from mien.face.foreign.rig_names import OwnNames
from mien.face.foreign.rig_nodes import PARTS, lowered_arms
from mien.face.foreign.target_geometry import Likeness, likenesses
from mien.face.foreign.vrm import is_vrm, vrm_painted, vrm_springs

__all__ = [
    "FaceReport", "MeshReport", "MissingChannels", "TargetReport", "face_report", "inspect_face", "names_table",
]  # fmt: skip

_TURNING = {**PARTS, "neck": "neck", "jaw": "jaw", "armLeft": "left arm", "armRight": "right arm"}
_MOST_EMPTY = 4  # names of empty targets that are told one by one
_LYING = 0.25
"""A target that moves less like the channel of its name than this cosine, and surely like another, lies."""


@dataclass(frozen=True)
class TargetReport:
    """One morph target.

    Attributes
    ----------
    name : str
        "" where the file has none.
    driven_by : dict of str to float
        Channels and their weights; empty where it stays still.
    convention : str
        Title of the table that knows it; "" if none does.
    expression : str
        The VRM expression through which it is driven; "" if by its own name.
    still : str
        Why it stays still; "" where it moves.
    """

    name: str
    driven_by: dict[str, float]
    convention: str
    expression: str
    still: str


@dataclass(frozen=True)
class MeshReport:
    """One mesh that has morph targets."""

    name: str
    conventions: tuple[str, ...]
    targets: tuple[TargetReport, ...]

    @property
    def driven(self) -> tuple[TargetReport, ...]:
        """The targets that move."""
        return tuple(target for target in self.targets if target.driven_by)


@dataclass(frozen=True)
class MissingChannels:
    """Channels that move nothing, how much that matters ("speech", "expression" or "detail"), and what it costs."""

    channels: tuple[str, ...]
    weight: str
    words: str


@dataclass(frozen=True)
class FaceReport:
    """What mien makes of a face.

    Attributes
    ----------
    path : str
    generator : str
        The program that wrote the file, as it says.
    kind : str
        ``"VRM 0"``, ``"VRM 1"`` or ``"glTF"``.
    moves : bool
        Whether the face can be driven at all.
    conventions : tuple of str
        Titles of all tables that drive something, most used first.
    meshes : tuple of MeshReport
    nodes : dict of str to str
        Names of the nodes that turn: ``head``, ``eyeLeft``, ``eyeRight``.
    still_nodes : tuple of str
        Those of them that there are not, in words.
    shaped_nodes : tuple of str
        Eyes that shapes of their own turn, so that their nodes keep still.
    missing : tuple of MissingChannels
        What matters most comes first.
    extensions : tuple of str
        All that the file uses; they are kept.
    animations : int
        How many it has of its own; they are kept.
    not_drawn : str
        Why it cannot be drawn to ``.mp4`` and ``.png``; "" if it can.
    mouth : float
        Share of the mouth's motion in speech that can be shown, 0..1.
    reach : Reach or None
        How far it goes; None if its meshes cannot be decoded.
    proposals : dict of str to str
        Targets without a known name that are left still, and what they move like.
    lying : dict of str to str
        Targets that move like something other than their names say.
    painted : tuple of str
        VRM expressions that move textures or colours, which is not followed.
    springs : int
        Chains of VRM's spring bones: kept in the file, drawn still.
    """

    path: str
    generator: str
    kind: str
    moves: bool
    conventions: tuple[str, ...]
    meshes: tuple[MeshReport, ...]
    nodes: dict[str, str]
    still_nodes: tuple[str, ...]
    shaped_nodes: tuple[str, ...]
    missing: tuple[MissingChannels, ...]
    extensions: tuple[str, ...]
    animations: int
    not_drawn: str
    mouth: float
    reach: Reach | None
    proposals: dict[str, str]
    lying: dict[str, str]
    painted: tuple[str, ...] = ()
    springs: int = 0

    def as_dict(self) -> dict[str, Any]:
        """The same in plain lists and dicts, ready for JSON."""
        return asdict(self)

    def verdict(self) -> str:
        """What will move, in one line."""
        if not self.moves:
            return "nothing of this face can move"
        parts = [f"{self.mouth:.0%} of the mouth's motion in speech can be shown"]
        if self.reach is not None:
            parts.append(f"lips part by {self.reach.opening:.0f} mm at full jaw")
            parts.append(f"blinks close the eyes by about {self.reach.closing:.0%}")
        unknown = [t for mesh in self.meshes for t in mesh.targets if t.still in (UNKNOWN, UNNAMED)]
        if unknown:
            parts.append(f"targets that are not known: {len(unknown)} of {sum(len(m.targets) for m in self.meshes)}")
        weak = self.mouth < LEAST_MOUTH or (self.reach is not None and self.reach.opening < 4.0)
        return f"{'weak' if weak else 'good'} for speech: {', '.join(parts)}"

    def lines(self) -> list[str]:
        """The same in words."""
        told = [
            self.verdict(),
            f"{self.path}: {self.kind}" + (f", written by {self.generator}" if self.generator else ""),
        ]
        if not self.meshes:
            told.append("no mesh has morph targets" + ("" if self.moves else ": nothing could move"))
        elif all(target.still == EMPTY for mesh in self.meshes for target in mesh.targets):
            told.append("all its morph targets are empty: nothing could move")
        elif not self.moves:
            told.append("no morph target has a known name: nothing could move; give a table of your own with --names")
        else:
            told.append(f"names: {', '.join(self.conventions)}")
        for mesh in self.meshes:
            told.append(f"{mesh.name}: {len(mesh.driven)} of {len(mesh.targets)} targets are driven")
            plain = [target.name for target in mesh.driven if list(target.driven_by.items()) == [(target.name, 1.0)]]
            if plain:
                told.append(f"  by the channel of the same name: {', '.join(plain)}")
            for target in mesh.driven:
                if target.name in plain:
                    continue
                sums = " ".join(f"{weight:+g} {channel}" for channel, weight in target.driven_by.items())
                by = f" (expression {target.expression!r})" if target.expression else ""
                told.append(f"  {target.name or '(no name)'} <- {sums}{by}")
            still = [target for target in mesh.targets if not target.driven_by]
            for reason in dict.fromkeys(target.still for target in still):
                names = [target.name or "(no name)" for target in still if target.still == reason]
                if reason == EMPTY and len(names) > _MOST_EMPTY:
                    names[_MOST_EMPTY - 1 :] = [f"and {len(names) - _MOST_EMPTY + 1} more"]
                told.append(f"  still, {reason}: {', '.join(names)}")
        told += [f"{name}: its name is not what it moves: {like}" for name, like in self.lying.items()]
        told += [f"{name}: left still, it moves like {like}" for name, like in self.proposals.items()]
        told += [
            f"{_TURNING[part]}: node {name!r} {'is lowered' if part.startswith('arm') else 'turns'}"
            for part, name in self.nodes.items()
        ]
        told += [f"{part}: no node of such a name; it stays still" for part in self.still_nodes]
        told += [f"{part}: turned by its mesh's own shapes, not by its node" for part in self.shaped_nodes]
        if any("viseme" in title or "vowel" in title or "mouths" in title for title in self.conventions):
            told.append("its visemes stand in for much of the speech shapes that it lacks:")
        told += [f"no {', '.join(lost.channels)} ({lost.weight}): {lost.words}" for lost in self.missing]
        if self.painted:
            told.append(f"expressions that move textures or colours, not followed: {', '.join(self.painted)}")
        if self.springs:
            told.append(
                f"spring bones (hair, clothes): {self.springs} chains, kept for players that swing them; drawn still"
            )
        if self.animations:
            told.append(f"it has {self.animations} animation(s) of its own; they are kept, the performance comes first")
        told.append(f"drawing (.mp4, .png): {self.not_drawn or 'yes'}")
        return told


@cache
def _costs() -> tuple[MissingChannels, ...]:
    costs = [
        MissingChannels(tuple(c["channels"]), c["weight"], c["words"]) for c in asset_table("rigs/costs.toml")["cost"]
    ]
    return tuple(sorted(costs, key=lambda cost: ("speech", "expression", "detail").index(cost.weight)))


def inspect_face(source: str | Path | GltfDocument, names: OwnNames | str | Path | None = None) -> FaceReport:
    """Read a face in a ``.glb``, ``.vrm`` or ``.gltf`` file and say what mien makes of it.

    Parameters
    ----------
    source : path-like or GltfDocument
    names : OwnNames or path-like, optional
        A table of the user's own (``docs/faces.md``).

    Raises
    ------
    InputError
        If a file cannot be read or does not hold together.
    """
    return face_report(known_face(source, names))


def face_report(face: ForeignFace) -> FaceReport:
    """Say what mien makes of a face that is recognised already."""
    document = face.document
    meshes = tuple(_mesh(face, number) for number, mesh in enumerate(face.meshes) if mesh.targets)
    tables = [target.convention for mesh in meshes for target in mesh.driven]
    moved = {c for mesh in meshes for target in mesh.driven for c, w in target.driven_by.items() if w > 0}
    moved |= {"jawOpen", "jawLeft", "jawRight"} if face.jaw_turns else set()
    lowered = lowered_arms(document, face.turning.nodes) if face.arms else {}
    nodes = {
        part: str(document.list_of("nodes")[node].get("name", ""))
        for part, node in face.turning.nodes.items()
        if part in PARTS or part == "neck" or (part == "jaw" and face.jaw_turns) or node in lowered
    }
    asset = document.json.get("asset")
    version = is_vrm(document)
    likely, far = _by_motion(face)
    return FaceReport(
        path=str(document.path),
        generator=str(asset.get("generator", "")) if isinstance(asset, dict) else "",
        kind="glTF" if version is None else f"VRM {version}",
        moves=face.moves,
        conventions=tuple(sorted(dict.fromkeys(tables), key=lambda title: -tables.count(title))),
        meshes=meshes,
        nodes=nodes,
        still_nodes=tuple(t for part, t in PARTS.items() if part not in nodes and part not in face.turning.by_shapes),
        shaped_nodes=tuple(PARTS[part] for part in face.turning.by_shapes),
        missing=_missing(moved),
        extensions=tuple(str(name) for name in document.list_of("extensionsUsed")),
        animations=len(document.list_of("animations")),
        not_drawn=not_drawn(face),
        mouth=round(mouth_share(face), 3),
        reach=far,
        proposals={_name(face, key): _like(likeness) for key, likeness in face.proposals.items()},
        lying=_lying(face, likely),
        painted=vrm_painted(document),
        springs=vrm_springs(document),
    )


def _by_motion(face: ForeignFace) -> tuple[dict[str, Likeness], Reach | None]:
    """What every target moves like, and how far the face goes."""
    every = all_targets(face)
    if every is None or len({name for part in every.parts for name in part.targets}) < FEWEST:
        return {}, None
    likely, registration = likenesses(every)
    return likely, reach(face, registration)


def _name(face: ForeignFace, key: str) -> str:
    mesh, place = map(int, key.split("/"))
    return face.meshes[mesh].targets[place].name or f"target {place} of {face.meshes[mesh].name}"


def _like(likeness: Likeness) -> str:
    return f"{' and '.join(likeness.recipe)} ({likeness.cosine:.2f}{'' if likeness.sure else ', not sure'})"


def _lying(face: ForeignFace, likely: dict[str, Likeness]) -> dict[str, str]:
    """Shapes whose names say one channel while they surely move like another."""
    found = {}
    for mesh in face.meshes:
        for place, target in enumerate(mesh.targets):
            likeness = likely.get(f"{mesh.number}/{place}")
            named = {c for d in target.drives if d.match.kind == "shapes" for c in d.match.recipe}
            if not named or likeness is None or not likeness.sure or named & set(likeness.recipe):
                continue
            if all(likeness.others.get(channel, 1.0) < _LYING for channel in named):  # (1: nothing to compare with)
                found[target.name] = f"it moves like {_like(likeness)}"
    return found


def names_table(face: ForeignFace) -> str:
    """A table of names to correct, as ``--names`` takes it: what is driven, and proposals as comments."""
    head = "# Which channels drive which target (docs/faces.md). Correct it, then give it with --names."
    lines = [head, "[targets]"]
    for mesh in face.meshes:
        for place, target in enumerate(mesh.targets):
            if target.name:
                lines.append(_names_line(target, face.proposals.get(f"{mesh.number}/{place}")))
    return "\n".join(dict.fromkeys(lines)) + "\n"


def _names_line(target: DrivenTarget, proposed: Likeness | None) -> str:
    recipe: dict[str, float] = {}
    for drive in target.drives:
        for channel, weight in drive.match.recipe.items():
            recipe[channel] = round(recipe.get(channel, 0.0) + weight * drive.share, 3)
    name = json.dumps(target.name, ensure_ascii=False)
    given = recipe or (dict(proposed.recipe) if proposed else {})
    inside = ", ".join(f"{channel} = {weight:g}" for channel, weight in given.items())
    if recipe:
        return f"{name} = {{ {inside} }}"
    return f"# {name} = {{ {inside} }}  # it moves like this" if given else f'# {name} = ""  # {target.still}'


def _missing(moved: set[str]) -> tuple[MissingChannels, ...]:
    lost = []
    for cost in _costs():
        channels = tuple(name for name in cost.channels if name not in moved)
        if channels:
            lost.append(MissingChannels(channels, cost.weight, cost.words))
    return tuple(lost)


def _mesh(face: ForeignFace, number: int) -> MeshReport:
    mesh = face.meshes[number]
    targets = []
    for target in mesh.targets:
        driven: dict[str, float] = {}
        for drive in target.drives:
            for channel, weight in drive.match.recipe.items():
                driven[channel] = round(driven.get(channel, 0.0) + weight * drive.share, 6)
        tables = ", ".join(dict.fromkeys(drive.match.convention for drive in target.drives))
        expressions = ", ".join(dict.fromkeys(drive.name for drive in target.drives if drive.name))
        targets.append(TargetReport(target.name, driven, tables, expressions, target.still))
    used = [target.convention for target in targets if target.driven_by]
    return MeshReport(mesh.name, tuple(dict.fromkeys(used)), tuple(targets))
