"""The emotions that a face can show, a voice can have and eyes and head go with: a table each, hand-made.

An emotion is one file, ``assets/performance/emotions/NAME.toml``, or the user's own (`mien.core.assets`); how it is
read stands in ``assets/performance/emotions.toml``. Whatever is done in an emotion asks here.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from mien.core.assets import asset, asset_table, assets_in
from mien.core.errors import InputError

__all__ = ["EMOTION_FOLDER", "emotion_sources", "emotion_table", "emotions"]

EMOTION_FOLDER = "performance/emotions"
_NEEDED = ("episodes", "lean", "head", "units", "arousal")


@cache
def emotions() -> Mapping[str, Mapping[str, Any]]:
    """The tables of all emotions by name, in the order of their names.

    Raises
    ------
    InputError
        If a table of the user's own lacks something.

    Examples
    --------
    >>> ", ".join(emotions())
    'afraid, angry, contempt, disgusted, frustrated, happy, neutral, sad, surprised'
    >>> sorted(emotions()["neutral"])
    ['arousal', 'episodes', 'head', 'lean', 'manner', 'units']
    """
    found = {name: asset_table(f"{EMOTION_FOLDER}/{name}.toml") for name in assets_in(EMOTION_FOLDER)}
    for name, table in found.items():
        missing = [key for key in _NEEDED if key not in table]
        if missing:
            raise InputError(f"{asset(f'{EMOTION_FOLDER}/{name}.toml')}: an emotion needs {', '.join(missing)} too")
    return found


def emotion_table() -> dict[str, Any]:
    """What is the same for all emotions: ``assets/performance/emotions.toml``."""
    return asset_table("performance/emotions.toml")


def emotion_sources() -> tuple[str, ...]:
    """Files of ``assets`` that hold the emotions, for digests."""
    return ("performance/emotions.toml", *(f"{EMOTION_FOLDER}/{name}.toml" for name in emotions()))
