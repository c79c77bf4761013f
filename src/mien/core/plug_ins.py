"""What installed packages add to mien, by entry points.

=================== ======================================================================
group               what an entry point names
=================== ======================================================================
``mien.formats``    a `mien.formats.Exporter`
``mien.metrics``    a function of two `mien.metrics.face_track.FaceTrack` that returns figures by name
``mien.performers`` a function without arguments that returns a `mien.motion.performer.Performer`
``mien.voices``     a `mien.speech.voices.voice.Voice`
=================== ======================================================================

An example of each stands in ``docs/extending.md``.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from mien.core.errors import InputError

__all__ = ["plug_ins"]


def plug_ins(group: str, kind: Callable[[Any], bool], expected: str) -> dict[str, tuple[str, Any]]:
    """What packages bring of a group: by the name of the entry point, the package's name and what it names.

    Parameters
    ----------
    group : str
        Such as ``"mien.formats"``.
    kind : callable
        Whether something is of the kind that is expected.
    expected : str
        The kind in words, for the message: ``"an Exporter"``.

    Raises
    ------
    InputError
        If a package brings something that cannot be loaded, or of another kind.

    Examples
    --------
    >>> plug_ins("mien.nothing", callable, "a function")
    {}
    """
    found = {}
    for entry in _entries(group):
        package = entry.dist.name if entry.dist is not None else entry.value
        try:
            thing = entry.load()
        except Exception as problem:  # whatever somebody else's package raises: it is named, and one line says so
            raise InputError(
                f"the package {package} brings {entry.name!r}, which cannot be loaded ({entry.value}: {problem}): "
                "update or uninstall it"
            ) from problem
        if not kind(thing):
            raise InputError(
                f"the package {package} names {entry.value} in {group}: expected {expected}, got {type(thing).__name__}"
            )
        found[entry.name] = (package, thing)
    return found


@cache
def _entries(group: str) -> tuple[EntryPoint, ...]:
    return tuple(sorted(entry_points(group=group), key=lambda entry: entry.name))
