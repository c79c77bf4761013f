"""Reading what clients send, within limits: JSON, raw bytes, forms with a file."""

from __future__ import annotations

import asyncio
from typing import Any

from aiohttp import BodyPartReader, web

from mien.core.errors import InputError
from mien.core.plain_text import parsed_json
from mien.serve.studio.requests import FieldError
from mien.serve.studio.settings import Limits

__all__ = ["TooLarge", "read_bytes", "read_form", "read_json"]

_MOST_PARTS = 32
_MOST_DEPTH = 40
_CHUNK = 2**16


class TooLarge(FieldError):  # noqa: N818
    """A body is past its limit."""


async def read_bytes(request: web.Request, limits: Limits, most: int | None = None) -> bytes:
    """The body, up to ``most`` bytes (`Limits.upload_bytes` unless given).

    Raises
    ------
    TooLarge
        As soon as it is known.
    TimeoutError
        If it does not arrive in time.
    """
    most = limits.upload_bytes if most is None else most
    if (request.content_length or 0) > most:
        raise TooLarge("body", f"at most {most:,} bytes are taken, got {request.content_length:,}")
    pieces: list[bytes] = []
    held = 0
    async with asyncio.timeout(limits.request_seconds):
        async for piece in request.content.iter_chunked(_CHUNK):
            held += len(piece)
            if held > most:
                raise TooLarge("body", f"at most {most:,} bytes are taken, got more")
            pieces.append(piece)
    return b"".join(pieces)


async def read_json(request: web.Request, limits: Limits, most: int | None = None) -> dict[str, Any]:
    """The body as a JSON object.

    Raises
    ------
    InputError
        If it is something else.
    """
    content = await read_bytes(request, limits, limits.json_bytes if most is None else most)
    return parsed(content) if len(content) < _CHUNK else await asyncio.to_thread(parsed, content)


def parsed(content: bytes) -> dict[str, Any]:
    """A JSON object.

    Raises
    ------
    InputError
        If it is something else, is nested too deeply, or holds a number that is not finite.

    Examples
    --------
    >>> parsed(b'{"text": "Hello."}')
    {'text': 'Hello.'}
    >>> parsed(b'[NaN]')
    Traceback (most recent call last):
    mien.core.errors.InputError: expected a JSON object: NaN is not JSON
    """
    try:
        value = parsed_json(content.decode("utf-8"), parse_constant=_refuse_constant, parse_float=_finite)
    except ValueError as problem:
        raise InputError(f"expected a JSON object: {problem}") from problem
    if not isinstance(value, dict):
        raise InputError(f"expected a JSON object, got {type(value).__name__}")
    if _deeper(value, _MOST_DEPTH):
        raise InputError(f"the JSON is nested more than {_MOST_DEPTH} deep")
    return value


def _refuse_constant(name: str) -> None:
    raise ValueError(f"{name} is not JSON")


def _finite(text: str) -> float:
    number = float(text)
    if number in (float("inf"), float("-inf")):
        raise ValueError(f"the number {text[:20]} is too large")
    return number


def _deeper(value: Any, left: int) -> bool:
    if not isinstance(value, (dict, list)):
        return False
    if left == 0:
        return True
    return any(_deeper(inner, left - 1) for inner in (value.values() if isinstance(value, dict) else value))


async def read_form(request: web.Request, limits: Limits) -> tuple[dict[str, Any], bytes | None, str]:
    """A multipart form: its fields as text (those that repeat as lists), the file ``sound``, and that file's name.

    Raises
    ------
    InputError
        If it is no such form, or has a file of another name.
    TooLarge
        If it is past a limit.
    """
    fields: dict[str, Any] = {}
    sound, name = None, ""
    try:
        async with asyncio.timeout(limits.request_seconds):
            reader = await request.multipart()
            for _ in range(_MOST_PARTS):
                part = await reader.next()
                if part is None:
                    return fields, sound, name
                if not isinstance(part, BodyPartReader) or not part.name:
                    raise InputError("expected a plain form: every part has a name, and none has parts of its own")
                if part.name == "sound":
                    sound, name = await _part(part, limits.upload_bytes), part.filename or ""
                    continue
                text = (await _part(part, limits.json_bytes)).decode("utf-8")
                held = fields.get(part.name)
                fields[part.name] = text if held is None else [*(held if isinstance(held, list) else [held]), text]
    except (ValueError, AssertionError, LookupError, RuntimeError) as problem:  # what aiohttp's reader raises
        raise InputError(f"the form cannot be read: {problem}") from problem
    raise TooLarge("body", f"a form has at most {_MOST_PARTS} parts here")


async def _part(part: BodyPartReader, most: int) -> bytes:
    pieces, held = [], 0
    while piece := await part.read_chunk(_CHUNK):
        held += len(piece)
        if held > most:
            raise TooLarge(part.name or "body", f"at most {most:,} bytes are taken, got more")
        pieces.append(piece)
    return part.decode(b"".join(pieces))
