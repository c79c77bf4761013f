"""Does the text fit the sound?"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from mien.audio import Audio
from mien.errors import Note
from mien.speech.text import SpokenText

if TYPE_CHECKING:
    from mien.speech.align import AlignedPhone


def doubts(audio: Audio, spoken: SpokenText, phones: Sequence[AlignedPhone]) -> tuple[Note, ...]:
    """Placeholder until calibrated."""
    return ()
