"""mien: speech or text in, an expressive 3D talking face out.

>>> import mien
>>> [name for name in sorted(mien.__all__) if name.islower()]
['align', 'animate', 'doctor', 'express', 'save', 'say', 'score']

The names are loaded when first used, so that ``import mien`` stays quick.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mien.animation.animation import Animation
    from mien.api.calls import align, animate, express, save, say
    from mien.api.diagnosis import doctor
    from mien.core.audio import Audio
    from mien.core.errors import InputError, MienError
    from mien.core.utterance import Utterance
    from mien.metrics.scoring import score

__all__ = [
    "Animation",
    "Audio",
    "InputError",
    "MienError",
    "Utterance",
    "align",
    "animate",
    "doctor",
    "express",
    "save",
    "say",
    "score",
]

_HOMES = {
    "Animation": "mien.animation.animation",
    "Audio": "mien.core.audio",
    "InputError": "mien.core.errors",
    "MienError": "mien.core.errors",
    "Utterance": "mien.core.utterance",
    "align": "mien.api.calls",
    "animate": "mien.api.calls",
    "doctor": "mien.api.diagnosis",
    "express": "mien.api.calls",
    "save": "mien.api.calls",
    "say": "mien.api.calls",
    "score": "mien.metrics.scoring",
}


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        return version("mien")
    if name not in _HOMES:
        raise AttributeError(f"module 'mien' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
