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

from mien.errors import InputError
from mien.face.parameter_tree import Influence, Parameter, ParameterTree, tree_faults
from mien.files import replace_when_complete

__all__ = ["TreeConfig", "check_tree", "read_tree", "tree_text", "write_tree"]

HEADER = "mien-tree 1"
_SMALLEST_WEIGHT = 5e-4
_PER_LINE = 12
_MOST_FAULTS = 20

Vertices = Mapping[str, NDArray[np.floating]]
Region = Callable[[str, NDArray[np.floating]], tuple[NDArray[np.int64], NDArray[np.float64]]]


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


@dataclass
class TreeConfig:
    """A configuration as read, before it meets a mesh.

    Attributes
    ----------
    source : str
        What to call it in messages.
    faults : list of (int, str)
        Line and what is wrong there.
    """

    source: str
    drafts: list[_Draft] = field(default_factory=list)
    faults: list[tuple[int, str]] = field(default_factory=list)

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
                chosen, weights = region(name, vertices[name])
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


def read_tree(path: str | Path) -> TreeConfig:
    """Read a configuration; faults of single lines are collected in `TreeConfig.faults`.

    Raises
    ------
    InputError
        If the file cannot be read or is no tree configuration at all.
    """
    path = Path(path)
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except UnicodeDecodeError as problem:
        raise InputError(f"{path}: expected UTF-8 text, got other bytes at byte {problem.start}") from problem
    except OSError as problem:
        raise InputError(f"{path}: cannot be read ({problem.strerror})") from problem
    told = [(number, line.split("#", 1)[0].split()) for number, line in enumerate(lines, 1)]
    told = [(number, words) for number, words in told if words]
    if not told or " ".join(told[0][1]) != HEADER:
        first = f"{path}:{told[0][0]}" if told else f"{path}"
        raise InputError(f"{first}: expected {HEADER!r} as the first line of a parameter tree")
    config = TreeConfig(str(path))
    for number, words in told[1:]:
        try:
            _statement(config, number, words)
        except ValueError as problem:
            config.faults.append((number, str(problem)))
            if config.drafts:
                config.drafts[-1].broken = True
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
    elif keyword in _REGIONS:
        part = rest.pop(0)[5:] if rest and rest[0].startswith("part:") else None
        draft.regions.append((line, part, _REGIONS[keyword](rest)))
    elif keyword == "weights":
        if len(rest) < 2:
            raise ValueError("expected 'weights PART VERTEX:WEIGHT ...'")
        draft.regions.append((line, rest[0], _listed(rest[1:])))
    else:
        known = ", ".join(("parameter", *_SETTERS, *_REGIONS, "weights"))
        raise ValueError(f"unknown statement {keyword!r}; known: {known}")


