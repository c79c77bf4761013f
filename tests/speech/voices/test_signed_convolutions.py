"""Signed sound gives a convolution the same bits; other nodes are left alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mien.speech.voices.onnx_outline import outline
from mien.speech.voices.onnx_voice import open_network
from mien.speech.voices.protocol_buffer import number, text
from mien.speech.voices.signed_convolutions import signed_convolution

_FLOAT, _UINT8, _INT32 = 1, 2, 6
_CHANNELS, _KERNEL = 24, 9


def _node(kind: str, inputs: list[str], outputs: list[str]) -> bytes:
    names = b"".join(text(1, name) for name in inputs) + b"".join(text(2, name) for name in outputs)
    return text(1, names + text(4, kind))


def _value(name: str, kind: int, sizes: list[int]) -> bytes:
    shape = b"".join(text(1, number(1, size)) for size in sizes)
    return text(1, name) + text(2, text(1, number(1, kind) + text(2, shape)))


def _tensor(name: str, values: np.ndarray[Any, Any]) -> bytes:
    sizes = b"".join(number(1, size) for size in values.shape)
    return text(5, sizes + number(2, _UINT8) + text(8, name) + text(9, values.tobytes()))


def _model(weights: np.ndarray[Any, Any], frames: int) -> bytes:
    graph = _node("DynamicQuantizeLinear", ["x"], ["q", "scale", "zero"])
    graph += _node("ConvInteger", ["q", "w", "zero", "w_zero"], ["y"])
    graph += _tensor("w", weights) + _tensor("w_zero", np.array(60, dtype=np.uint8))
    graph += text(11, _value("x", _FLOAT, [1, _CHANNELS, frames]))
    graph += text(12, _value("y", _INT32, [1, _CHANNELS, frames - _KERNEL + 1]))
    return number(1, 9) + text(7, text(2, "g") + graph) + text(8, number(2, 20))


def test_the_same_bits(tmp_path: Path) -> None:
    pytest.importorskip("onnxruntime")
    rng = np.random.default_rng(0)
    weights = rng.integers(0, 128, (_CHANNELS, _CHANNELS, _KERNEL)).astype(np.uint8)
    model = _model(weights, 100)
    (tmp_path / "part.bin").write_bytes(model)
    changed, folder = outline([tmp_path / "part.bin"])
    assert b"q/signed" in changed
    given = {"x": (rng.normal(size=(1, _CHANNELS, 100)) * 3 + 1).astype(np.float32)}
    as_it_was, signed = open_network(model, "test"), open_network(changed, "test", folder)
    np.testing.assert_array_equal(as_it_was.run(None, given)[0], signed.run(None, given)[0])


def test_other_nodes_are_left_alone() -> None:
    assert signed_convolution(text(1, "ConvInteger/x") + text(2, "y") + text(4, "Add"), set()) is None
