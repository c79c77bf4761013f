"""Parameter trees as plain text: one statement a line, ``#`` starts a remark (``docs/rig.md`` describes the format).

::

    mien-tree 1
    parameter head
      rotation axis 0 1 0 pivot 0 -90 -40      # degrees, right-handed
      group skeletal
      drive headYaw 1
      limits -60 60
      all 1
    parameter smile_left
      translation 3 4 -1                       # mm at value 1
      parent head
      drive mouthSmileLeft 1
      sphere 25 -64 16 radius 6 soft 18
      weights skin 812:0.5 813-820:1

Regions are given by vertex numbers (from 0) or by simple shapes; where several lines of a parameter name a vertex, the
last one holds. Every fault is told with its line.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.core.border import guarded
from mien.core.errors import InputError
from mien.core.files import replace_when_complete
from mien.core.plain_text import read_plain_text
from mien.face.parameter_tree import Influence, Parameter, ParameterTree, tree_faults
from mien.face.tree_regions import REGIONS, Listed, Region, read_number, read_three

__all__ = ["TreeConfig", "check_tree", "parse_tree", "read_tree", "tree_text", "write_tree"]

HEADER = "mien-tree 1"
_SMALLEST_WEIGHT = 5e-4
_PER_LINE = 12
_MOST_FAULTS = 20

Vertices = Mapping[str, NDArray[np.floating]]


@dataclass
class _Draft:
    """A parameter while its lines are read."""

    name: str
    line: int
    kind: str = ""
    vector: tuple[float, float, float] = (0.0, 0.0, 0.0)
    pivot: tuple[float, float, float] = (0.0, 0.0, 0.0)
    parent: str | None = None
    group: str | None = None
    drives: dict[str, float] = field(default_factory=dict)
    limits: tuple[float, float] | None = None
    regions: list[tuple[int, str | None, Region]] = field(default_factory=list)  # line, part or all, region
    broken: bool = False  # a line of it could not be read: what that leads to is not told besides
    remarks: list[str] = field(default_factory=list)


@dataclass
class TreeConfig:
    """A configuration as read, before it meets a mesh.

    Attributes
    ----------
    source : str
        What to call it in messages.
    drafts : list
        Parameters as their lines say them; `mien.face.tree_data` gives them as plain data.
    faults : list of (int, str)
        Line and what is wrong there.
    remarks : list of str
        What stood behind ``#`` before the first parameter.
    """

    source: str
    drafts: list[_Draft] = field(default_factory=list)
    faults: list[tuple[int, str]] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def on(self, vertices: Vertices, literal: bool = False) -> ParameterTree:
        """The tree on a mesh.

        Parameters
        ----------
        vertices : mapping of str to ndarray, shape (n, 3)
            At rest, by name of the part.
        literal : bool
            As for `ParameterTree`.

        Raises
        ------
        InputError
            With every fault and its line.
        """
        parameters, faults = self._parameters(vertices)
        faults = sorted(self.faults + faults)
        if faults:
            told = "; ".join(f"{self.source}:{line}: {text}" for line, text in faults[:_MOST_FAULTS])
            more = f"; and {len(faults) - _MOST_FAULTS} more" if len(faults) > _MOST_FAULTS else ""
            raise InputError(told + more)
        return ParameterTree(parameters, literal)

    def _parameters(self, vertices: Vertices) -> tuple[list[Parameter], list[tuple[int, str]]]:
        parents = {draft.parent for draft in self.drafts}
        parameters, faults = [], []
        for draft in self.drafts:
            if not draft.kind and not draft.broken:
                faults.append((draft.line, f"{draft.name}: needs a line 'rotation', 'translation' or 'fixed'"))
            skeletal = draft.name in parents if draft.group is None else draft.group == "skeletal"
            influences = _influences(draft, vertices, faults)
            parameters.append(
                Parameter(
                    draft.name, draft.kind or "fixed", draft.vector, draft.pivot, draft.parent, skeletal, draft.drives,
                    draft.limits, influences,
                )
            )  # fmt: skip
        lines = {draft.name: draft.line for draft in self.drafts}
        broken = {draft.name for draft in self.drafts if draft.broken}
        faults += [(lines[name], text) for name, text in tree_faults(parameters) if name not in broken]
        return parameters, faults


def _influences(draft: _Draft, vertices: Vertices, faults: list[tuple[int, str]]) -> dict[str, Influence]:
    dense: dict[str, NDArray[np.float64]] = {}
    for line, part, region in draft.regions:
        if part is not None and part not in vertices:
            faults.append((line, f"{draft.name}: the mesh has no part {part!r}; it has {', '.join(sorted(vertices))}"))
            continue
        for name in [part] if part is not None else vertices:
            try:
                chosen, weights = region.on(name, vertices[name])
            except ValueError as problem:
                faults.append((line, f"{draft.name}: {problem}"))
                break
            held = dense.setdefault(name, np.zeros(len(vertices[name])))
            held[chosen] = weights
    found = {}
    for name, weights in dense.items():
        moved = np.flatnonzero(np.abs(weights) > _SMALLEST_WEIGHT)
        if len(moved):
            found[name] = Influence(moved.astype(np.int32), weights[moved].astype(np.float32))
    return found


@guarded("a parameter tree")
def read_tree(path: str | Path) -> TreeConfig:
    """Read a configuration; faults of single lines are collected in `TreeConfig.faults`.

    Raises
    ------
    InputError
        If the file cannot be read or is no tree configuration at all.
    """
    return parse_tree(read_plain_text(path, "a parameter tree")[0], str(path))


def parse_tree(text: str, source: str = "tree") -> TreeConfig:
    r"""Read a configuration from its text; faults of single lines are collected in `TreeConfig.faults`.

    Parameters
    ----------
    text : str
    source : str
        What to call it in messages.

    Raises
    ------
    InputError
        If it is no tree configuration at all.

    Examples
    --------
    >>> parse_tree("mien-tree 1\nparameter jaw\nrotation axis 1 0 pivot 0 0 0").faults
    [(3, "expected 'rotation axis X Y Z pivot X Y Z'")]
    """
    config, begun = TreeConfig(source), False
    for number, line in enumerate(text.splitlines(), 1):
        statement, mark, remark = line.partition("#")
        words = statement.split()
        if words and not begun:
            if " ".join(words) != HEADER:
                raise InputError(f"{source}:{number}: expected {HEADER!r} as the first line of a parameter tree")
            begun = True
        elif words:
            try:
                _statement(config, number, words)
            except ValueError as problem:
                config.faults.append((number, str(problem)))
                if config.drafts:
                    config.drafts[-1].broken = True
        if mark:
            (config.drafts[-1] if config.drafts else config).remarks.append(remark.strip())
    if not begun:
        raise InputError(f"{source}: expected {HEADER!r} as the first line of a parameter tree")
    return config


def _statement(config: TreeConfig, line: int, words: Sequence[str]) -> None:
    keyword, rest = words[0], list(words[1:])
    if keyword == "parameter":
        if len(rest) != 1:
            raise ValueError(f"expected 'parameter NAME', got {' '.join(words)!r}")
        config.drafts.append(_Draft(rest[0], line))
        return
    if not config.drafts:
        raise ValueError(f"{keyword!r} comes before the first 'parameter'")
    draft = config.drafts[-1]
    if keyword in _SETTERS:
        _SETTERS[keyword](draft, rest)
    elif keyword in REGIONS:
        part = rest.pop(0)[5:] if rest and rest[0].startswith("part:") else None
        draft.regions.append((line, part, REGIONS[keyword](rest)))
    elif keyword == "weights":
        if len(rest) < 2:
            raise ValueError("expected 'weights PART VERTEX:WEIGHT ...'")
        draft.regions.append((line, rest[0], Listed.read(rest[1:])))
    else:
        known = ", ".join(("parameter", *_SETTERS, *REGIONS, "weights"))
        raise ValueError(f"unknown statement {keyword!r}; known: {known}")


def _settled(draft: _Draft, kind: str) -> None:
    if draft.kind:
        raise ValueError(f"{draft.name} is a {draft.kind} already")
    draft.kind = kind


def _rotation(draft: _Draft, words: list[str]) -> None:
    if len(words) != 8 or words[0] != "axis" or words[4] != "pivot":
        raise ValueError("expected 'rotation axis X Y Z pivot X Y Z'")
    _settled(draft, "rotation")
    draft.vector, draft.pivot = read_three(words[1:4], "an axis"), read_three(words[5:8], "a pivot")


def _translation(draft: _Draft, words: list[str]) -> None:
    _settled(draft, "translation")
    draft.vector = read_three(words, "a translation")


def _fixed(draft: _Draft, words: list[str]) -> None:
    if words:
        raise ValueError("'fixed' stands alone")
    _settled(draft, "fixed")


def _parent(draft: _Draft, words: list[str]) -> None:
    if len(words) != 1:
        raise ValueError("expected 'parent NAME' or 'parent none'")
    draft.parent = None if words[0] == "none" else words[0]


def _group(draft: _Draft, words: list[str]) -> None:
    if words not in (["skeletal"], ["surface"]):
        raise ValueError("expected 'group skeletal' or 'group surface'")
    draft.group = words[0]


def _drive(draft: _Draft, words: list[str]) -> None:
    if len(words) != 2:
        raise ValueError("expected 'drive CHANNEL GAIN'")
    if words[0] in draft.drives:
        raise ValueError(f"{words[0]} drives {draft.name} already")
    draft.drives[words[0]] = read_number(words[1])


def _limits(draft: _Draft, words: list[str]) -> None:
    if len(words) != 2:
        raise ValueError("expected 'limits LOWEST HIGHEST'")
    draft.limits = read_number(words[0]), read_number(words[1])


_SETTERS: dict[str, Callable[[_Draft, list[str]], None]] = {
    "rotation": _rotation, "translation": _translation, "fixed": _fixed, "parent": _parent, "group": _group,
    "drive": _drive, "limits": _limits,
}  # fmt: skip


def check_tree(config: TreeConfig, vertices: Vertices | None) -> list[tuple[int, str]]:
    """Every fault of a configuration with its line; on a mesh, faults of vertices and parts too."""
    if vertices is None:
        bare = TreeConfig(config.source, [_without_regions(draft) for draft in config.drafts])
        return sorted(config.faults + bare._parameters({})[1])
    return sorted(config.faults + config._parameters(vertices)[1])


def _without_regions(draft: _Draft) -> _Draft:
    return _Draft(**{**vars(draft), "regions": []})


def tree_text(tree: ParameterTree, about: str = "") -> str:
    """A tree as the text of a configuration; weights are listed by vertex, with four decimals."""
    lines = [HEADER, *(f"# {line}" for line in about.splitlines())]
    for parameter in tree.parameters:
        lines += ["", *_parameter_lines(parameter)]
    return "\n".join(lines) + "\n"


def _parameter_lines(parameter: Parameter) -> list[str]:
    def spelt(numbers: Sequence[float]) -> str:
        return " ".join(f"{number:.9g}" for number in numbers)

    lines = [f"parameter {parameter.name}"]
    if parameter.kind == "rotation":
        lines.append(f"  rotation axis {spelt(parameter.vector)} pivot {spelt(parameter.pivot)}")
    elif parameter.kind == "translation":
        lines.append(f"  translation {spelt(parameter.vector)}")
    else:
        lines.append("  fixed")
    if parameter.parent is not None:
        lines.append(f"  parent {parameter.parent}")
    lines.append(f"  group {'skeletal' if parameter.skeletal else 'surface'}")
    lines += [f"  drive {name} {gain:.9g}" for name, gain in parameter.drives.items()]
    if parameter.limits is not None:
        lines.append(f"  limits {spelt(parameter.limits)}")
    for part, influence in parameter.influences.items():
        entries = _runs(influence)
        lines += [f"  weights {part} {' '.join(entries[i : i + _PER_LINE])}" for i in range(0, len(entries), _PER_LINE)]
    return lines


def _runs(influence: Influence) -> list[str]:
    """Neighbouring vertices of one weight as a range."""
    order = np.argsort(influence.vertices, kind="stable")
    vertices, weights = influence.vertices[order], np.round(influence.weights[order].astype(np.float64), 4)
    if not len(vertices):
        return []
    breaks = np.flatnonzero((np.diff(vertices) != 1) | (np.diff(weights) != 0)) + 1
    spans = zip(np.r_[0, breaks], np.r_[breaks, len(vertices)], strict=True)
    return [
        f"{vertices[a]}{f'-{vertices[b - 1]}' if b - a > 1 else ''}:{weights[a]:g}" for a, b in spans if weights[a] != 0
    ]


def write_tree(tree: ParameterTree, path: str | Path, about: str = "") -> None:
    """Write a tree as a configuration file.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    with replace_when_complete(path) as unfinished:
        unfinished.write_text(tree_text(tree, about), encoding="utf-8", newline="\n")
