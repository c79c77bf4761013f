"""Signs of life: blinks, glances and a gently moving head. Authored rules, not learned.

Sources for the figures:

* Blinks: about 17 a minute at rest and 26 in conversation (Bentivoglio et al. 1997, Movement Disorders 12); the lids
  close in about 0.1 s and open in about 0.2 s (VanderWerf et al. 2003, J. Neurophysiology 89).
* Glances: a saccade of A degrees lasts about 2.2 A + 21 ms (Carpenter 1988, Movements of the Eyes).

A blink tends to fall in a pause or at a phrase end; here a planned blink moves to a pause when one is near.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien import channels
from mien.models.drift import smooth_drift
from mien.speech.utterance import PAUSE, Utterance
from mien.timeline import FrameRate

__all__ = ["AuthoredIdle"]

Floats = NDArray[np.float64]

BLINKS_PER_MINUTE = 20.0
BLINK_CLOSE, BLINK_SHUT, BLINK_OPEN = 0.10, 0.05, 0.21  # seconds
PAUSE_PULL = 0.6  # seconds: a blink this near to the start of a pause moves there
HEAD_SWAY = {"headYaw": 1.6, "headPitch": 1.1, "headRoll": 0.8}  # degrees, standard deviation
HEAD_TIME = 1.1  # seconds over which the head drifts
GAZE_SPREAD = 0.07  # eyeLook weight, standard deviation of where a glance lands
GAZE_HOLD = 1.3  # seconds, mean time between glances
SACCADE = 0.035  # seconds


class AuthoredIdle:
    """Blinks, glances and head sway for the length of an utterance.

    Parameters
    ----------
    blinks_per_minute : float
        Mean rate, 0 or more.
    """

    def __init__(self, blinks_per_minute: float = BLINKS_PER_MINUTE) -> None:
        self.blinks_per_minute = blinks_per_minute

    def perform(self, utterance: Utterance, rate: FrameRate, random: np.random.Generator) -> Floats:
        """Idle channels, shape (frames, channels); lids and eyes as weights, head in degrees."""
        times = rate.times(rate.frames_covering(utterance.duration))
        values = np.zeros((len(times), len(channels.ALL)))
        self._add_blinks(values, times, self.blink_times(utterance, random))
        self._add_glances(values, times, random)
        for name, spread in HEAD_SWAY.items():
            values[:, channels.ALL.index(name)] += spread * smooth_drift(times, HEAD_TIME, random)
        return values

    def blink_times(self, utterance: Utterance, random: np.random.Generator) -> list[float]:
        """Seconds at which the lids meet, in order."""
        if self.blinks_per_minute <= 0:
            return []
        mean = 60.0 / self.blinks_per_minute
        pauses = [p.start + BLINK_CLOSE for p in utterance.phones if p.label == PAUSE and p.start > 0]
        blinks: list[float] = []
        now = float(random.uniform(0.3, 0.8)) * mean
        while now < utterance.duration - BLINK_OPEN:
            near = [pause for pause in pauses if abs(pause - now) < PAUSE_PULL]
            moment = min(near, key=lambda pause: abs(pause - now)) if near else now
            if moment < utterance.duration - BLINK_OPEN and (not blinks or moment - blinks[-1] > 0.6):
                blinks.append(moment)
            now += float(np.clip(random.lognormal(np.log(mean) - 0.125, 0.5), 0.7, 4 * mean))
        return blinks

    def _add_blinks(self, values: Floats, times: Floats, blinks: list[float]) -> None:
        lids = [channels.ALL.index("eyeBlinkLeft"), channels.ALL.index("eyeBlinkRight")]
        for moment in blinks:
            # The lids are shut during at least one frame at 25 frames per second: 1 from `moment` on.
            closing = np.clip((times - (moment - BLINK_CLOSE)) / BLINK_CLOSE, 0, 1)
            opening = np.clip((times - moment - BLINK_SHUT) / BLINK_OPEN, 0, 1)
            shape = np.sin(np.pi / 2 * closing) ** 2 * np.cos(np.pi / 2 * opening) ** 2
            values[:, lids] = np.maximum(values[:, lids], shape[:, None])

    def _add_glances(self, values: Floats, times: Floats, random: np.random.Generator) -> None:
        landings, now = [(-1.0, 0.0, 0.0)], 0.0
        end = float(times[-1]) + 1.0
        while now < end:
            now += float(np.clip(random.exponential(GAZE_HOLD), 0.25, 4.0))
            landings.append((now, *(random.standard_normal(2) * GAZE_SPREAD * (1.0, 0.6))))
        start = np.array([landing[0] for landing in landings])
        side, height = (np.array([landing[k] for landing in landings]) for k in (1, 2))
        current = np.searchsorted(start, times, side="right") - 1
        passed = np.clip((times - start[current]) / SACCADE, 0, 1)
        last = np.maximum(current - 1, 0)
        yaw = side[last] + (side[current] - side[last]) * passed  # > 0: to the speaker's left
        pitch = height[last] + (height[current] - height[last]) * passed
        for name, amount in (
            ("eyeLookOutLeft", yaw),
            ("eyeLookInRight", yaw),
            ("eyeLookInLeft", -yaw),
            ("eyeLookOutRight", -yaw),
            ("eyeLookUpLeft", pitch),
            ("eyeLookUpRight", pitch),
            ("eyeLookDownLeft", -pitch),
            ("eyeLookDownRight", -pitch),
        ):
            values[:, channels.ALL.index(name)] += np.clip(amount, 0, None)
