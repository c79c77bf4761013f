import numpy as np
import pytest
from scipy.signal import sosfiltfilt

from mien.capture.cleaning.tracker_jitter import JitterSettings, jitter, low_passed, smooth_group, smooth_head
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from tests.capture.cleaning.grid import LIPS, MOUTH, Grid
from tests.capture.cleaning.synthetic import MOUTH as MOUTH_MARKERS
from tests.capture.cleaning.synthetic import REST, column, head_motion, speaking, with_positions

LIP_U, LIP_L = column("lip_u"), column("lip_l")


def opening(positions: np.ndarray) -> np.ndarray:
    return np.linalg.norm(positions[:, LIP_U] - positions[:, LIP_L], axis=1)


def resting(noise: float, block: float, fps: float = 25) -> np.ndarray:
    random = np.random.default_rng(3)
    count = int(4 * fps)
    positions = np.repeat(REST[None], count, axis=0) + random.normal(0, noise, (count, *REST.shape))
    return positions + random.normal(0, block, (count, 1, 3))


@pytest.mark.parametrize("fps", [25, 120])
def test_noise_at_rest_falls_to_a_fraction(fps: float) -> None:
    track = speaking(int(4 * fps), fps)
    noisy = with_positions(track, resting(0.15, 0.2, fps))
    smooth = smooth_group(noisy, tuple(MOUTH_MARKERS)).positions
    mouth = [column(name) for name in MOUTH_MARKERS]
    assert jitter(smooth[:, mouth]) < 0.35 * jitter(noisy.positions[:, mouth])
    others = np.setdiff1d(np.arange(len(REST)), mouth)
    np.testing.assert_array_equal(smooth[:, others], noisy.positions[:, others])


def test_white_noise_has_the_jitter_that_is_said() -> None:
    noise = np.random.default_rng(0).normal(0, 0.2, (4000, 5, 3))
    assert jitter(noise) == pytest.approx(0.2 * np.sqrt(18), rel=0.02)
    assert np.isnan(jitter(np.full((9, 2, 3), np.nan)))


def test_closures_of_one_frame_keep_their_depth_where_a_low_pass_opens_them() -> None:
    track = speaking()
    positions = track.positions.copy()
    lower = [column(n) for n in ("lip_l", "lip_ll", "lip_lr", "outer_l", "chin", "chin_l", "chin_r")]
    positions[:, lower, 1] -= 8.0
    for frame in (30, 60, 90):
        positions[frame, lower, 1] += 8.0 - np.linspace(0, 0.3, len(lower))
        positions[frame, LIP_L] = positions[frame, LIP_U] + [0.0, -0.2, 0.0]
    closed = with_positions(track, positions)
    depth = opening(closed.positions)[[30, 60, 90]]
    smooth = opening(smooth_group(closed, tuple(MOUTH_MARKERS)).positions)[[30, 60, 90]]
    np.testing.assert_allclose(smooth, depth, atol=1e-9)
    assert opening(low_passed(positions, track.rate, 6.0))[[30, 60, 90]].min() > 2.0


def test_the_translation_filter_keeps_every_distance_in_the_group() -> None:
    track = speaking(noise=0.3)
    smooth = smooth_group(track, tuple(MOUTH_MARKERS), JitterSettings(window=0.0))
    np.testing.assert_allclose(opening(smooth.positions), opening(track.positions), atol=1e-9)
    assert smooth != track


def test_constant_and_slow_motion_pass_without_delay() -> None:
    t = np.arange(200) / 25
    slow = np.sin(2 * np.pi * 0.5 * t)
    np.testing.assert_allclose(low_passed(slow, FrameRate.of(25), 6.0), slow, atol=2e-3)
    np.testing.assert_allclose(low_passed(np.full(50, 3.0), FrameRate.of(25), 6.0), 3.0, atol=1e-9)
    half = low_passed(np.sin(2 * np.pi * 6.0 * t), FrameRate.of(25), 6.0)[50:150]
    assert np.abs(half).max() == pytest.approx(0.5, abs=0.03)  # -6 dB at the cut-off


