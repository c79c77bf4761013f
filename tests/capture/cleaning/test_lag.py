import numpy as np
import pytest

from mien.capture.cleaning.lag import lag_from_phones, lag_from_sound, lip_opening
from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.tracks import MarkerTrack
from tests.capture.cleaning.grid import LIPS, Grid

SYLLABLES = ((0.5, 0.18), (0.9, 0.1), (1.15, 0.22), (1.7, 0.12), (2.05, 0.25), (2.6, 0.15), (3.2, 0.2), (3.55, 0.1))


def swell(t: np.ndarray) -> np.ndarray:
    """Loudness of a made-up utterance: a hump per syllable."""
    return sum(np.exp(-(((t - middle) / length) ** 2) * 4) for middle, length in SYLLABLES)


def sound() -> Audio:
    t = np.arange(4 * 16000) / 16000
    return Audio(0.3 * swell(t) ** 2 * np.sin(2 * np.pi * 140 * t), 16000)


def motion(lag: float, fps: float = 25, seconds: float = 4.0) -> MarkerTrack:
    """Lips that open as the loudness, ``lag`` seconds after it."""
    rate = FrameRate.of(fps)
    t = rate.times(int(seconds * fps))
    positions = np.zeros((len(t), 2, 3))
    positions[:, 1, 1] = -8 * swell(t - lag)
    return MarkerTrack(("u", "l"), positions, rate)


@pytest.mark.parametrize("lag", [-0.083, -0.02, 0.0, 0.013, 0.051, 0.12])
@pytest.mark.parametrize("fps", [25, 29.97, 120])
def test_known_lag_is_found_between_the_frames(lag: float, fps: float) -> None:
    found = lag_from_sound([motion(lag, fps)], [sound()], ("u", "l"))
    assert found.seconds == pytest.approx(lag, abs=0.004)
    assert found.fit > 0.9
    assert found.confidence >= 0.95
    assert np.isnan(found.error)


def test_several_takes_give_an_error_too() -> None:
    takes = [motion(0.04 + d) for d in (-0.004, 0.0, 0.004)]
    found = lag_from_sound(takes, [sound()] * 3, ("u", "l"))
    assert found.seconds == pytest.approx(0.04, abs=0.004)
    assert 0 < found.error < 0.01


def test_motion_that_has_nothing_to_do_with_the_sound_gives_no_confidence() -> None:
    random = np.random.default_rng(8)
    positions = np.zeros((100, 2, 3))
    positions[:, 1, 1] = np.convolve(random.normal(size=106), np.ones(7), mode="valid")
    found = lag_from_sound([MarkerTrack(("u", "l"), positions, FrameRate.of(25))], [sound()], ("u", "l"))
    assert found.confidence < 0.9


def test_holes_in_the_motion_do_no_harm() -> None:
    track = motion(0.03)
    positions = track.positions.copy()
    positions[:10] = np.nan
    positions[50:55] = np.nan
    found = lag_from_sound([MarkerTrack(track.names, positions, track.rate)], [sound()], ("u", "l"))
    assert found.seconds == pytest.approx(0.03, abs=0.005)


@pytest.mark.parametrize("lag", [-0.06, 0.0, 0.033])
def test_known_lag_is_found_from_the_phones(lag: float) -> None:
    openings = {"AA": 9.0, "B": 0.0, "IY": 3.0, "S": 1.5, "SIL": 0.5}
    random = np.random.default_rng(5)
    tracks, tiers = [], []
    for _ in range(6):
        edges = np.cumsum(random.uniform(0.07, 0.2, 24))
        labels = random.choice(list(openings), 23)
        phones = [Interval(a, b, str(p)) for a, b, p in zip(edges, edges[1:], labels, strict=False)]
        rate = FrameRate.of(25)
        t = rate.times(int(edges[-1] * 25)) - lag
        knots = [0.0] + [p.middle for p in phones]
        positions = np.zeros((len(t), 2, 3))
        positions[:, 1, 1] = -np.interp(t, knots, [0.5] + [openings[p.label] for p in phones])
        tracks.append(MarkerTrack(("u", "l"), positions, rate))
        tiers.append(Tier("phones", tuple(phones)))
    found = lag_from_phones(tracks, tiers, ("u", "l"))
    assert found.seconds == pytest.approx(lag, abs=0.006)
    assert found.confidence >= 0.95
    assert found.error < 0.01


def test_nothing_to_go_by_is_refused() -> None:
    still = MarkerTrack(("u", "l"), np.zeros((100, 2, 3)), FrameRate.of(25))
    with pytest.raises(InputError, match="the lips do not move or the sound is silent"):
        lag_from_sound([still], [sound()], ("u", "l"))
    with pytest.raises(InputError, match="the lips do not move or the sound is silent"):
        lag_from_sound([motion(0.0)], [Audio.silence(4.0, 16000)], ("u", "l"))
    with pytest.raises(InputError, match="as many sounds as tracks and at least one, got 0 for 1"):
        lag_from_sound([still], [], ("u", "l"))
    with pytest.raises(InputError, match="no phones"):
        lag_from_phones([still], [Tier("phones", ())], ("u", "l"))
    with pytest.raises(InputError, match="do not move in any take"):
        lag_from_phones([still], [Tier("phones", (Interval(0, 4, "AA"),))], ("u", "l"))
    with pytest.raises(InputError, match=r"at least 0.01 s"):
        lag_from_sound([still], [sound()], ("u", "l"), most=0.001)


def test_opening_is_a_distance_in_space() -> None:
    track = MarkerTrack(("u", "l"), [[[0.0, 0.0, 0.0], [2.0, 3.0, 6.0]]], FrameRate.of(25))
    assert lip_opening(track, "u", "l").tolist() == [7.0]


@pytest.mark.data
def test_lag_of_the_shared_recordings(grid: Grid) -> None:
    names = grid.names[2:900:18]
    found = lag_from_sound([grid.normalised(n) for n in names], [grid.audio(n) for n in names], LIPS)
    assert -0.012 < found.seconds < 0.002
    assert found.error < 0.01
    assert found.confidence == 1.0


def test_the_end_of_the_search_is_no_answer() -> None:
    """The true lag, 190 ms, lies beyond a search of 100 ms: its end fits best."""
    found = lag_from_sound([motion(0.19)], [sound()], ("u", "l"), most=0.1)
    assert np.isnan(found.seconds)
    assert found.confidence == 0.0
    assert np.isfinite(lag_from_sound([motion(0.19)], [sound()], ("u", "l")).seconds)
