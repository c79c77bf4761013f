"""From recordings to a person's face in motion.

Markers or a tracker's landmarks are cleaned and become a head shape and channel weights per frame on that head:
`capture_take`, `fit_person`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mien.capture.capture import Captured, capture_take
    from mien.capture.person import Person, fit_person, neutral_markers
    from mien.capture.solver import Priors

__all__ = ["Captured", "Person", "Priors", "capture_take", "fit_person", "neutral_markers"]

_WHERE = {
    "Captured": "capture", "capture_take": "capture", "Person": "person", "fit_person": "person",
    "neutral_markers": "person", "Priors": "solver",
}  # fmt: skip


def __getattr__(name: str) -> Any:
    """Loaded when first asked for: layouts and readers of this room are needed where no solver is."""
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_WHERE[name]}"), name)
