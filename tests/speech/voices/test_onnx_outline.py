"""An outline names weights by their place, whole ones only, and loses nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from mien.speech.voices.onnx_outline import outline
from mien.speech.voices.protocol_buffer import number, text


def _tensor(name: str, numbers: bytes) -> bytes:
    return text(5, number(1, len(numbers)) + text(8, name) + text(9, numbers))


def _model(*tensors: bytes) -> bytes:
    graph = text(1, b"a node") + b"".join(tensors) + text(12, b"an output")
    return number(1, 9) + text(7, graph) + text(8, b"opset")


def test_small_weights_stay_and_large_ones_are_named(tmp_path: Path) -> None:
    numbers = bytes(range(256)) * 20
    whole = _model(_tensor("small", b"12345678"), _tensor("large", numbers))
    (tmp_path / "part.bin").write_bytes(whole)
    found, folder = outline([tmp_path / "part.bin"])
    assert folder == tmp_path
    assert b"12345678" in found
    assert numbers not in found
    assert b"a node" in found
    assert b"an output" in found
    assert b"part.bin" in found
    assert str(whole.index(numbers)).encode() in found
    assert str(len(numbers)).encode() in found


def test_a_weight_that_is_cut_stays_inside(tmp_path: Path) -> None:
    numbers = bytes(range(256)) * 20
    whole = _model(_tensor("large", numbers))
    cut = whole.index(numbers) + 1000
    for place, piece in enumerate((whole[:cut], whole[cut:])):
        (tmp_path / f"{place}").mkdir()
        (tmp_path / f"{place}" / "part.bin").write_bytes(piece)
    found, folder = outline([tmp_path / "0/part.bin", tmp_path / "1/part.bin"])
    assert folder == tmp_path
    assert found == whole


@pytest.mark.parametrize("damaged", [b"\x3a\xff\x01", b"\xff" * 20, b"\x3b"])
def test_what_is_no_protocol_buffer(tmp_path: Path, damaged: bytes) -> None:
    (tmp_path / "part.bin").write_bytes(damaged)
    with pytest.raises(ValueError, match=r"field|number"):
        outline([tmp_path / "part.bin"])
