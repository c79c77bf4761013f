"""A sound inside a text, to the last bit: 24-bit FLAC in base64."""

from __future__ import annotations

import base64
import binascii
import io

import numpy as np

from mien.core.audio import Audio
from mien.core.errors import InputError

__all__ = ["ENCODING", "decode_audio", "encode_audio"]

ENCODING = "base64 FLAC, 24 bit"
# Above 65535 Hz the FLAC encoder takes multiples of 10 only; other sounds get this rate in their FLAC header.
_NOMINAL_RATE = 48_000


def encode_audio(audio: Audio) -> str:
    """The samples as text; empty for an empty sound.

    Examples
    --------
    >>> sound = Audio([0.0, 0.25, -0.5], 8000)
    >>> decode_audio(encode_audio(sound), 8000, 3) == sound
    True
    """
    if not len(audio):
        return ""
    import soundfile

    rate = audio.rate if audio.rate <= 65_535 or audio.rate % 10 == 0 else _NOMINAL_RATE
    stream = io.BytesIO()
    soundfile.write(stream, audio.samples, rate, format="FLAC", subtype="PCM_24")
    return base64.b64encode(stream.getvalue()).decode("ascii")


def decode_audio(text: str, rate: int, count: int) -> Audio:
    """The sound of `encode_audio`'s text.

    Raises
    ------
    InputError
        If it is not base64, not FLAC, or has another number of samples.
    """
    try:
        data = base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError) as problem:
        raise InputError("the sound is not base64; was the text edited by hand?") from problem
    samples = np.zeros(0, dtype=np.float32)
    if data:
        import soundfile

        try:
            samples, _ = soundfile.read(io.BytesIO(data), dtype="float32")
        except soundfile.LibsndfileError as problem:
            raise InputError(f"the sound is not FLAC: {problem}") from problem
    if len(samples) != count:
        raise InputError(f"expected {count} samples of sound, got {len(samples)}")
    return Audio(samples, rate)
