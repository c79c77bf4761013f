"""What a parameter tree does on a face, in words."""

from __future__ import annotations

import numpy as np

from mien.core.channels import ALL
from mien.core.facs import is_unit
from mien.face.model import Face
from mien.face.parameter_tree import ParameterTree

__all__ = ["tree_report"]

_UNEVEN = 0.01


def tree_report(tree: ParameterTree, face: Face) -> str:
    """One line per parameter, its children set in; then what is claimed and what drives nothing we know.

    Examples
    --------
    >>> from mien.face.library import load_face
    >>> from mien.face.tree_of_face import tree_of_face
    >>> face = load_face("default")
    >>> tree_report(tree_of_face(face), face).splitlines()[0]
    'trunk                 fixed        skeletal   11889 vertices  -'
    """
    children: dict[str | None, list[int]] = {}
    for number, parameter in enumerate(tree.parameters):
        children.setdefault(parameter.parent, []).append(number)
    lines: list[str] = []

    def tell(parent: str | None, depth: int) -> None:
        for number in children.get(parent, []):
            parameter = tree.parameters[number]
            moved = sum(len(influence.vertices) for influence in parameter.influences.values())
            group = "skeletal" if parameter.skeletal else "surface"
            drives = ", ".join(parameter.drives) or "-"
            label = "  " * depth + parameter.name
            lines.append(f"{label:<21} {parameter.kind:<12} {group:<8} {moved:>7} vertices  {drives}")
            tell(parameter.name, depth + 1)

    tell(None, 0)
    total = sum(len(part.vertices) for part in face.parts)
    claimed = sum(
        int(np.count_nonzero(tree.skeletal_weights(part.name, len(part.vertices)).sum(axis=0))) for part in face.parts
    )
    lines.append(f"claimed by skeletal parameters: {claimed} of {total} vertices; the others stay in stage 1")
    lines += _uneven(tree, face)
    strange = sorted(name for name in tree.driven_by if name not in ALL and not is_unit(name))
    if strange:
        lines.append(f"driven by names that are no channels or action units: {', '.join(strange)}")
    return "\n".join(lines)


def _uneven(tree: ParameterTree, face: Face) -> list[str]:
    """Where skeletal weights do not sum to 1: they are normalised, which may not be what their author meant."""
    found = []
    for part in face.parts:
        total = np.zeros(len(part.vertices))
        for parameter in tree.parameters:
            if parameter.skeletal and part.name in parameter.influences:
                influence = parameter.influences[part.name]
                total[influence.vertices] += influence.weights
        off = np.abs(total - 1)
        off[total == 0] = 0
        if off.max(initial=0.0) > _UNEVEN:
            worst = int(np.argmax(off))
            found.append(
                f"part {part.name!r}: skeletal weights of {int((off > _UNEVEN).sum())} vertices do not sum to 1 and "
                f"are normalised, the farthest off {total[worst]:.2f} at vertex {worst}"
            )
    return found
