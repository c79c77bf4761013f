"""Signs of life: blinks, glances and a gently moving head. Hand-made rules, but for the head that goes with the voice.

Sources for the figures:

* Blinks: about 17 a minute at rest and 26 in conversation (Bentivoglio et al. 1997, Movement Disorders 12); the lids
  close in about 0.1 s and open in about 0.2 s (VanderWerf et al. 2003, J. Neurophysiology 89).
* Glances: `mien.motion.alive.gaze` (Lee, Badler & Badler 2002).
* Head: with the voice, as learned (`mien.motion.alive.head_motion`), and a slow drift, its size and pace by looking;
  `mien.motion.alive.visual_prosody` nods besides. `benchmarks/head_motion.py` holds all three against recorded heads.

What is felt changes all of them (`mien.motion.alive.manner`): an angry eye holds, a sad one looks down.
A blink tends to fall in a pause or at a phrase end; here a planned blink moves to a pause when one is near.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core import channels
from mien.core.errors import InputError, unknown_name
from mien.core.time_spans import places_within
from mien.core.timeline import FrameRate
from mien.core.utterance import PAUSE, Utterance
from mien.motion.alive.gaze import HandMadeGaze
from mien.motion.alive.head_motion import default_head
from mien.motion.alive.manner import Manner
from mien.motion.drift import smooth_drift
from mien.text.score import UNDIRECTED, Score

__all__ = ["SIGNS", "HandMadeIdle"]

Floats = NDArray[np.float64]

BLINKS_PER_MINUTE = 20.0
BLINK_CLOSE, BLINK_SHUT, BLINK_OPEN = 0.10, 0.05, 0.21  # seconds
MOST_BLINKS = 60  # a minute: a blink with its rest takes a second
PAUSE_PULL = 0.6  # seconds: a blink this near to the start of a pause moves there
HEAD_SWAY = {"headYaw": 1.6, "headPitch": 1.1, "headRoll": 0.8}  # degrees, standard deviation
HEAD_TIME = 1.1  # seconds over which the head drifts
SIGNS = ("blinks", "gaze", "sway", "head")
"""What can be switched."""
_HEAD = [channels.ALL.index(name) for name in channels.HEAD]


class HandMadeIdle:
    """Blinks, glances and head sway for the length of an utterance.

    Each sign of life has a random child of its own: switching one off leaves the others as they were.

    Parameters
    ----------
    blinks_per_minute : float
        Mean rate, 0 or more; 0: none.
    gaze : bool
        Whether the eyes move.
    sway : bool
        Whether the head drifts.
    head : bool
        Whether the head goes with the voice, as learned (`mien.motion.alive.head_motion`).
    """

    def __init__(
        self,
        blinks_per_minute: float = BLINKS_PER_MINUTE,
        gaze: bool = True,
        sway: bool = True,
        head: bool = True,
    ) -> None:
        if not blinks_per_minute >= 0:
            raise InputError(f"blinks per minute are 0 (none) or more, not {blinks_per_minute:g}")
        self.blinks_per_minute, self.gaze, self.sway, self.head = blinks_per_minute, gaze, sway, head
        self._gaze = HandMadeGaze()

    @classmethod
    def of(cls, signs: str) -> HandMadeIdle:
        """From names of `SIGNS` with commas between, ``"all"`` or ``"off"``; ``blinks=12`` says how many a minute.

        Raises
        ------
        InputError
            If a name is none of them, or a rate is no number from 0 to 60.

        Examples
        --------
        >>> idle = HandMadeIdle.of("gaze,sway")
        >>> idle.blinks_per_minute, idle.gaze, idle.sway
        (0.0, True, True)
        >>> HandMadeIdle.of("all,blinks=8").blinks_per_minute
        8.0
        """
        given = [sign.strip().lower().partition("=") for sign in signs.split(",") if sign.strip()]
        asked = {name for name, _, _ in given}
        for sign in sorted(asked):
            if sign not in (*SIGNS, "all", "off"):
                raise unknown_name("sign of life", sign, [*SIGNS, "all", "off"])
        if "off" in asked and len(asked) > 1:
            raise InputError(f"signs of life: 'off' stands alone, not in {signs!r}")
        if "all" in asked:
            asked = {*asked, *SIGNS}
        rate = BLINKS_PER_MINUTE if "blinks" in asked else 0.0
        for name, equals, value in given:
            if equals:
                rate = _rate_of(name, value)
        return cls(rate, "gaze" in asked, "sway" in asked, "head" in asked)

    def perform(
        self, utterance: Utterance, rate: FrameRate, random: np.random.Generator, score: Score = UNDIRECTED
    ) -> Floats:
        """Idle channels, shape (frames, channels); lids and eyes as weights, head in degrees.

        ``score`` is what is felt when.
        """
        times = rate.times(rate.frames_covering(utterance.duration))
        values = np.zeros((len(times), len(channels.ALL)), order="F")  # channels that rest take no memory
        manner = Manner(score, utterance.duration)
        for_blinks, for_gaze, for_head = random.spawn(3)
        self._add_blinks(values, times, self.blink_times(utterance, for_blinks, manner), manner)
        if self.gaze:
            self._gaze.look(values, utterance, times, for_gaze, score)
        self._add_head(values, utterance, rate, for_head, manner)
        return values

    def _add_head(
        self, values: Floats, utterance: Utterance, rate: FrameRate, random: np.random.Generator, manner: Manner
    ) -> None:
        times = rate.times(len(values))
        if self.head:
            values[:, _HEAD] = default_head().angles(utterance, rate)
        if self.sway:
            for name, spread in HEAD_SWAY.items():
                values[:, channels.ALL.index(name)] += spread * smooth_drift(times, HEAD_TIME, random)
        for name in channels.HEAD:
            values[:, channels.ALL.index(name)] *= manner.over(name.removeprefix("head").lower(), times)
        if self.head or self.sway:
            values[:, channels.ALL.index("headRoll")] += manner.over("tilt", times)

    def blink_times(
        self, utterance: Utterance, random: np.random.Generator, manner: Manner | None = None
    ) -> list[float]:
        """Seconds at which the lids meet, in order."""
        if self.blinks_per_minute <= 0:
            return []
        manner = manner or Manner(UNDIRECTED, utterance.duration)
        mean = 60.0 / self.blinks_per_minute
        pauses = [p.start + BLINK_CLOSE for p in utterance.phones if p.label == PAUSE and p.start > 0]
        blinks: list[float] = []
        now = float(random.uniform(0.3, 0.8)) * mean / manner.at("blinks", 0.0)
        while now < utterance.duration - BLINK_OPEN:
            near = [pause for pause in pauses if abs(pause - now) < PAUSE_PULL]
            moment = min(near, key=lambda pause: abs(pause - now)) if near else now
            if moment < utterance.duration - BLINK_OPEN and (not blinks or moment - blinks[-1] > 0.6):
                blinks.append(moment)
            wait = float(np.clip(random.lognormal(np.log(mean) - 0.125, 0.5), 0.7, 4 * mean))
            now += wait / manner.at("blinks", now)
        return blinks

    def _add_blinks(self, values: Floats, times: Floats, blinks: list[float], manner: Manner) -> None:
        lids = [channels.ALL.index("eyeBlinkLeft"), channels.ALL.index("eyeBlinkRight")]
        for moment in blinks:
            longer = manner.at("lids", moment)
            # The lids are shut during at least one frame at 25 frames per second: 1 from `moment` on.
            begin, opens = moment - longer * BLINK_CLOSE, moment + max(longer, 1.0) * BLINK_SHUT
            here = places_within(times, begin, opens + longer * BLINK_OPEN)
            closing = np.clip((times[here] - begin) / (longer * BLINK_CLOSE), 0, 1)
            opening = np.clip((times[here] - opens) / (longer * BLINK_OPEN), 0, 1)
            shape = np.sin(np.pi / 2 * closing) ** 2 * np.cos(np.pi / 2 * opening) ** 2
            values[here, lids] = np.maximum(values[here, lids], shape[:, None])


def _rate_of(name: str, value: str) -> float:
    """Blinks a minute as they were asked for; no other sign of life has a number."""
    try:
        rate = float(value)
    except ValueError:
        rate = -1.0
    if name != "blinks" or not 0 <= rate <= MOST_BLINKS:
        raise InputError(f"signs of life: only blinks take a number, 0 to {MOST_BLINKS} a minute, not {name}={value}")
    return rate
