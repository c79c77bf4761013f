"""Live sound on a simulated clock: an hour of it, sources that stall and burst, clients of every kind."""

from __future__ import annotations

import asyncio
import contextlib
import json
import tracemalloc
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from websockets.asyncio.client import connect

from mien.core import channels
from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.utterance import PAUSE
from mien.motion.performer import Performer
from mien.serve.live.animator import LiveAnimator, LiveSettings, frames_of
from mien.serve.live.clock import SimulatedClock
from mien.serve.live.frames import END, decode_frame
from mien.serve.live.live_performance import Performed, perform_live
from mien.serve.live.live_recording import LiveRecording
from mien.serve.live.sockets import Access
from mien.serve.live.sound_sources import SampleSource
from mien.serve.live.sound_stream import Inbox
from mien.serve.live.streaming import Outlets
from mien.speech.streaming_features import RATE
from mien.text.score import EmotionSpan, Score

LABELS = (PAUSE, "M")


class Quick:
    """An animator that hears and shows next to nothing, so that hours pass in seconds."""

    def __init__(self) -> None:
        self.settings = LiveSettings()
        self.samples = 0
        self.shown: list[float] = []
        self.delays: list[float] = []
        self.phones = Tier("phones", (Interval(0.0, 1e9, PAUSE),))
        self._values = np.zeros(len(channels.ALL))

    @property
    def heard(self) -> float:
        return self.samples / RATE

    def hear(self, samples: np.ndarray) -> None:
        self.samples += len(samples)

    def frame(self, seconds: float) -> np.ndarray:
        self.delays.append(self.heard - seconds)
        return self._values


class Scripted:
    """A source that has given ``arrived(now)`` seconds of sound until ``now``, and ends after ``until``."""

    def __init__(self, clock: SimulatedClock, arrived: Callable[[float], float], until: float) -> None:
        self.name, self.stored, self.inbox = "scripted", False, self
        self.dropped = self._taken = 0
        self._clock, self._arrived, self._until = clock, arrived, until

    def start(self) -> None:
        pass

    def stop(self) -> None:
        pass

    def take(self, most: int | None) -> np.ndarray:
        assert most is None
        upto = int(self._arrived(min(self._clock.now(), self._until)) * RATE)
        count, self._taken = max(0, upto - self._taken), max(upto, self._taken)
        return np.zeros(count, np.float32)

    @property
    def over(self) -> bool:
        return self._clock.now() >= self._until


def live(arrived: Callable[[float], float], until: float, late: Any = None) -> tuple[Performed, Quick]:
    clock, animator = SimulatedClock(late), Quick()
    source = Scripted(clock, arrived, until)
    performed = asyncio.run(
        perform_live(source, animator, Outlets(), performer="nobody", clock=clock)  # type: ignore[arg-type]
    )
    return performed, animator


@pytest.mark.parametrize("fast", [1e-3, -50e-6])
def test_an_hour_on_a_busy_machine_with_a_sound_card_that_runs_wrong(fast: float) -> None:
    random = np.random.default_rng(1)

    def late(seconds: float) -> float:
        return float(random.exponential(0.003)) + 0.2 * (random.random() < 1e-3)

    def arrived(now: float) -> float:
        return float(np.floor(now * (1 + fast) / 0.02) * 0.02)

    performed, animator = live(arrived, 3600.0, late)
    frame = 1 / 30
    assert 0.98 * 108_000 < performed.frames <= 108_000 + 30
    first, last = animator.delays[300:1500], animator.delays[-1500:-60]
    assert abs(np.median(last) - np.median(first)) < frame
    assert np.median(last) < 0.15 + 0.02 + frame
    assert performed.left_out == 0


def test_memory_is_flat_while_an_hour_goes_by() -> None:
    class Bounded(Quick):
        def frame(self, seconds: float) -> np.ndarray:
            if self.samples > 60 * RATE and not tracemalloc.is_tracing():
                tracemalloc.start()
            return self._values

    clock, animator = SimulatedClock(), Bounded()
    asyncio.run(
        perform_live(Scripted(clock, lambda now: now, 600.0), animator, Outlets(), performer="x", clock=clock)  # type: ignore[arg-type]
    )
    grown = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert grown < 100_000


def test_gaps_bursts_and_underruns_end_where_they_began() -> None:
    random = np.random.default_rng(7)
    held = 0.0
    blocked_until = 0.0

    def arrived(now: float) -> float:  # a hiccup now and then, after which everything comes at once
        nonlocal held, blocked_until
        if now >= blocked_until:
            held = now
            if random.random() < 0.01:
                blocked_until = now + float(random.exponential(0.3))
        return held

    performed, animator = live(arrived, 600.0)
    assert performed.skipped == 0
    assert min(animator.delays) >= -1e-3  # sound comes in whole samples
    assert np.median(animator.delays) < 0.15 + 0.12 + 1 / 30
    assert max(animator.delays) < 0.15 + 1.0 + 0.4 + 1 / 30


