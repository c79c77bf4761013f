"""``.wav``: the sound alone."""

from __future__ import annotations

import io
from pathlib import Path

from mien.core.audio import Audio
from mien.core.errors import Note
from mien.core.files import replace_when_complete

__all__ = ["write_sound"]


def write_sound(audio: Audio, path: str | Path) -> tuple[Note, ...]:
    """Write a sound as WAV, 24 bit, one channel: every sample is kept exactly.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    import soundfile

    content = io.BytesIO()
    soundfile.write(content, audio.samples, audio.rate, format="WAV", subtype="PCM_24")
    with replace_when_complete(path) as unfinished:
        unfinished.write_bytes(content.getvalue())
    return ()
