"""`perform_live`: sound as it arrives, through the animator, to whoever listens, in real time."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from mien.core import channels
from mien.core.errors import Note
from mien.core.utterance import PAUSE
from mien.serve.live.animator import LiveAnimator
from mien.serve.live.clock import Clock, RealClock, frames_due
from mien.serve.live.frames import Frame, Greeting
from mien.serve.live.live_recording import LiveRecording
from mien.serve.live.playout import Playout
from mien.serve.live.sound_sources import SoundSource
from mien.serve.live.streaming import OpenOutlets, Outlets, opened_outlets, second_of_day
from mien.speech.streaming_features import RATE

__all__ = ["Performed", "perform_live"]

AFTERWARDS = 0.6
"""Seconds that are shown after the sound has ended: the mouth shuts."""
_LOOK = 0.2  # seconds between looks at a request to end while nobody listens yet


@dataclass(frozen=True)
class Performed:
    """What a live stream did.

    Attributes
    ----------
    frames, skipped : int
        Frames sent, and frames passed over because the machine was late.
    silence, left_out : float
        As in `Playout`.
    dropped : float
        Seconds of sound that came faster than they were taken.
    delay : float
        Seconds from the arrival of a sound to the frame that shows it: mean over all frames.
    """

    frames: int
    skipped: int
    silence: float
    left_out: float
    dropped: float
    delay: float

    @property
    def notes(self) -> tuple[Note, ...]:
        """What should be known about it."""
        found = []
        if self.skipped:
            found.append(f"{self.skipped} frames were skipped because this machine was late")
        if self.left_out > 0.05:
            found.append(f"{self.left_out:.1f} s of sound came too late and were left out")
        if self.dropped > 0.05:
            found.append(f"{self.dropped:.1f} s of sound came too fast to be shown (a recording holds them)")
        return tuple(Note("warning", text) for text in found)


async def perform_live(
    source: SoundSource,
    animator: LiveAnimator,
    outlets: Outlets,
    *,
    performer: str,
    recording: LiveRecording | None = None,
    clock: Clock | None = None,
    wait: bool = False,
    opened: Callable[[int | None], None] = lambda port: None,
    stopping: Callable[[], bool] = lambda: False,
    watch: Callable[[int, float], None] = lambda number, seconds: None,
) -> Performed:
    """Show sound while it arrives, until it ends. Matrices are multiplied by one thread of this process meanwhile.

    Parameters
    ----------
    source : SoundSource
    animator : LiveAnimator
    outlets : Outlets
    performer : str
        Name, for the greeting.
    recording : LiveRecording or None
        Gets what is heard and shown.
    clock : Clock or None
        None takes the machine's.
    wait : bool
        Begin when the first WebSocket client has come.
    opened : callable (port or None)
        Called once all outlets are open, with the port of the WebSocket.
    stopping : callable () -> bool
        Asked before each frame; True ends the stream.
    watch : callable (number, seconds)
        Told of each frame which instant of the sound it shows, silence that was put in not counted.

    Raises
    ------
    InputError
        If the sound cannot be read.
    OutputError
        If an address cannot be listened on or sent to.
    """
    settings = animator.settings
    facts = {"live": True, "source": source.name, "look_ahead": settings.look_ahead, "performer": performer}
    greeting = Greeting(channels.ALL, settings.rate.fps, facts)
    show = _Show(source, animator, recording)
    if recording is not None:
        source.inbox.tap = recording.add_arrived
    sent = last = 0
    async with opened_outlets(outlets, greeting) as open_to:
        open_to.prepare(Frame(0, 0.0, np.zeros(len(channels.ALL))))
        opened(open_to.port)
        if wait:
            await _somebody(open_to, stopping)
        # The matrices are small: threads that wait for one another take longer than one that does the work.
        with contextlib.closing(_Running(source)), threadpool_limits(1):
            clock = clock or RealClock()
            start, day = clock.now(), second_of_day()
            open_to.hub.begin(time.time())
            async for number in frames_due(settings.rate, clock, start):
                if stopping() or show.done:
                    break
                values = await _beside(show.next, number + 1 - last)
                at = settings.rate.time_of(number)
                open_to.send(Frame(number, at, values, day + at))
                watch(number, show.shown - show.playout.silence)
                sent, last = sent + 1, number + 1
    playout = show.playout
    delay = show.delays / max(sent, 1)
    return Performed(sent, last - sent, playout.silence, playout.left_out, source.inbox.dropped / RATE, delay)


async def _somebody(open_to: OpenOutlets, stopping: Callable[[], bool]) -> None:
    """Wait until somebody listens, or until the stream is asked to end."""
    waiting = asyncio.ensure_future(open_to.heard(Frame(0, 0.0, np.zeros(len(channels.ALL)))))
    while not waiting.done() and not stopping():
        await asyncio.wait([waiting], timeout=_LOOK)
    waiting.cancel()


async def _beside(work: Callable[[int], NDArray[np.float64]], given: int) -> NDArray[np.float64]:
    """Work done in a thread, so that listeners are served meanwhile also by a machine that is behind.

    It is waited for even where the stream is cancelled: nothing writes into a recording that is being closed.
    """
    going = asyncio.ensure_future(asyncio.to_thread(work, given))
    try:
        return await asyncio.shield(going)
    finally:
        if not going.done():
            await going


class _Running:
    """A source between its start and its stop."""

    def __init__(self, source: SoundSource) -> None:
        self._source = source
        source.start()

    def close(self) -> None:
        """Stop it."""
        self._source.stop()


class _Show:
    """The frames of a source: takes what has come, silence where nothing has."""

    def __init__(self, source: SoundSource, animator: LiveAnimator, recording: LiveRecording | None) -> None:
        self._source, self._animator, self._recording = source, animator, recording
        self._look_ahead, self._step = animator.settings.look_ahead, animator.settings.rate.time_of(1)
        self.playout = Playout(animator.settings.rate, self._look_ahead)
        self.delays = 0.0
        self.shown = 0.0
        self._over_since: float | None = None

    @property
    def done(self) -> bool:
        """Whether the sound has ended and the mouth had time to shut."""
        return self._over_since is not None and self.shown >= self._over_since + AFTERWARDS

    def next(self, frames: int) -> NDArray[np.float64]:
        """The next frame that is shown, ``frames`` after the one before."""
        most = None
        if self._source.stored:  # only as much as belongs to this frame: the rest keeps its time
            wanted = self.shown + frames * self._step + self._look_ahead - self._animator.heard
            most = max(0, round(wanted * RATE))
        came = self._source.inbox.take(most)
        if self._source.inbox.over:
            came = self._with_end(came, frames)
        showing = self.playout.next(self._animator.heard + len(came) / RATE, frames)
        for samples in (_silence(showing.before), came, _silence(showing.after)):
            self._hear(samples)
        self.shown = showing.seconds
        self.delays += self._animator.heard - self.shown
        values = self._animator.frame(self.shown)
        if self._recording is not None:
            phone = self._animator.phones.at(self.shown)
            self._recording.add_frame(self.shown, phone.label if phone else PAUSE, values)
        return values

    def _with_end(self, came: NDArray[np.float32], frames: int) -> NDArray[np.float32]:
        """The last sound, and the silence after it that belongs to the next frame."""
        heard = self._animator.heard + len(came) / RATE
        if self._over_since is None:
            self._over_since = heard
        lacking = self.shown + frames * self._step + self._look_ahead - heard
        return np.concatenate([came, _silence(max(0.0, lacking))])

    def _hear(self, samples: NDArray[np.float32]) -> None:
        if len(samples):
            self._animator.hear(samples)
            if self._recording is not None:
                self._recording.add_sound(samples)


def _silence(seconds: float) -> NDArray[np.float32]:
    return np.zeros(round(seconds * RATE), np.float32)