def test_silence_is_put_between_sounds_and_never_into_one() -> None:
    class Marked(Scripted):
        def take(self, most: int | None) -> np.ndarray:
            return super().take(most) + 1

    class Keeping(Quick):
        def __init__(self) -> None:
            super().__init__()
            self.kept: list[np.ndarray] = []

        def hear(self, samples: np.ndarray) -> None:
            super().hear(samples)
            self.kept.append(samples)

    clock, animator = SimulatedClock(), Keeping()
    source = Marked(clock, lambda now: min(now, 1.0) + max(0.0, min(now - 3.0, 1.0)), 6.0)
    asyncio.run(perform_live(source, animator, Outlets(), performer="x", clock=clock))  # type: ignore[arg-type]
    heard = np.concatenate([np.zeros(1), *animator.kept, np.zeros(1)])
    edges = np.flatnonzero(np.diff(heard))
    lengths = edges[1::2] - edges[::2]
    assert lengths.tolist() == pytest.approx([RATE, RATE], abs=2)
    assert (edges[2] - edges[1]) / RATE == pytest.approx(2.0, abs=0.2)


def test_an_empty_source_ends() -> None:
    performed, _ = live(lambda now: 0.0, 0.5)
    assert performed.frames < 60


def vowels() -> Audio:
    """Two seconds of a made-up vowel between silences."""
    times = np.arange(2 * RATE) / RATE
    wave = sum(np.sin(2 * np.pi * 120 * k * times) / (1 + ((120 * k - 700) / 200) ** 2) for k in range(1, 30))
    assert isinstance(wave, np.ndarray)
    loud = np.clip(np.minimum(times - 0.5, 1.5 - times) / 0.05, 0, 1)
    return Audio(0.1 * wave * loud, RATE)


def test_a_vowel_opens_the_mouth_and_silence_shuts_it() -> None:
    jaw = channels.ALL.index("jawOpen")
    opened = np.array([frame[jaw] for frame in frames_of(vowels(), Performer.hand_made())])
    assert opened[25:40].mean() > 4 * max(opened[:10].mean(), opened[-8:].mean(), 0.005)


def test_stored_sound_is_shown_whole_and_the_same_each_time_and_recorded() -> None:
    def once() -> Any:
        clock, performer = SimulatedClock(), Performer.hand_made()
        animator = LiveAnimator(performer)
        source = SampleSource(vowels().samples, "vowels")
        with LiveRecording(animator.stream.classifier.labels) as recording:
            performed = asyncio.run(
                perform_live(source, animator, Outlets(), performer="hand-made", recording=recording, clock=clock)
            )
            made = recording.animation(animator.settings.rate, Score(), "hand-made", 0)
        assert made is not None
        return performed, made

    (performed, made), (_, again) = once(), once()
    assert performed.skipped == 0
    assert performed.delay == pytest.approx(0.15, abs=1e-3)
    np.testing.assert_array_equal(made.channels.values, again.channels.values)
    wave = vowels().samples
    best = max(
        range(0, 8000, 40),
        key=lambda k: float(
            np.dot(made.utterance.audio.samples[k : k + len(wave)], wave[: len(made.utterance.audio) - k])
        ),
    )
    heard = made.utterance.audio.samples[best : best + len(wave)]
    np.testing.assert_allclose(heard, wave[: len(heard)], atol=1e-4)
    # The recording lies on the time of its sound: the same as frame by frame without a clock.
    jaw = channels.ALL.index("jawOpen")
    mouth = made.channels.values[:, jaw]
    plain = np.array([values[jaw] for values in frames_of(made.utterance.audio, Performer.hand_made())])[: len(mouth)]
    assert mouth.max() > 0.1
    off = [float(np.abs(mouth[8 + lag : lag - 8] - plain[8:-8]).mean()) for lag in range(-6, 7)]
    assert abs(int(np.argmin(off)) - 6) <= 1


def test_look_ahead_and_emotions_are_checked() -> None:
    for wrong in (0.04, 0.31):
        with pytest.raises(InputError, match="between 50 and 300 ms"):
            LiveSettings(wrong)
    with pytest.raises(InputError, match="one intensity throughout"):
        LiveSettings(score=Score((EmotionSpan("happy", 0.5, 0.0, 1.0),)))
    with pytest.raises(InputError, match="did you mean 'happy'"):
        LiveAnimator(Performer.hand_made(), LiveSettings(score=Score((EmotionSpan("hapy"),))))


def test_an_emotion_is_on_the_face_all_the_time() -> None:
    settings = LiveSettings(score=Score((EmotionSpan("happy", 0.8),)))
    smile = channels.ALL.index("mouthSmileLeft")
    silence = Audio.silence(0.7, RATE)
    happy = np.mean([f[smile] for f in frames_of(silence, Performer.hand_made(), settings)])
    plain = np.mean([f[smile] for f in frames_of(silence, Performer.hand_made())])
    assert happy > plain + 0.15


