"""Live Link Face files as other programs and other countries write them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mien.core.channels import ARKIT
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.formats.livelink import COLUMNS, read_livelink


def timecode(tick: float, base: int, mark: str = ":") -> str:
    seconds, part = divmod(round(tick, 3), base)
    seconds = int(seconds) % 86400
    whole = f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}"
    return f"{whole}{mark}{int(part):02d}.{round(part % 1 * 1000):03d}"


def dropped(frame: int, base: int = 30) -> int:
    """Tick of a frame in drop-frame counting: the first two of each minute but the tenth do not exist."""
    left = 2 * base // 30
    minute, ten = 60 * base - left, 600 * base - 9 * left
    tens, rest = divmod(frame, ten)
    return frame + 9 * left * tens + (left * max(0, (rest - left) // minute))


def write(path: Path, ticks: list[str], jaw: list[float], mark: str = ",", **other: float) -> Path:
    """A recording in which the jaw moves; other columns as given, zero else."""
    rows = [mark.join(COLUMNS)]
    for code, value in zip(ticks, jaw, strict=True):
        cells = [f"{ {'JawOpen': value, **other}.get(name, 0.0):.6f}" for name in COLUMNS[2:]]
        rows.append(mark.join([code, "61", *(c.replace(".", ",") if mark == ";" else c for c in cells)]))
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def messages(notes: tuple) -> str:
    return " | ".join(note.message for note in notes)


def test_gaps_by_the_timecode_are_filled_across_midnight(tmp_path: Path) -> None:
    ticks = [*range(-30, 70, 2), *range(102, 230, 2)]  # every second tick of 60; 16 frames are missing after 68
    jaw = [(tick + 30) / 260 for tick in ticks]
    start = 86400 * 60
    path = write(tmp_path / "a.csv", [timecode(start + tick, 60) for tick in ticks], jaw)
    track, notes = read_livelink(path)
    assert track.rate == FrameRate.of(30)
    assert len(track) == (228 + 30) // 2 + 1
    np.testing.assert_allclose(track.channel("jawOpen"), np.arange(len(track)) / 130, atol=1e-5)
    assert "16 frames are missing by the timecode" in messages(notes)
    assert "at 1.63 s" in messages(notes)


@pytest.mark.parametrize(("base", "fps"), [(60, 59.94), (30, 29.97), (24, 23.976)])
def test_frames_that_drift_against_the_timecode_tell_the_true_rate(tmp_path: Path, base: int, fps: float) -> None:
    count = 3 * base
    codes = [timecode(11 * 3600 * base + 19 + frame * 1.001, base) for frame in range(count)]
    track, notes = read_livelink(write(tmp_path / "a.csv", codes, [0.5] * count))
    assert track.rate == FrameRate.of(fps)
    assert (len(track), notes) == (count, ())


@pytest.mark.parametrize("mark", [":", ";"])
@pytest.mark.parametrize(("base", "fps"), [(30, 29.97), (60, 59.94)])
def test_drop_frame_counting(tmp_path: Path, base: int, fps: float, mark: str) -> None:
    frames = range(58 * base, 64 * base)
    track, notes = read_livelink(
        write(tmp_path / "a.csv", [timecode(dropped(f, base), base, mark) for f in frames], [0.5] * len(frames))
    )
    assert track.rate == FrameRate.of(fps)
    assert (len(track), notes) == (len(frames), ())


def test_a_whole_minute_without_dropping_is_thirty(tmp_path: Path) -> None:
    codes = [timecode(frame, 30) for frame in range(58 * 30, 64 * 30)]
    track, notes = read_livelink(write(tmp_path / "a.csv", codes, [0.5] * len(codes)))
    assert (track.rate, len(track), notes) == (FrameRate.of(30), len(codes), ())


def test_jitter_of_the_camera_is_no_gap(tmp_path: Path) -> None:
    shake = np.random.default_rng(0).uniform(-0.2, 0.2, 300)
    codes = [timecode(3600 * 60 + frame + shake[frame], 60) for frame in range(300)]
    track, notes = read_livelink(write(tmp_path / "a.csv", codes, [0.5] * 300))
    assert (track.rate, len(track), notes) == (FrameRate.of(60), 300, ())


def test_percent_and_degrees_are_recognised(tmp_path: Path) -> None:
    codes = [timecode(frame, 30) for frame in range(40)]
    track, notes = read_livelink(write(tmp_path / "a.csv", codes, [85.0] * 40, HeadYaw=20.0, HeadPitch=-5.0))
    assert track.channel("jawOpen")[0] == pytest.approx(0.85)
    assert track.channel("headYaw")[0] == pytest.approx(20.0)
    assert track.channel("headPitch")[0] == pytest.approx(5.0)
    assert "read as percent" in messages(notes)
    assert "read as degrees" in messages(notes)


def test_the_eyes_tell_degrees_where_the_head_is_still(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", [timecode(t, 60) for t in range(90)], [0.5] * 90, HeadYaw=1.2, LeftEyeYaw=-14.0)
    track, notes = read_livelink(path)
    assert track.channel("headYaw").max() == pytest.approx(1.2)
    assert "read as degrees" in messages(notes)


def test_weights_a_little_outside_are_brought_back_and_reported(tmp_path: Path) -> None:
    codes = [timecode(frame, 30) for frame in range(40)]
    track, notes = read_livelink(write(tmp_path / "a.csv", codes, [1.2] * 40, MouthFunnel=-0.1))
    assert (track.channel("jawOpen")[0], track.channel("mouthFunnel")[0]) == (1.0, 0.0)
    assert "from -0.10 to 1.20 in 40 frames" in messages(notes)


@pytest.mark.parametrize("mark", [";", "\t"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_separators_and_encodings(tmp_path: Path, mark: str, encoding: str) -> None:
    path = write(tmp_path / "a.csv", [timecode(frame, 30) for frame in range(40)], [0.25] * 40, mark)
    path.write_text(path.read_text(encoding="utf-8"), encoding=encoding)
    track, _ = read_livelink(path)
    assert track.channel("jawOpen")[0] == pytest.approx(0.25)


def test_empty_cells_of_a_lost_face_are_filled(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", [timecode(f, 30) for f in range(40)], [f / 40 for f in range(40)])
    lines = path.read_text(encoding="utf-8").split("\n")
    for row in (10, 11, 12):
        lines[row] = ",".join([lines[row].split(",")[0], "61", *[""] * 61])
    path.write_text("\n".join(lines), encoding="utf-8")
    track, notes = read_livelink(path)
    np.testing.assert_allclose(track.channel("jawOpen"), np.arange(40) / 40, atol=1e-5)
    assert "lost in 3 frames" in messages(notes)


@pytest.mark.parametrize("cell", ["nan", "inf", "1e999", "x"])
def test_what_is_no_number_is_named_by_line_and_column(tmp_path: Path, cell: str) -> None:
    path = write(tmp_path / "a.csv", [timecode(f, 30) for f in range(40)], [0.5] * 40)
    path.write_text(path.read_text(encoding="utf-8").replace("0.500000", cell, 3), encoding="utf-8")
    with pytest.raises(InputError, match=r"a\.csv, line 2, column 20 \(JawOpen\): expected numbers"):
        read_livelink(path)


def test_missing_columns_are_zero_and_reported(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", [timecode(f, 30) for f in range(40)], [0.5] * 40)
    left_out = [COLUMNS.index(name) for name in ("TongueOut", "HeadYaw", "HeadPitch", "HeadRoll")]
    rows = [row.split(",") for row in path.read_text(encoding="utf-8").split("\n") if row]
    kept = [",".join(cell for place, cell in enumerate(row) if place not in left_out) for row in rows]
    path.write_text("\n".join(kept), encoding="utf-8")
    track, notes = read_livelink(path)
    assert not track.channel("headYaw").any()
    assert "no TongueOut, HeadYaw, HeadPitch, HeadRoll: taken as 0" in messages(notes)


def rows_of(path: Path) -> list[list[str]]:
    return [row.split(",") for row in path.read_text(encoding="utf-8").split("\n") if row]


def put(path: Path, rows: list[list[str]]) -> Path:
    path.write_text("\n".join(",".join(row) for row in rows), encoding="utf-8")
    return path


JAW = COLUMNS.index("JawOpen")
ROLL = COLUMNS.index("HeadRoll")


@pytest.fixture
def forty(tmp_path: Path) -> Path:
    return write(tmp_path / "a.csv", [timecode(f, 30) for f in range(40)], [f / 40 for f in range(40)], HeadRoll=0.1)


def changed(name: str, rows: list[list[str]]) -> list[list[str]]:
    match name:
        case "no count":
            return [[row[0], "0" if row[0] != "Timecode" else row[2], *row[3:]] for row in rows]
        case "sides":
            return [[cell.replace("Left", "_L").replace("Right", "_R") for cell in rows[0]], *rows[1:]]
        case "decimal commas in quotes":
            return [rows[0], *[[f'"{c.replace(".", ",")}"' if i > 1 else c for i, c in enumerate(r)] for r in rows[1:]]]
        case "percent signs":
            return [rows[0], *[[*r[:JAW], f"{100 * float(r[JAW]):.3f}%", *r[JAW + 1 :]] for r in rows[1:]]]
        case "remark":
            return [["# take 3", "Jürgen"], *rows]
        case "clock":
            return [rows[0], *[[f"00:00:{f / 30:06.3f}", *row[1:]] for f, row in enumerate(rows[1:])]]
        case "seconds":
            return [rows[0], *[[f"{7 + f / 30:.4f}", *row[1:]] for f, row in enumerate(rows[1:])]]
    raise AssertionError(name)


@pytest.mark.parametrize(
    "name", ["no count", "sides", "decimal commas in quotes", "percent signs", "remark", "clock", "seconds"]
)
def test_as_other_programs_write_it(forty: Path, name: str) -> None:
    track, notes = read_livelink(put(forty, changed(name, rows_of(forty))))
    assert track.rate == FrameRate.of(30)
    np.testing.assert_allclose(track.channel("jawOpen"), np.arange(40) / 40, atol=1e-5)
    assert "filled" not in messages(notes)


def test_single_empty_cells_are_filled_and_an_empty_column_is_zero(forty: Path) -> None:
    rows = rows_of(forty)
    for row in rows[10:13]:
        row[JAW] = ""
    for row in rows[1:]:
        row[ROLL] = ""
    track, notes = read_livelink(put(forty, rows))
    np.testing.assert_allclose(track.channel("jawOpen"), np.arange(40) / 40, atol=1e-5)
    assert not track.channel("headRoll").any()
    assert "no HeadRoll: taken as 0" in messages(notes)
    assert "3 frames have empty cells: filled" in messages(notes)


def test_a_header_alone_and_numbered_frames_are_told(forty: Path) -> None:
    rows = rows_of(forty)
    numbered = [rows[0], *[[str(f), *row[1:]] for f, row in enumerate(rows[1:])]]
    with pytest.raises(InputError, match=r"line 2: expected a timecode .* got '0': give the rate \(--fps\)"):
        read_livelink(put(forty, numbered))
    assert len(read_livelink(forty, FrameRate.of(30))[0]) == 40
    with pytest.raises(InputError, match="has a header and no frames"):
        read_livelink(put(forty, rows[:1]))


def test_time_that_runs_back_or_leaps_is_refused(tmp_path: Path) -> None:
    back = [timecode(f, 30) for f in [*range(40), *range(20, 40)]]
    with pytest.raises(InputError, match="line 42: the timecode goes back"):
        read_livelink(write(tmp_path / "a.csv", back, [0.5] * len(back)))
    leap = [timecode(f, 30) for f in [*range(40), *range(30 * 4000, 30 * 4000 + 40)]]
    with pytest.raises(InputError, match="missing in one place"):
        read_livelink(write(tmp_path / "a.csv", leap, [0.5] * len(leap)))


def test_all_weights_are_read() -> None:
    assert {name[0].upper() + name[1:] for name in ARKIT} <= set(COLUMNS)
