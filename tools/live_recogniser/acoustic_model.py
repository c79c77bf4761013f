"""hama's acoustic model with a head of our own: its weights under our names, and its answers in JAX, to learn with.

`mien.speech.frame_classifier` computes the same in numpy. The file in hama's wheel is a list of arrays: magic
``HAMAPK``, version, count; for each its name, type (0: float32, 1: float16), shape, place and size; then the data.
"""

from __future__ import annotations

import struct
from importlib.resources import files
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

BLOCKS, HEADS = 4, 4
DROPOUT, HEAD_DROPOUT = 0.1, 0.15
NEAR, REACH, WIDE, LABELS = 192, 2, 256, 40
_FIRST_PRODUCT, _FIRST_DEEP = 829, 804  # numbers in the exported names, by block
_PRODUCTS = ((0, 1, 2, 6, 7, 8), (9, 10, 11, 15, 16, 17), (18, 19, 20, 24, 25, 26), (27, 28, 29, 33, 34, 35))

Weights = dict[str, Any]


def stored() -> dict[str, NDArray[np.float32]]:
    """The arrays of hama 1.7.0."""
    content = (files("hama.assets") / "asr_waveform.hama").read_bytes()
    assert content[:6] == b"HAMAPK", "another version of hama?"
    (count,), place, entries = struct.unpack_from("<I", content, 8), 12, []
    for _ in range(count):
        (length,) = struct.unpack_from("<H", content, place)
        name = content[place + 2 : place + 2 + length].decode()
        kind, axes = content[place + 2 + length], content[place + 3 + length]
        place += 4 + length
        entries.append((name, kind, struct.unpack_from(f"<{axes}I", content, place),
                        *struct.unpack_from("<QQ", content, place + 4 * axes)))  # fmt: skip
        place += 4 * axes + 16
    data = len(content) - max(first + size for *_, first, size in entries)
    found = {}
    for name, kind, shape, first, size in entries:
        width = 2 if kind else 4
        values = np.frombuffer(content, f"<f{width}", size // width, data + first)
        found[name] = values.astype(np.float32).reshape(shape)
    return found


def with_head(random: np.random.Generator) -> dict[str, NDArray[np.float32]]:
    """The model under the names of `mien.speech.frame_classifier`, with a head that knows nothing yet."""
    was = stored()
    found = {"mel": was["mel_fb"], "sub_w": was["onnx::Conv_801"].transpose(2, 1, 0), "sub_b": was["onnx::Conv_802"]}
    for block in range(BLOCKS):
        old, products = (
            f"acoustic_model.model.blocks.{block}.",
            [was[f"onnx::MatMul_{_FIRST_PRODUCT + number}"] for number in _PRODUCTS[block]],
        )
        for name, entering, leaving in (("ffn1", *products[:2]), ("ffn2", *products[4:])):
            found |= {f"{block}.{name}.in_w": entering, f"{block}.{name}.out_w": leaving}
            found |= {f"{block}.{name}.in_b": was[f"{old}{name}.fc1.bias"]}
            found |= {f"{block}.{name}.out_b": was[f"{old}{name}.fc2.bias"]}
            found |= _normal(was, f"{old}{name}.norm", f"{block}.{name}.")
        found |= {f"{block}.attn.in_w": products[2], f"{block}.attn.in_b": was[f"{old}attn.in_proj_bias"]}
        found |= {f"{block}.attn.out_w": products[3], f"{block}.attn.out_b": was[f"{old}attn.out_proj.bias"]}
        found |= _normal(was, f"{old}attn_norm", f"{block}.attn.") | _normal(was, f"{old}norm", f"{block}.")
        for ours, theirs in (("in", "pointwise1"), ("out", "pointwise2")):
            found[f"{block}.conv.{ours}_w"] = was[f"{old}conv.{theirs}.weight"][:, :, 0].T
            found[f"{block}.conv.{ours}_b"] = was[f"{old}conv.{theirs}.bias"]
        deep = _FIRST_DEEP + 3 * block
        found[f"{block}.conv.deep_w"] = was[f"onnx::Conv_{deep}"][:, 0].T
        found[f"{block}.conv.deep_b"] = was[f"onnx::Conv_{deep + 1}"]
        found |= _normal(was, f"{old}conv.norm", f"{block}.conv.")
    width = len(found["sub_b"])
    for name, shape in (
        ("near", (BLOCKS * width, NEAR)),
        ("wide", (2 * REACH + 1, NEAR, WIDE)),
        ("out", (WIDE, 2 * LABELS)),
    ):
        found[f"head.{name}_w"] = random.normal(0, np.sqrt(2 / np.prod(shape[:-1])), shape)
        found[f"head.{name}_b"] = np.zeros(shape[-1])
    return {name: np.ascontiguousarray(values, np.float32) for name, values in found.items()}


def _normal(was: Weights, old: str, new: str) -> Weights:
    return {f"{new}norm_w": was[f"{old}.weight"], f"{new}norm_b": was[f"{old}.bias"]}


def log_posteriors(weights: Weights, rows: Any, key: Any) -> Any:
    """Log probabilities, shape (batch, rows, labels), of rows (batch, rows, bands), with dropout."""
    keys = iter(jax.random.split(key, 4 * BLOCKS + 2))
    batch, count = len(rows), rows.shape[1] // 2
    held = jnp.pad(rows, ((0, 0), (1, 1), (0, 0)))
    x = sum(held[:, k : k + 2 * count - 1 : 2] @ weights["sub_w"][k] for k in range(3)) + weights["sub_b"]
    x, found = jax.nn.gelu(x, approximate=False), []
    for block in range(BLOCKS):
        x = x + 0.5 * _dropped(_forward(x, weights, f"{block}.ffn1."), next(keys))
        parts = jnp.split(_into(x, weights, f"{block}.attn."), 3, -1)
        query, key_, value = (part.reshape(batch, count, HEADS, -1).swapaxes(1, 2) for part in parts)
        score = jax.nn.softmax(query @ key_.swapaxes(-1, -2) / np.sqrt(query.shape[-1]), axis=-1)
        taken = (score @ value).swapaxes(1, 2).reshape(batch, count, -1)
        x = x + _dropped(taken @ weights[f"{block}.attn.out_w"] + weights[f"{block}.attn.out_b"], next(keys))
        value, gate = jnp.split(_into(x, weights, f"{block}.conv."), 2, -1)
        deep = weights[f"{block}.conv.deep_w"]
        held = jnp.pad(value * jax.nn.sigmoid(gate), ((0, 0), (len(deep) // 2,) * 2, (0, 0)))
        value = sum(held[:, k : k + count] * deep[k] for k in range(len(deep))) + weights[f"{block}.conv.deep_b"]
        value = jax.nn.silu(value) @ weights[f"{block}.conv.out_w"] + weights[f"{block}.conv.out_b"]
        x = x + _dropped(value, next(keys))
        x = x + 0.5 * _dropped(_forward(x, weights, f"{block}.ffn2."), next(keys))
        x = _normalised(x, weights, f"{block}.")
        found.append(x)
    near = jax.nn.relu(jnp.concatenate(found, -1) @ weights["head.near_w"] + weights["head.near_b"])
    held = jnp.pad(_dropped(near, next(keys), HEAD_DROPOUT), ((0, 0), (REACH, REACH), (0, 0)))
    wide = sum(held[:, k : k + count] @ weights["head.wide_w"][k] for k in range(2 * REACH + 1))
    wide = _dropped(jax.nn.relu(wide + weights["head.wide_b"]), next(keys), HEAD_DROPOUT)
    answers = (wide @ weights["head.out_w"] + weights["head.out_b"]).reshape(batch, 2 * count, LABELS)
    return jax.nn.log_softmax(answers, -1)


def _normalised(x: Any, weights: Weights, name: str) -> Any:
    x = x - x.mean(-1, keepdims=True)
    x = x * jax.lax.rsqrt((x**2).mean(-1, keepdims=True) + 1e-5)
    return x * weights[f"{name}norm_w"] + weights[f"{name}norm_b"]


def _into(x: Any, weights: Weights, name: str) -> Any:
    return _normalised(x, weights, name) @ weights[f"{name}in_w"] + weights[f"{name}in_b"]


def _forward(x: Any, weights: Weights, name: str) -> Any:
    return jax.nn.silu(_into(x, weights, name)) @ weights[f"{name}out_w"] + weights[f"{name}out_b"]


def _dropped(x: Any, key: Any, rate: float = DROPOUT) -> Any:
    return x * jax.random.bernoulli(key, 1 - rate, x.shape) / (1 - rate)