def _number(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        raise ValueError(f"expected a number, got {text!r}") from None
    if not np.isfinite(number):
        raise ValueError(f"expected a finite number, got {text!r}")
    return number


def _three(words: Sequence[str], what: str) -> tuple[float, float, float]:
    if len(words) != 3:
        raise ValueError(f"{what} has three numbers, got {len(words)}")
    return _number(words[0]), _number(words[1]), _number(words[2])


def _settled(draft: _Draft, kind: str) -> None:
    if draft.kind:
        raise ValueError(f"{draft.name} is a {draft.kind} already")
    draft.kind = kind


def _rotation(draft: _Draft, words: list[str]) -> None:
    if len(words) != 8 or words[0] != "axis" or words[4] != "pivot":
        raise ValueError("expected 'rotation axis X Y Z pivot X Y Z'")
    _settled(draft, "rotation")
    draft.vector, draft.pivot = _three(words[1:4], "an axis"), _three(words[5:8], "a pivot")


def _translation(draft: _Draft, words: list[str]) -> None:
    _settled(draft, "translation")
    draft.vector = _three(words, "a translation")


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
    draft.drives[words[0]] = _number(words[1])


def _limits(draft: _Draft, words: list[str]) -> None:
    if len(words) != 2:
        raise ValueError("expected 'limits LOWEST HIGHEST'")
    draft.limits = _number(words[0]), _number(words[1])


_SETTERS: dict[str, Callable[[_Draft, list[str]], None]] = {
    "rotation": _rotation, "translation": _translation, "fixed": _fixed, "parent": _parent, "group": _group,
    "drive": _drive, "limits": _limits,
}  # fmt: skip


def _listed(words: Sequence[str]) -> Region:
    """``VERTEX:WEIGHT`` and ``FIRST-LAST:WEIGHT``."""
    chosen: list[int] = []
    weights: list[float] = []
    for word in words:
        places, colon, weight = word.partition(":")
        first, dash, last = places.partition("-")
        if not colon or not first.isdecimal() or (dash and not last.isdecimal()):
            raise ValueError(f"expected VERTEX:WEIGHT or FIRST-LAST:WEIGHT, got {word!r}")
        span = range(int(first), int(last or first) + 1)
        if not len(span):
            raise ValueError(f"{word!r} runs backwards")
        if len(span) > 10**7:
            raise ValueError(f"{word!r} names more vertices than any mesh has")
        chosen += span
        weights += [_number(weight)] * len(span)

    def region(part: str, vertices: NDArray[np.floating]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        if max(chosen) >= len(vertices):
            raise ValueError(f"vertex {max(chosen)} is beyond the {len(vertices)} of part {part!r}")
        return np.array(chosen, dtype=np.int64), np.array(weights)

    return region


def _everywhere(words: list[str]) -> Region:
    """``all WEIGHT``."""
    if len(words) != 1:
        raise ValueError("expected 'all WEIGHT'")
    weight = _number(words[0])
    return lambda part, vertices: (np.arange(len(vertices)), np.full(len(vertices), weight))


def _sphere(words: list[str]) -> Region:
    """``sphere X Y Z radius R soft S [weight W]``: W inside, smoothly 0 at R + S."""
    if len(words) not in (7, 9) or words[3] != "radius" or words[5] != "soft" or words[7:8] not in ([], ["weight"]):
        raise ValueError("expected 'sphere X Y Z radius R soft S' and, if wanted, 'weight W'")
    centre, radius, soft = np.array(_three(words[:3], "a centre")), _number(words[4]), _number(words[6])
    weight = _number(words[8]) if len(words) == 9 else 1.0
    if radius < 0 or soft < 0:
        raise ValueError("a radius and a soft edge are not negative")
    return lambda part, vertices: _faded(np.linalg.norm(vertices - centre, axis=1) - radius, soft, weight)


def _halfspace(words: list[str]) -> Region:
    """``side NX NY NZ of X Y Z soft S [weight W]``: W where the normal points, smoothly 0 at S before."""
    if len(words) not in (9, 11) or words[3] != "of" or words[7] != "soft" or words[9:10] not in ([], ["weight"]):
        raise ValueError("expected 'side NX NY NZ of X Y Z soft S' and, if wanted, 'weight W'")
    normal, point = np.array(_three(words[:3], "a normal")), np.array(_three(words[4:7], "a point"))
    soft, weight = _number(words[8]), _number(words[10]) if len(words) == 11 else 1.0
    if not normal.any():
        raise ValueError("the normal has no length")
    unit = normal / np.linalg.norm(normal)
    return lambda part, vertices: _faded(-((vertices - point) @ unit), soft, weight)


def _faded(outside: NDArray[np.floating], soft: float, weight: float) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    share = np.clip(1 - outside / max(soft, 1e-9), 0, 1)
    chosen = np.flatnonzero(share > 0)
    return chosen, weight * (share * share * (3 - 2 * share))[chosen]


_REGIONS: dict[str, Callable[[list[str]], Region]] = {"all": _everywhere, "sphere": _sphere, "side": _halfspace}


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
