"""Reading poses (channel weights by name) out of the hand-made tables in ``assets/performance``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core import channels
from mien.core.assets import asset_table
from mien.core.errors import unknown_name

__all__ = ["pose_vector", "read_table"]


@cache
def read_table(name: str) -> dict[str, Any]:
    """One table of ``assets/performance`` as nested dictionaries; read once, so leave it as it is."""
    return asset_table(f"performance/{name}")


def pose_vector(pose: Mapping[str, float], where: str, names: Sequence[str] = channels.ALL) -> NDArray[np.float64]:
    """Weights of a pose in the order of ``names``, shape (channels,).

    A name without a side sets both sides (``mouthSmile`` means ``mouthSmileLeft`` and ``mouthSmileRight``).

    Raises
    ------
    InputError
        If a name is no channel; ``where`` says which table it stood in.

    Examples
    --------
    >>> pose_vector({"mouthSmile": 0.5}, "example", ("mouthSmileLeft", "mouthSmileRight", "jawOpen")).tolist()
    [0.5, 0.5, 0.0]
    """
    vector = np.zeros(len(names))
    for name, weight in pose.items():
        sides = [name] if name in names else [name + "Left", name + "Right"]
        for side in sides:
            if side not in names:
                raise unknown_name(f"channel in {where}", name, names)
            vector[names.index(side)] = weight
    return vector
