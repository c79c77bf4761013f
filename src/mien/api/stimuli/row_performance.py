"""What is seen and what is heard of a stimulus."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from mien.animation.animation import Animation
from mien.api.stimuli.design import Stimulus
from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.motion.performer import Performer
from mien.motion.performers import load_performer

__all__ = ["performed"]

_EDGE = 200.0  # ms of silence at either end, as voices leave it


def performed(stimulus: Stimulus) -> tuple[Animation, Animation]:
    """The animation with the sound that is heard, and the one whose words that sound says (timed with it)."""
    from mien.api import calls as api

    options = {"voice": stimulus.voice or None, "fps": stimulus.fps, "seed": stimulus.seed}
    effort = stimulus.effort or None
    emotion = f"{stimulus.emotion}:{stimulus.intensity!r}" if stimulus.emotion else None

    def say(text: str, before: float, after: float) -> Animation:
        lead = f'<pause ms="{before}"/>' if before else ""
        tail = f'<pause ms="{after}"/>' if after else ""
        spoken = f"{lead}{_directed(stimulus, text)}{tail}"
        return api.say(spoken, emotion=emotion, effort=effort, performer=_performer(stimulus.performer), **options)  # type: ignore[arg-type]

    shift = stimulus.offset_ms
    before = _EDGE + -shift if shift < 0 else 0.0
    after = _EDGE + shift if shift > 0 else 0.0
    seen = say(stimulus.sentence, before, after)
    if not stimulus.heard:
        return _with_sound(seen, seen.utterance.audio, shift), seen
    heard = say(stimulus.heard, before, after)
    longer = heard.utterance.duration - seen.utterance.duration
    if longer > 0:
        last = max((word.end for word in seen.utterance.words), default=0.0)
        seen = say(stimulus.sentence, before, 1000 * (seen.utterance.duration - last + longer))
    return _with_sound(seen, heard.utterance.audio, shift), heard


def _performer(name: str) -> Performer:
    path = Path(name)
    changed = path.stat().st_mtime_ns if path.is_file() else 0
    return _read_performer(name, changed)


@lru_cache(maxsize=2)
def _read_performer(name: str, _changed: int) -> Performer:
    return load_performer(name)


def _directed(stimulus: Stimulus, text: str) -> str:
    for item in reversed(stimulus.au.replace(",", " ").split()):
        parameter, _, value = item.partition(":")
        text = f"<pose parameter={quoteattr(parameter)} value={quoteattr(value or '1')}>{text}</pose>"
    return text if stimulus.rate == 1 else f'<prosody rate="{stimulus.rate!r}">{text}</prosody>'


def _with_sound(animation: Animation, sound: Audio, shift_ms: float) -> Animation:
    """The animation with a sound that starts later (> 0) or earlier, as long as the picture."""
    rate, count = sound.rate, round(animation.utterance.duration * sound.rate)
    shift = round(shift_ms / 1000 * rate)
    samples = np.zeros(count, dtype=np.float32)
    first, start = max(0, -shift), max(0, shift)
    length = min(len(sound) - first, count - start)
    if length <= 0:
        raise InputError(
            f"offset_ms={shift_ms:g} puts the sound outside the picture of {animation.utterance.duration:.3f} s"
        )
    samples[start : start + length] = sound.samples[first : first + length]
    return replace(animation, utterance=replace(animation.utterance, audio=Audio(samples, rate)))
