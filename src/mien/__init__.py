"""mien: speech or text in, an expressive 3D talking face out.

>>> import mien
>>> sorted(mien.__all__)
['Animation', 'Audio', 'InputError', 'MienError', 'Utterance', 'align', 'animate', 'doctor', 'express', 'save', 'say']

The names are loaded when first used, so that ``import mien`` stays quick.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mien.animation import Animation
    from mien.api import align, animate, express, save, say
    from mien.audio import Audio
    from mien.diagnosis import doctor
    from mien.errors import InputError, MienError
    from mien.speech.utterance import Utterance

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
]

_HOMES = {
    "Animation": "mien.animation",
    "Audio": "mien.audio",
    "InputError": "mien.errors",
    "MienError": "mien.errors",
    "Utterance": "mien.speech.utterance",
    "align": "mien.api",
    "animate": "mien.api",
    "doctor": "mien.diagnosis",
    "express": "mien.api",
    "save": "mien.api",
    "say": "mien.api",
}


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        return version("mien")
    if name not in _HOMES:
        raise AttributeError(f"module 'mien' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
