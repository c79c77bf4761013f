"""What a studio offers: voices, performers, emotions, channels, formats, limits."""

from __future__ import annotations

import contextlib
from functools import cache
from importlib.metadata import version
from typing import Any

from mien.core import channels
from mien.core.errors import MissingPartError
from mien.core.poses import read_table
from mien.formats.registry import Exporter, exporters
from mien.motion.effort import effort_gains
from mien.serve.studio.settings import Limits
from mien.serve.studio.studio_faces import DEFAULT_FACE
from mien.serve.studio.views import CAMERAS, LIGHTS
from mien.text.tag_elements import gaze_targets

__all__ = ["about", "channel_group"]

_MOST_DEGREES = 45.0
_GROUPS = (("eye", "eyes"), ("brow", "brows"), ("jaw", "jaw"), ("tongue", "tongue"), ("head", "head"), ("nose", "nose"),
           ("cheek", "cheeks"), ("nasolabial", "cheeks"), ("mouth", "mouth"))  # fmt: skip


def about(limits: Limits) -> dict[str, Any]:
    """Everything a page needs to know before the first line, as JSON."""
    return {
        "version": version("mien"),
        **_offered(),
        "exports": [exporter.suffix for exporter in _writable()],
        "formats": [
            {"suffix": exporter.suffix, "title": exporter.title, "loses": exporter.loses} for exporter in _writable()
        ],
        "channels": [_channel(name) for name in channels.ALL],
        "lights": list(LIGHTS),
        "cameras": list(CAMERAS),
        "limits": {
            "upload_bytes": limits.upload_bytes,
            "text_characters": limits.text_characters,
            "seconds": limits.seconds,
            "edits": limits.edits,
        },
        "default_face": DEFAULT_FACE,
        "effort": {name: list(getattr(effort_gains(), name)) for name in ("efforts", "jaw", "lips")},
        "gazes": gaze_targets(),
        "gaze_degrees": read_table("gaze.toml")["degrees"],
    }


@cache
def _writable() -> tuple[Exporter, ...]:
    """The formats whose libraries are installed."""
    found = []
    for exporter in exporters():
        with contextlib.suppress(MissingPartError):
            exporter.check()
            found.append(exporter)
    return tuple(found)


@cache
def _offered() -> dict[str, Any]:
    """What does not change while the studio runs."""
    from mien.motion.performers import known_performers, load_performer
    from mien.speech.voices import catalogue
    from mien.text.languages import known_languages

    performers = known_performers()
    emotions = {name for performer in performers for name in load_performer(performer).expression.names}
    return {
        "performers": sorted(performers, key=lambda name: name != "default"),
        "voices": [
            {"name": voice.name, "language": voice.language} for voice in catalogue() if voice.availability().installed
        ],
        "emotions": sorted(emotions, key=lambda name: (name == "neutral", name)),
        "speech_models": ["coarticulation", "graph", "both"],
        "languages": ["en", *known_languages()],
    }


def channel_group(name: str) -> str:
    """The part of the face that a channel moves, for a page's lists.

    Examples
    --------
    >>> channel_group("jawOpen"), channel_group("nasolabialDeepenLeft"), channel_group("headYaw")
    ('jaw', 'cheeks', 'head')
    """
    return next((group for start, group in _GROUPS if name.startswith(start)), "other")


def _channel(name: str) -> dict[str, Any]:
    head = name in channels.HEAD
    return {
        "name": name,
        "unit": "degrees" if head else "",
        "minimum": -_MOST_DEGREES if head else 0.0,
        "maximum": _MOST_DEGREES if head else 1.0,
        "group": channel_group(name),
    }