def test_holes_part_the_track_and_stay() -> None:
    track = speaking(noise=0.2)
    positions = track.positions.copy()
    positions[50:55, LIP_L] = np.nan
    smooth = smooth_group(with_positions(track, positions), tuple(MOUTH_MARKERS)).positions
    assert np.isnan(smooth[50:55, LIP_L]).all()
    np.testing.assert_array_equal(smooth[50:55, LIP_U], positions[50:55, LIP_U])
    alone = smooth_group(with_positions(track, positions[:50]), tuple(MOUTH_MARKERS)).positions
    np.testing.assert_array_equal(smooth[:50], alone)


def test_zero_settings_and_empty_groups_change_nothing() -> None:
    track = speaking(noise=0.2)
    off = JitterSettings(translation_hz=0, window=0)
    np.testing.assert_allclose(smooth_group(track, tuple(MOUTH_MARKERS), off).positions, track.positions, atol=1e-12)
    assert smooth_group(track, ()) == track
    short = with_positions(track, track.positions[:2])
    assert len(smooth_group(short, tuple(MOUTH_MARKERS))) == 2
    with pytest.raises(InputError, match="still is below moving"):
        JitterSettings(still=30, moving=15)


def test_head_is_smoothed_and_stays_a_similarity() -> None:
    truth = head_motion(scale=0.03)
    random = np.random.default_rng(0)
    noisy = truth.copy()
    noisy[:, :3, 3] += random.normal(0, 0.3, (120, 3))
    noisy[40:43] = np.nan
    smooth = smooth_head(noisy, FrameRate.of(25), 3.0)
    placed = np.delete(np.arange(120), np.s_[40:43])
    assert np.isnan(smooth[40:43]).all()
    assert np.abs((smooth - truth)[placed]).std() < 0.7 * np.abs((noisy - truth)[placed]).std()
    gram = np.einsum("fji,fjk->fik", smooth[placed, :3, :3], smooth[placed, :3, :3])
    scale = np.einsum("fii->f", gram) / 3
    np.testing.assert_allclose(gram / scale[:, None, None], np.tile(np.eye(3), (len(placed), 1, 1)), atol=1e-9)
    np.testing.assert_allclose(smooth_head(truth, FrameRate.of(25), 0), truth, atol=1e-9)


@pytest.mark.data
def test_real_closures_survive_and_real_pauses_calm_down(grid: Grid) -> None:
    before, after, calm_before, calm_after, blunt = [], [], [], [], []
    for name in grid.names[:40]:
        track = grid.normalised(name)
        if np.isnan(track.positions).any():
            continue
        smooth = smooth_group(track, MOUTH)
        plain = low_passed(np.array(track.positions), track.rate, 6.0)
        words, fps = grid.words(name), grid.rate.fps
        lips = [track.names.index(n) for n in LIPS]
        for start, _, word in words[2:]:
            if word in ("blue", "by", "b", "p"):
                stretch = slice(round((start - 0.06) * fps), round((start + 0.08) * fps) + 1)
                for store, positions in ((before, track.positions), (after, smooth.positions), (blunt, plain)):
                    store.append(
                        np.linalg.norm(np.subtract(*positions[stretch, lips].transpose(1, 0, 2)), axis=1).min()
                    )
        mouth = [track.names.index(n) for n in MOUTH]
        pause = slice(0, round(words[0][1] * fps) - 4)
        if pause.stop < 8:
            continue
        calm_before.append(jitter(track.positions[pause][:, mouth]) ** 2)
        calm_after.append(jitter(smooth.positions[pause][:, mouth]) ** 2)
    assert len(before) > 10
    assert np.mean(np.subtract(after, before)) < 0.05
    assert np.mean(np.array(after) < 0.75) >= np.mean(np.array(before) < 0.75)
    assert np.mean(np.array(blunt) < 0.75) < np.mean(np.array(before) < 0.75) - 0.1
    assert np.sqrt(np.mean(calm_after)) < 0.75 * np.sqrt(np.mean(calm_before))


def test_low_pass_is_that_of_scipy() -> None:
    from scipy.signal import butter

    values = np.random.default_rng(0).normal(size=200)
    expected = sosfiltfilt(butter(2, 6 / 60, output="sos"), values, padlen=40)
    np.testing.assert_allclose(low_passed(values, FrameRate.of(120), 6.0), expected)
