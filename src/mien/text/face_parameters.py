"""Face parameters: what a command may drive, and what each does to the channels of an animation.

Every channel of `mien.core.channels` is a parameter under its own name; a name without a side drives both sides; the
table
``assets/performance/parameters.toml`` adds the parameters of the paper (``HeadNod``) and a few more. Action units are
parameters too: ``AU12``, and ``AU12L`` or ``AU12R`` for one side (`mien.core.facs`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from mien.core import channels
from mien.core.assets import asset_table
from mien.core.errors import unknown_name
from mien.core.facs import au_channels, is_unit

__all__ = ["FaceParameter", "face_parameter", "parameter_names"]

Factors = tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class FaceParameter:
    """One degree of freedom.

    Attributes
    ----------
    name : str
    plus, minus : tuple of (str, float)
        Channels and factors for values above and below 0; a value *v* adds ``|v| * factor``.
    about : str
    """

    name: str
    plus: Factors
    minus: Factors
    about: str = ""

    @property
    def channels(self) -> tuple[str, ...]:
        """All channels that it moves, in the order of `mien.core.channels.ALL`."""
        moved = {name for name, _ in self.plus + self.minus}
        return tuple(name for name in channels.ALL if name in moved)


@cache
def _table() -> dict[str, FaceParameter]:
    found = {}
    for name, entry in asset_table("performance/parameters.toml").items():
        both = tuple(entry.get("channels", {}).items())
        plus = both + tuple(entry.get("plus", {}).items())
        minus = tuple((channel, -factor) for channel, factor in both) + tuple(entry.get("minus", {}).items())
        found[name] = FaceParameter(name, plus, minus, entry["about"])
    for name in channels.ALL:
        found[name] = FaceParameter(name, ((name, 1.0),), ((name, -1.0),))
    for name in channels.ALL:
        base = name.removesuffix("Left")
        if base != name and f"{base}Right" in channels.ALL and base not in found:
            sides = ((name, 1.0), (f"{base}Right", 1.0))
            found[base] = FaceParameter(base, sides, tuple((side, -1.0) for side, _ in sides))
    return found


def parameter_names() -> tuple[str, ...]:
    """All names that `face_parameter` knows, the table's first."""
    return tuple(_table())


@cache
def face_parameter(name: str) -> FaceParameter:
    """A face parameter by its name.

    Raises
    ------
    InputError
        With the nearest name that there is.

    Examples
    --------
    >>> face_parameter("HeadNod").plus
    (('headPitch', -60.0),)
    >>> face_parameter("mouthSmile").channels
    ('mouthSmileLeft', 'mouthSmileRight')
    """
    if name not in _table() and name.startswith("AU") and is_unit(name):
        sides = tuple(au_channels(name).items())
        return FaceParameter(name, sides, tuple((channel, -weight) for channel, weight in sides))
    if name not in _table():
        raise unknown_name("face parameter", name, _table())
    return _table()[name]
