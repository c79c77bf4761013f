"""From recordings to a person's face in motion.

Markers or a tracker's landmarks become a head shape and channel weights per frame on that head.
"""

from mien.capture.capture import Captured, capture_take
from mien.capture.person import Person, fit_person, neutral_markers
from mien.capture.solver import Priors

__all__ = ["Captured", "Person", "Priors", "capture_take", "fit_person", "neutral_markers"]
