"""mien in Blender: a line of text or sound becomes keyframes on a head's shape keys and bones (docs/blender.md)."""

from __future__ import annotations

from . import environment, operators, panel, settings

_PARTS = (settings, environment, operators, panel)


def register() -> None:
    """Called by Blender when the extension is switched on."""
    for part in _PARTS:
        part.register()


def unregister() -> None:
    """Called by Blender when the extension is switched off."""
    for part in reversed(_PARTS):
        part.unregister()
