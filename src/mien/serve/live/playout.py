"""Which instant of the sound each frame shows: the two clocks of a live stream brought together.

Frames leave on the machine's clock, sound comes on that of the sound card, which runs a little faster or slower, in
pieces, sometimes late and sometimes not at all. `Playout` keeps the instant that is shown a look-ahead behind the sound
that was heard. It looks at the least that there was to spare in the last second, so that sound in pieces counts by its
worst instant, and steers:

* a small surplus or want (a clock that runs fast or slow) by showing the sound up to 2 % faster or slower;
* a surplus of more than `BEHIND` (sound that was held up and came at once) by going half as fast again, and one of more
  than `FAR_BEHIND` by leaving out what is too old;
* no sound at all by silence in its place, so that the face goes on and the mouth shuts; when sound comes again, the
  look-ahead is made up with silence before it.

Nothing adds up: an hour ends as it began.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from mien.core.errors import InputError
from mien.core.timeline import FrameRate

__all__ = ["BEHIND", "FAR_BEHIND", "Playout", "Showing"]

BEHIND, FAR_BEHIND = 0.08, 1.0
"""Seconds by which the sound may lie further ahead than the look-ahead before it is caught up with, or left out."""
_MEMORY = 1.0  # seconds over which the least surplus counts
_STEER, _MOST_STEER = 0.2, 0.02  # per second of surplus, and at most
_CATCH_UP = 0.5


@dataclass(frozen=True)
class Showing:
    """What the next frame shows.

    Attributes
    ----------
    seconds : float
        The instant, on the clock of the sound that was heard, silence put in its place included.
    before, after : float
        Seconds of silence that have to be heard before and after the sound that came in since the last frame.
    """

    seconds: float
    before: float = 0.0
    after: float = 0.0

    @property
    def silence(self) -> float:
        """Seconds of silence in all."""
        return self.before + self.after


class Playout:
    """Instants of frames, one after another.

    Parameters
    ----------
    rate : FrameRate
    look_ahead : float
        Seconds.

    Attributes
    ----------
    silence, left_out : float
        Seconds of silence that were put in place of sound, and of sound that was left out because it came too late.
    """

    def __init__(self, rate: FrameRate, look_ahead: float) -> None:
        if look_ahead < 0:
            raise InputError(f"a look-ahead is not negative: {look_ahead:g}")
        self._step, self._look_ahead = rate.time_of(1), look_ahead
        self._seconds = 0.0
        self._spare: deque[float] = deque(maxlen=max(1, round(_MEMORY / self._step)))
        self._starved = True  # nothing was heard yet
        self._heard = 0.0
        self.silence = self.left_out = 0.0

    def next(self, heard: float, frames: int = 1) -> Showing:
        """The instant of the next frame.

        Parameters
        ----------
        heard : float
            Seconds of sound that came in until now, silence asked for before included.
        frames : int
            How many frames have passed since the one before: more than 1 where some were left out.
        """
        passed = frames * self._step
        made_up = 0.0
        if self._starved and heard > self._heard + 1e-9:
            made_up = max(0.0, self._seconds + passed + self._look_ahead - heard)
            self._starved = False
            self._spare.clear()
            heard += made_up
        seconds = self._seconds + passed * self._speed()
        spare = heard - seconds - self._look_ahead
        if spare > FAR_BEHIND:
            self.left_out += spare
            seconds += spare
            self._spare.clear()
            spare = 0.0
        wanting = max(0.0, seconds - heard)
        if wanting > 0:
            self._starved = True
            heard += wanting
        else:
            self._spare.append(spare)
        self._seconds, self._heard = seconds, heard
        self.silence += made_up + wanting
        return Showing(seconds, made_up, wanting)

    def _speed(self) -> float:
        """How fast the sound is shown now, 1: as it was spoken."""
        if not self._spare:
            return 1.0
        least = min(self._spare)
        if least > BEHIND:
            self._spare.clear()
            self._spare.append(least - _CATCH_UP * self._step)
            return 1.0 + _CATCH_UP
        return 1.0 + max(-_MOST_STEER, min(_MOST_STEER, _STEER * least))
