"""A tree configuration as plain data (what JSON holds), for editors: read, check, change, write back.

::

    {"format": "mien-tree", "version": 1, "remarks": ["made by hand"], "parameters": [
      {"name": "smile_left", "kind": "translation", "translation": [3, 4, -1],
       "parent": "head", "group": null, "drives": {"mouthSmileLeft": 1}, "limits": [0, 1], "remarks": [],
       "regions": [{"shape": "sphere", "part": null, "centre": [25, -64, 16], "radius": 6, "soft": 18, "weight": 1},
                   {"shape": "weights", "part": "skin", "weights": [[812, 812, 0.5], [813, 820, 1]]}]}]}

``kind`` is ``rotation`` (with ``axis`` and ``pivot``), ``translation`` or ``fixed``; ``group`` is ``skeletal``,
``surface`` or null (parameters with children are skeletal); shapes are ``all``, ``sphere`` (``centre``, ``radius``,
``soft``), ``side`` (``normal``, ``point``, ``soft``) and ``weights`` (runs ``[first, last, weight]``, last included).
A ``part`` of null means every part. Of several regions that name a vertex the last one holds.

`config_data` of `parse_tree` of `data_text` gives the data back as it was; numbers keep their bits. Runs of a list of
weights are written some to a line, and neighbouring lists of one part are read as one list.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from mien.core.errors import InputError
from mien.face.parameter_tree import KINDS, ParameterTree
from mien.face.tree_config import HEADER, TreeConfig, Vertices, check_tree, parse_tree, tree_text
from mien.face.tree_regions import Everywhere, Listed, Region, Side, Sphere, spelt

__all__ = ["TreeFault", "check_data", "config_data", "data_text", "influence_data", "tree_data"]

Data = dict[str, Any]
_FIELDS = {
    "name", "kind", "axis", "pivot", "translation", "parent", "group", "drives", "limits", "regions", "remarks",
}  # fmt: skip
_GROUPS = ("skeletal", "surface")
_SHAPES: dict[str, tuple[str, ...]] = {
    "all": (), "sphere": ("centre", "radius", "soft"), "side": ("normal", "point", "soft"), "weights": ("weights",),
}  # fmt: skip


@dataclass(frozen=True)
class TreeFault:
    """What is wrong with a tree: its line in `data_text`, the parameter (None: the whole), and why."""

    line: int
    parameter: str | None
    text: str


def config_data(config: TreeConfig) -> Data:
    r"""A configuration as plain data.

    Raises
    ------
    InputError
        If lines of it could not be read: data would lose them.

    Examples
    --------
    >>> text = "mien-tree 1\nparameter jaw\n  rotation axis 1 0 0 pivot 0 -20 -60\n  drive jawOpen 24.4\n  all 1\n"
    >>> data = config_data(parse_tree(text))
    >>> data["parameters"][0]["axis"], data["parameters"][0]["drives"]
    ([1.0, 0.0, 0.0], {'jawOpen': 24.4})
    >>> data_text(data) == "mien-tree 1\n\n" + text.partition("\n")[2]
    True
    """
    if config.faults:
        line, text = config.faults[0]
        more = f" (and {len(config.faults) - 1} more)" if len(config.faults) > 1 else ""
        raise InputError(f"{config.source}:{line}: {text}{more}")
    parameters = []
    for draft in config.drafts:
        if not draft.kind:
            raise InputError(
                f"{config.source}:{draft.line}: {draft.name}: needs a line 'rotation', 'translation' or 'fixed'"
            )
        facts: Data = {"name": draft.name, "kind": draft.kind}
        facts |= {"rotation": {"axis": list(draft.vector), "pivot": list(draft.pivot)},
                        "translation": {"translation": list(draft.vector)}, "fixed": {}}[draft.kind]  # fmt: skip
        facts |= {
            "parent": draft.parent,
            "group": draft.group,
            "drives": dict(draft.drives),
            "limits": None if draft.limits is None else list(draft.limits),
            "regions": _joined([_region_data(region, part) for _, part, region in draft.regions]),
            "remarks": list(draft.remarks),
        }
        parameters.append(facts)
    return {"format": "mien-tree", "version": 1, "remarks": list(config.remarks), "parameters": parameters}


def _region_data(region: Region, part: str | None) -> Data:
    if isinstance(region, Listed):
        return {"shape": "weights", "part": part, "weights": [list(run) for run in region.runs]}
    if isinstance(region, Sphere):
        facts: Data = {"centre": list(region.centre), "radius": region.radius, "soft": region.soft}
        return {"shape": "sphere", "part": part, **facts, "weight": region.weight}
    if isinstance(region, Side):
        facts = {"normal": list(region.normal), "point": list(region.point), "soft": region.soft}
        return {"shape": "side", "part": part, **facts, "weight": region.weight}
    if isinstance(region, Everywhere):
        return {"shape": "all", "part": part, "weight": region.weight}
    raise TypeError(f"no data form for {region!r}")


def _joined(regions: Sequence[Data]) -> list[Data]:
    """Neighbouring lists of weights of one part as one: the text breaks them into lines of a readable length."""
    found: list[Data] = []
    for region in regions:
        before = found[-1] if found else None
        if before is not None and region["shape"] == before["shape"] == "weights" and region["part"] == before["part"]:
            before["weights"] += region["weights"]
        else:
            found.append(region)
    return found


def data_text(data: Mapping[str, Any]) -> str:
    """The text of a configuration given as data.

    Raises
    ------
    InputError
        If the data has not the form that this module describes; the message names the place, such as
        ``parameters[3].limits``. What the form allows but no tree may hold (a circle of parents) is `check_data`'s.
    """
    return _written(data)[0]


def _written(data: Mapping[str, Any]) -> tuple[str, list[str | None]]:
    """The text, and for each of its lines the parameter it belongs to."""
    _need(isinstance(data, Mapping), "tree", f"an object, got {type(data).__name__}")
    _need((data.get("format"), data.get("version")) == ("mien-tree", 1), "format", "'mien-tree', version 1")
    _known(data, {"format", "version", "remarks", "parameters"}, "")
    lines: list[str] = [HEADER, *_remarks(data, "remarks", "")]
    owners: list[str | None] = [None] * len(lines)
    for number, parameter in enumerate(_list(data.get("parameters"), "parameters")):
        place = f"parameters[{number}]"
        _need(isinstance(parameter, Mapping), place, f"an object, got {parameter!r}")
        told = ["", *_parameter(parameter, place)]
        lines += told
        owners += [str(parameter["name"])] * len(told)
    return "\n".join(lines) + "\n", owners


def _parameter(facts: Mapping[str, Any], place: str) -> list[str]:
    _known(facts, _FIELDS, f"{place}.")
    lines = [f"parameter {_word(facts.get('name'), f'{place}.name')}", *_remarks(facts, f"{place}.remarks", "  ")]
    kind = facts.get("kind")
    _need(kind in KINDS, f"{place}.kind", f"one of {', '.join(KINDS)}, got {kind!r}")
    if kind == "rotation":
        axis, pivot = _vector(facts.get("axis"), f"{place}.axis"), _vector(facts.get("pivot"), f"{place}.pivot")
        lines.append(f"  rotation axis {axis} pivot {pivot}")
    elif kind == "translation":
        lines.append(f"  translation {_vector(facts.get('translation'), f'{place}.translation')}")
    else:
        lines.append("  fixed")
    if facts.get("parent") is not None:
        lines.append(f"  parent {_word(facts['parent'], f'{place}.parent')}")
    if facts.get("group") is not None:
        _need(facts["group"] in _GROUPS, f"{place}.group", f"'skeletal', 'surface' or null, got {facts['group']!r}")
        lines.append(f"  group {facts['group']}")
    drives = facts.get("drives") or {}
    _need(isinstance(drives, Mapping), f"{place}.drives", f"an object of channel and gain, got {drives!r}")
    for name, gain in drives.items():
        lines.append(f"  drive {_word(name, f'{place}.drives')} {_one(gain, f'{place}.drives.{name}')}")
    if facts.get("limits") is not None:
        lines.append(f"  limits {_vector(facts['limits'], f'{place}.limits', 2)}")
    for number, region in enumerate(_list(facts.get("regions") or [], f"{place}.regions")):
        lines += [f"  {line}" for line in _region(region, f"{place}.regions[{number}]")]
    return lines


def _region(facts: Any, place: str) -> list[str]:
    _need(isinstance(facts, Mapping), place, f"an object, got {facts!r}")
    shape = facts.get("shape")
    _need(shape in _SHAPES, f"{place}.shape", f"one of {', '.join(_SHAPES)}, got {shape!r}")
    weighed = () if shape == "weights" else ("weight",)
    _known(facts, {"shape", "part", *_SHAPES[shape], *weighed}, f"{place}.")
    part = None if facts.get("part") is None else _word(facts["part"], f"{place}.part")

    def number(name: str, otherwise: float | None = None) -> float:
        return float(_one(facts.get(name, otherwise), f"{place}.{name}"))

    def three(name: str) -> tuple[float, float, float]:
        x, y, z = _vector(facts.get(name), f"{place}.{name}").split()
        return float(x), float(y), float(z)

    if shape == "weights":
        _need(part is not None, f"{place}.part", "the name of a part: vertices are numbered part by part")
        return Listed(_runs(facts.get("weights"), f"{place}.weights")).lines(part)
    if shape == "sphere":
        return Sphere(three("centre"), number("radius"), number("soft"), number("weight", 1.0)).lines(part)
    if shape == "side":
        return Side(three("normal"), three("point"), number("soft"), number("weight", 1.0)).lines(part)
    return Everywhere(number("weight", 1.0)).lines(part)


def _runs(given: Any, place: str) -> tuple[tuple[int, int, float], ...]:
    runs = tuple(run for run in map(_run, _list(given, place)) if run is not None)
    if len(runs) < len(given):
        wrong = next(number for number, run in enumerate(given) if _run(run) is None)
        _need(False, f"{place}[{wrong}]", f"[first vertex, last vertex, finite weight], got {given[wrong]!r}")
    _need(bool(runs), place, "at least one run")
    return runs


def _run(run: Any) -> tuple[int, int, float] | None:
    """A run, or None where it is none; a default tree has half a million."""
    if not isinstance(run, Sequence) or len(run) != 3 or not _is_index(run[0]) or not _is_index(run[1]):
        return None
    weight = run[2]
    if not isinstance(weight, int | float) or isinstance(weight, bool) or not math.isfinite(weight):
        return None
    return run[0], run[1], float(weight)


def _is_index(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def _need(holds: bool, place: str, expected: str) -> None:
    if not holds:
        raise InputError(f"tree data: {place}: expected {expected}")


def _known(facts: Mapping[str, Any], names: set[str], place: str) -> None:
    for name in facts:
        _need(name in names, f"{place}{name}", f"no such field; known: {', '.join(sorted(names))}")


def _list(given: Any, place: str) -> Sequence[Any]:
    listed = isinstance(given, Sequence) and not isinstance(given, str)
    _need(listed, place, f"a list, got {type(given).__name__}")
    found: Sequence[Any] = given
    return found


def _remarks(facts: Mapping[str, Any], place: str, indent: str) -> list[str]:
    told = _list(facts.get("remarks") or [], place)
    _need(all(isinstance(line, str) and len(line.splitlines()) <= 1 for line in told), place, "lines of text")
    return [f"{indent}# {line}".rstrip() for line in told]


def _word(given: Any, place: str) -> str:
    plain = isinstance(given, str) and given.split() == [given] and "#" not in given
    _need(plain, place, f"a name without spaces and '#', got {given!r}")
    return str(given)


def _one(given: Any, place: str) -> str:
    plain = isinstance(given, int | float) and not isinstance(given, bool) and math.isfinite(given)
    _need(plain, place, f"a finite number, got {given!r}")
    return spelt(float(given))


def _vector(given: Any, place: str, count: int = 3) -> str:
    numbers = _list(given, place)
    _need(len(numbers) == count, place, f"{count} numbers, got {len(numbers)}")
    return " ".join(_one(number, place) for number in numbers)


def check_data(data: Mapping[str, Any], vertices: Vertices | None = None) -> list[TreeFault]:
    """Every fault of a tree given as data, by its line in `data_text` and its parameter.

    Parameters
    ----------
    data : mapping
    vertices : mapping of str to ndarray, shape (n, 3), optional
        A mesh at rest, by name of the part: then vertices and parts are checked too.

    Raises
    ------
    InputError
        As `data_text`.
    """
    text, owners = _written(data)
    found = check_tree(parse_tree(text), vertices)
    return [TreeFault(line, owners[line - 1] if line <= len(owners) else None, fault) for line, fault in found]


def tree_data(tree: ParameterTree, about: str = "") -> Data:
    """A tree as plain data; weights are listed by vertex, with four decimals."""
    return config_data(parse_tree(tree_text(tree, about)))


def influence_data(tree: ParameterTree) -> dict[str, dict[str, Data]]:
    """What every parameter moves, as numbers: parameter -> part -> ``{"vertices": [...], "weights": [...]}``.

    The shapes of a configuration are worked out on its mesh here; group 1 is *not* normalised yet.
    """
    return {
        parameter.name: {
            part: {"vertices": influence.vertices.tolist(), "weights": influence.weights.tolist()}
            for part, influence in parameter.influences.items()
        }
        for parameter in tree.parameters
    }
