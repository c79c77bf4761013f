"""What is too large is refused before it is decoded, in a line that names the limit."""

from __future__ import annotations

import contextlib
import io
import os
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.limits import LIMITS, check_size, fraction_of, load_array, load_arrays, most, read_bytes, read_member
from mien.fit.mesh_files import read_mesh
from mien.formats.sound_files import read_audio


def header(shape: str, kind: str = "<f8") -> bytes:
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text


def test_a_limit_is_named_and_can_be_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match=r"x\.png: 100,000,001 pixels; .*MIEN_MOST_PIXELS=\.\.\. raises it"):
        check_size("pixels", 100_000_001, "x.png")
    monkeypatch.setenv("MIEN_MOST_PIXELS", "2e8")
    check_size("pixels", 100_000_001, "x.png")
    monkeypatch.setenv("MIEN_MOST_PIXELS", "many")
    with pytest.raises(InputError, match="expected a number"):
        most("pixels")


def test_no_number_slips_through() -> None:
    with pytest.raises(InputError):
        check_size("rows", float("nan"), "x")
    assert all(limit.most > 0 for limit in LIMITS.values())


@pytest.mark.parametrize("text", ["1e99999999", "9" * 500, "1e-99999999", "1/0", "", "nan", "1e400/3", "0x10", "٣"])
def test_numbers_that_would_take_minutes_are_refused(text: str) -> None:
    with pytest.raises(InputError):
        fraction_of(text, "rate")


@pytest.mark.parametrize(("text", "value"), [("30", 30), ("29.97", 29.97), ("30000/1001", 30000 / 1001), ("3e1", 30)])
def test_usual_numbers_are_read(text: str, value: float) -> None:
    assert float(fraction_of(text, "rate")) == pytest.approx(value)


def test_arrays_come_back_as_they_were(tmp_path: Path) -> None:
    kinds = {
        "a": np.arange(12.0).reshape(3, 4),
        "b": np.asfortranarray(np.arange(6, dtype=np.int16).reshape(2, 3)),
        "c": np.array(["x", "yy"]),
        "d": np.array(5),
        "e": np.zeros((0, 3)),
        "f": np.array([True, False]),
    }
    np.savez_compressed(tmp_path / "a.npz", **kinds)
    read = load_arrays(tmp_path / "a.npz")
    assert set(read) == set(kinds)
    for name, array in kinds.items():
        assert read[name].dtype == array.dtype
        np.testing.assert_array_equal(read[name], array)
        np.save(tmp_path / "one.npy", array)
        np.testing.assert_array_equal(load_array(tmp_path / "one.npy"), array)


@pytest.mark.parametrize(
    "content",
    [
        header("(1000000000000,)"),
        header("(50000, 50000, 50000)"),
        header("(-1,)"),
        header("(3,)", "O"),
        header("(True,)"),
        header("((" * 500),
        b"\x93NUMPY\x02\x00\xff\xff\xff\xff",
        header("(4,)") + bytes(31),
        b"",
        b"PK",
    ],
)
def test_headers_that_promise_more_than_there_is(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "a.npy").write_bytes(content)
    with pytest.raises(InputError):
        load_array(tmp_path / "a.npy")
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("a.npy", content)
    with pytest.raises(InputError):
        load_arrays(tmp_path / "a.npz")


def test_a_zip_that_unpacks_to_gigabytes_is_not_unpacked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MIEN_MOST_UNPACKED", "1e6")
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.npy", bytes(2_000_000))
    with pytest.raises(InputError, match="MIEN_MOST_UNPACKED"):
        load_arrays(tmp_path / "a.npz")
    with zipfile.ZipFile(tmp_path / "a.npz") as archive, pytest.raises(InputError, match="MIEN_MOST_UNPACKED"):
        read_member(archive, "a.npy", "a.npz")


def test_damaged_zips_are_one_line(tmp_path: Path) -> None:
    stream = io.BytesIO()
    np.savez_compressed(stream, a=np.arange(1000))
    whole = bytearray(stream.getvalue())
    for place in range(0, len(whole), 37):
        damaged = bytearray(whole)
        damaged[place] ^= 0xFF
        (tmp_path / "a.npz").write_bytes(damaged)
        with contextlib.suppress(InputError):  # anything else fails the test; some bytes hurt nothing
            load_arrays(tmp_path / "a.npz")


def test_only_files_are_read(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"abc")
    assert read_bytes(tmp_path / "a") == b"abc"
    for bad in (tmp_path, tmp_path / "none", "/dev/zero", "a\0b"):
        if bad != "/dev/zero" or os.path.exists(bad):  # noqa: PTH110
            with pytest.raises(InputError):
                read_bytes(bad)


@pytest.mark.parametrize("name", ["a.wav", "a.mp3", "a.flac", "a.obj", "a.ply", "a.stl", "a.glb"])
def test_room_that_was_set_aside_and_never_filled_is_told(name: str, tmp_path: Path) -> None:
    with (tmp_path / name).open("wb") as file:
        file.truncate(900_000_000)
    with pytest.raises(InputError, match="nothing but zeros"):
        (read_audio if name[2:] in ("wav", "mp3", "flac") else read_mesh)(tmp_path / name)