def test_clients_hear_a_live_stream_from_whenever_they_come() -> None:
    async def watch() -> tuple[dict[str, Any], list[int], str]:
        opened: asyncio.Future[int | None] = asyncio.get_running_loop().create_future()
        animator = Quick()
        animator.settings = LiveSettings(rate=FrameRate.of(100))
        source = SampleSource(np.zeros(RATE, np.float32), "second")
        playing = asyncio.create_task(
            perform_live(
                source,
                animator,
                Outlets(Access(port=0)),
                performer="nobody",
                wait=True,
                opened=opened.set_result,  # type: ignore[arg-type]
            )
        )
        numbers = []
        async with connect(f"ws://127.0.0.1:{await opened}") as client:
            greeting = json.loads(await client.recv())
            assert json.loads(await client.recv())["event"] == "began"
            while isinstance(message := await client.recv(), bytes):
                numbers.append(decode_frame(message).number)
        await playing
        return greeting, numbers, str(message)

    greeting, numbers, last = asyncio.run(watch())
    assert greeting["facts"] == {
        "live": True,
        "source": "second",
        "look_ahead": 0.15,
        "performer": "nobody",
        "began": None,
    }
    assert numbers == sorted(set(numbers))
    assert last == END


def test_a_problem_of_the_source_is_told_and_clients_get_their_goodbye() -> None:
    source = SampleSource(np.zeros(1600, np.float32), "broken")

    def fail() -> None:
        source.inbox.end(InputError("broken: it is no sound"))

    source.start = fail  # type: ignore[method-assign]

    async def play() -> None:
        await perform_live(source, Quick(), Outlets(), performer="x", clock=SimulatedClock())  # type: ignore[arg-type]

    with pytest.raises(InputError, match="no sound"), contextlib.ExitStack():
        asyncio.run(play())


def test_asking_to_stop_ends_the_wait_for_a_client() -> None:
    source = SampleSource(np.zeros(1600, np.float32), "x")
    outlets = Outlets(Access(port=0))
    performed = asyncio.run(
        perform_live(source, Quick(), outlets, performer="x", wait=True, stopping=lambda: True)  # type: ignore[arg-type]
    )
    assert performed.frames == 0


def test_asking_to_stop_ends_the_stream() -> None:
    asked = SimpleNamespace(times=0)

    def stopping() -> bool:
        asked.times += 1
        return asked.times > 20

    clock = SimulatedClock()
    source = Scripted(clock, lambda now: now, 1e9)
    performed = asyncio.run(
        perform_live(source, Quick(), Outlets(), performer="x", clock=clock, stopping=stopping)  # type: ignore[arg-type]
    )
    assert performed.frames == 20


def performed(clock: SimulatedClock, source: Any, recording: LiveRecording) -> Performed:
    animator = LiveAnimator(Performer.hand_made())
    return asyncio.run(
        perform_live(source, animator, Outlets(), performer="hand-made", recording=recording, clock=clock)
    )


def voice(seconds: float) -> np.ndarray:
    return (0.2 * np.random.default_rng(0).uniform(-1, 1, round(seconds * RATE))).astype(np.float32)


def late(seconds: float) -> float:
    """A machine that is now and then far behind."""
    return 0.31 if int(seconds * 30) % 7 == 3 else 0.0


def test_a_recording_of_stored_sound_is_the_same_however_late_the_machine_is() -> None:
    made, told = [], []
    labels = LiveAnimator(Performer.hand_made()).stream.classifier.labels
    for clock in (SimulatedClock(), SimulatedClock(late)):
        with LiveRecording(labels) as recording:
            told.append(performed(clock, SampleSource(voice(2.0), "voice"), recording))
            animation = recording.performed_again(Performer.hand_made(), LiveSettings(), "hand-made", whole=False)
        assert animation is not None
        made.append(animation)
    assert told[0].skipped == 0 < told[1].skipped
    assert len(made[0].channels) >= 60
    assert np.array_equal(*(animation.channels.values for animation in made))
    assert np.array_equal(*(animation.utterance.audio.samples for animation in made))
    whole = np.array(list(frames_of(Audio(voice(2.0), RATE), Performer.hand_made())))
    assert np.array_equal(made[0].channels.values[:50], whole[:50])


def test_sound_that_could_not_be_shown_is_in_the_recording_all_the_same() -> None:
    class Burst(SampleSource):
        def __init__(self) -> None:
            super().__init__(voice(6.0), "burst")
            self.stored, self.inbox = False, Inbox(1.0)

    labels = LiveAnimator(Performer.hand_made()).stream.classifier.labels
    with LiveRecording(labels) as recording:
        told = performed(SimulatedClock(), Burst(), recording)
        animation = recording.performed_again(Performer.hand_made(), LiveSettings(), "hand-made", whole=True)
    assert told.dropped == pytest.approx(5.0)
    assert "a recording holds them" in told.notes[0].message
    assert animation is not None
    assert np.array_equal(animation.utterance.audio.samples, Audio(voice(6.0), RATE).samples)
