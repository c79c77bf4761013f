"""What a live stream showed, kept on disk while it runs and made an animation at its end."""

from __future__ import annotations

import tempfile
from importlib.metadata import version
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from mien.animation.animation import Animation, Provenance
from mien.core import channels
from mien.core.audio import Audio
from mien.core.errors import Note
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.tracks import ChannelTrack
from mien.core.utterance import PAUSE, Utterance
from mien.motion.performer import Performer
from mien.serve.live.animator import LiveSettings, frames_and_phones
from mien.speech.streaming_features import RATE
from mien.text.score import Score

__all__ = ["LiveRecording"]

_WIDTH = len(channels.ALL) + 2  # the instant, the number of the phone, the channels


class LiveRecording:
    """Takes frames and sound as they pass; memory does not grow with time.

    Parameters
    ----------
    labels : sequence of str
        Phones, by number.
    """

    def __init__(self, labels: tuple[str, ...]) -> None:
        self._labels = labels
        self._frames, self._sound = tempfile.TemporaryFile(), tempfile.TemporaryFile()  # noqa: SIM115
        self._came = tempfile.TemporaryFile()  # noqa: SIM115

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None
    ) -> None:
        for file in (self._frames, self._sound, self._came):
            file.close()

    def add_sound(self, samples: NDArray[np.floating]) -> None:
        """Sound that was heard, 16 kHz."""
        self._sound.write(np.asarray(samples, dtype="<f4").tobytes())

    def add_arrived(self, samples: NDArray[np.floating]) -> None:
        """Sound as it came, 16 kHz, whether or not it could be shown in time."""
        self._came.write(np.asarray(samples, dtype="<f4").tobytes())

    def add_frame(self, seconds: float, phone: str, values: NDArray[np.float64]) -> None:
        """What was shown for an instant of the sound, and the phone that was heard there."""
        row = np.concatenate([[seconds, self._labels.index(phone)], values])
        self._frames.write(row.astype("<f8").tobytes())

    def animation(self, rate: FrameRate, score: Score, performer: str, seed: int) -> Animation | None:
        """The whole as an animation on the time of the sound; None if nothing was shown.

        Frames are interpolated from the instants that were shown, which lie a little closer or wider where the sound
        was caught up with.
        """
        rows, samples = _read(self._frames, "<f8").reshape(-1, _WIDTH), _read(self._sound, "<f4")
        if not len(rows) or not len(samples):
            return None
        audio = Audio(samples, RATE)
        times = rate.times(rate.frames_covering(min(audio.duration, float(rows[-1, 0]) + rate.time_of(1))))
        values = np.stack([np.interp(times, rows[:, 0], column) for column in rows[:, 2:].T], axis=1)
        audio = Audio(samples[: round(len(times) / rate.fps * RATE)], RATE)
        values = values[: rate.frames_covering(audio.duration)]
        note = Note("note", "recorded live: phones were recognised with a short look-ahead and are approximate")
        phones = self._phones(rows[:, 0], rows[:, 1].astype(int), audio.duration)
        utterance = Utterance("", audio, Tier("words", ()), phones, "en-US", "recognised", (note,))
        track = ChannelTrack(channels.ALL, values, rate)
        return Animation(track, None, utterance, score, Provenance(performer, seed, version("mien")), (note,))

    def performed_again(self, performer: Performer, settings: LiveSettings, name: str, whole: bool) -> Animation | None:
        """The sound as it is shown where nothing is late: the same frames each time; None if nothing was shown.

        Parameters
        ----------
        performer : Performer
        settings : LiveSettings
        name : str
            Of the performer.
        whole : bool
            All sound that came, rather than what was taken for the frames. Where all of it was shown that is so
            anyway: the silence that a late machine shows before and after it is left out.
        """
        came, rows = _read(self._came, "<f4"), _read(self._frames, "<f8").reshape(-1, _WIDTH)
        shown = round((float(rows[-1, 0]) + settings.rate.time_of(1)) * RATE) if len(rows) else 0
        samples = came if whole or shown >= len(came) > 0 else _read(self._sound, "<f4")[:shown]
        if not len(samples) or not len(rows):
            return None
        made = LiveRecording(self._labels)
        with made, threadpool_limits(1):
            audio = Audio(samples, RATE)
            made.add_sound(audio.samples)
            for seconds, phone, values in frames_and_phones(audio, performer, settings):
                made.add_frame(seconds, phone, values)
            return made.animation(settings.rate, settings.score, name, settings.seed)

    def _phones(self, times: NDArray[np.float64], numbers: NDArray[np.int64], duration: float) -> Tier:
        """Runs of frames with the same phone; silence before the first and, at the end, what was last."""
        starts = np.concatenate([[0], np.flatnonzero(np.diff(numbers)) + 1])
        edges = [0.0, *np.clip(times[starts[1:]], 0.0, duration).tolist(), duration]
        spans = zip(edges, edges[1:], starts, strict=False)
        found = [Interval(a, b, self._labels[numbers[place]]) for a, b, place in spans if b > a]
        return Tier("phones", tuple(found) or (Interval(0.0, duration, PAUSE),))


def _read(file: object, form: str) -> NDArray[np.float64]:
    file.seek(0)  # type: ignore[attr-defined]
    return np.frombuffer(file.read(), form).astype(np.float64)  # type: ignore[attr-defined]
