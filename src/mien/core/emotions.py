"""The emotions that a face can show, a voice can have and eyes and head go with: a table each, hand-made.

An emotion is one file, ``assets/performance/emotions/NAME.toml``, or the user's own (`mien.core.assets`); how it is
read stands in ``assets/performance/emotions.toml``. Whatever is done in an emotion asks here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from mien.core.assets import asset, asset_table, assets_in
from mien.core.channels import HEAD
from mien.core.errors import InputError, unknown_name
from mien.core.facs import action_units

__all__ = ["EMOTION_FOLDER", "NOUNS", "emotion_called", "emotion_sources", "emotion_table", "emotions"]

EMOTION_FOLDER = "performance/emotions"
NOUNS: dict[str, str] = {
    "joy": "happy",
    "happiness": "happy",
    "fear": "afraid",
    "anger": "angry",
    "disgust": "disgusted",
    "sadness": "sad",
    "surprise": "surprised",
    "frustration": "frustrated",
}
"""What else the emotions of mien are called."""
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
        _check(asset(f"{EMOTION_FOLDER}/{name}.toml"), table)
    return found


def emotion_called(word: str) -> str:
    """The emotion that a word names; a word that is no other name of one is left as it is, in small letters.

    Examples
    --------
    >>> emotion_called("Joy"), emotion_called("fear"), emotion_called("wistful")
    ('happy', 'afraid', 'wistful')
    """
    small = word.strip().lower()
    return NOUNS.get(small, small)


def emotion_table() -> dict[str, Any]:
    """What is the same for all emotions: ``assets/performance/emotions.toml``."""
    return asset_table("performance/emotions.toml")


def emotion_sources() -> tuple[str, ...]:
    """Files of ``assets`` that hold the emotions, for digests."""
    return ("performance/emotions.toml", *(f"{EMOTION_FOLDER}/{name}.toml" for name in emotions()))


def _check(path: Path, table: Mapping[str, Any]) -> None:
    """Refuse what would be stumbled over later: missing parts, unknown units, values of another kind."""
    missing = [key for key in _NEEDED if key not in table]
    if missing:
        raise InputError(f"{path}: an emotion needs {', '.join(missing)} too")
    numbers: list[tuple[str, Any, int]] = [("arousal", table["arousal"], 1), ("lean", table["lean"], 1)]
    numbers += [("effort", table.get("effort", 1.0), 1), ("episodes", table["episodes"], 2)]
    for section in ("head", "units", "spoken", "voice", "manner"):
        entries = table.get(section, {})
        if not isinstance(entries, dict):
            raise InputError(f"{path}: {section} is a table, not {entries!r}")
        known = {"head": HEAD, "units": action_units(), "spoken": action_units()}.get(section)
        for key, value in entries.items():
            bare = key.rstrip("LR") if section in ("units", "spoken") else key
            if known is not None and bare not in known:
                raise unknown_name(f"entry of {section} in {path}", key, known)
            numbers.append((f"{section}.{key}", value, 2 if section == "units" else 1))
    for what, value, count in numbers:
        parts = value if isinstance(value, list) else [value]
        if len(parts) != count or not all(type(part) in (int, float) and math.isfinite(part) for part in parts):
            raise InputError(
                f"{path}: {what} is {'a number' if count == 1 else 'two numbers in brackets'}, not {value!r}"
            )
