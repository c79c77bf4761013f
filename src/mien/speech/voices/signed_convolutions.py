"""Convolutions in whole numbers as the processor likes them: unsigned weights by signed sound, in half the time.

`DynamicQuantizeLinear` makes unsigned bytes, and for a product of two unsigned matrices onnxruntime's kernels on x86
know no instruction of their own; unsigned by signed they do (VNNI, or VPMADDUBSW before it). So before each
``ConvInteger`` its input and the input's zero point are lowered by 128 (the upper bit is turned, the byte read as
signed): the differences that are multiplied, and with them every bit of the result, stay what they were. On processors
without VNNI pairs of products are added in 16 bits, which is exact for weights of seven bits (``reduce_range`` when the
network was quantised, as Kokoro's was).
"""

from __future__ import annotations

from mien.speech.voices.protocol_buffer import message_fields, number, text

__all__ = ["SIGN_BIT", "signed_convolution"]

_NAME = "mien/sign_bit"
_INT8, _UINT8 = 3, 2
_INT = 2  # the type of an attribute that is one number
SIGN_BIT = number(2, _UINT8) + text(8, _NAME) + text(9, b"\x80")
"""The initializer (``TensorProto``) that the nodes before a convolution read."""


def signed_convolution(node: bytes, known: set[str]) -> list[bytes] | None:
    """The nodes (``NodeProto``) that take the place of one; None for all but ``ConvInteger``.

    Parameters
    ----------
    node : bytes
    known : set of str
        Values that have been made signed already; more are added.
    """
    if b"ConvInteger" not in node:
        return None
    made, rest, inputs = list[bytes](), list[bytes](), list[bytes]()
    for field, content, whole in message_fields(node):
        if field == 1:
            inputs.append(content)
        else:
            rest.append(whole)
        if field == 4 and content != b"ConvInteger":
            return None
    for place in (0, 2):  # the sound and its zero point
        value = inputs[place].decode()
        inputs[place] = f"{value}/signed".encode()
        if value not in known:
            known.add(value)
            made.append(_node("BitwiseXor", [value, _NAME], f"{value}/turned"))
            to = text(1, "to") + number(3, _INT8) + number(20, _INT)
            made.append(_node("Cast", [f"{value}/turned"], f"{value}/signed", text(5, to)))
    return [*made, b"".join(text(1, name) for name in inputs) + b"".join(rest)]


def _node(kind: str, inputs: list[str], output: str, attributes: bytes = b"") -> bytes:
    return b"".join(text(1, name) for name in inputs) + text(2, output) + text(3, output) + text(4, kind) + attributes
