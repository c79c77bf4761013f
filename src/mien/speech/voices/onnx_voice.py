"""Running a voice's network with onnxruntime, with one inner value more among its outputs."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from importlib.resources.abc import Traversable
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import MissingPartError
from mien.core.limits import is_whole
from mien.speech.onnx_runtime import forbid_telemetry
from mien.speech.voices.onnx_outline import outline

if TYPE_CHECKING:
    import onnxruntime

__all__ = ["RUNTIME_PACKAGE", "have_runtime", "open_network", "open_parts", "read_model", "run_once", "with_output"]

RUNTIME_PACKAGE = "onnxruntime"
_THREADS = 2
_ERRORS_ONLY = 3


def have_runtime() -> bool:
    """Whether onnxruntime is installed."""
    return find_spec(RUNTIME_PACKAGE) is not None


def with_output(model: bytes, name: str) -> bytes:
    r"""The same ONNX model with the inner value ``name`` among its outputs.

    An ONNX file is a protocol buffer, and a message that comes twice in one is merged. So a second, nearly empty
    ``ModelProto.graph`` (field 7) that holds just one ``GraphProto.output`` (field 12, whose field 1 is the name)
    appended to the file adds an output without parsing or copying the graph.

    Examples
    --------
    >>> with_output(b"", "/a")
    b':\x06b\x04\n\x02/a'
    """
    value = _field(1, name.encode("utf-8"))
    return model + _field(7, _field(12, value))


def _field(number: int, content: bytes) -> bytes:
    """A length-delimited protocol buffer field, up to 127 bytes long."""
    return bytes([number << 3 | 2, len(content)]) + content


def read_model(parts: Sequence[Traversable], whose: str) -> bytes:
    """The bytes of a model that may be cut into several files.

    Raises
    ------
    MissingPartError
        If a file is missing or cannot be read.
    """
    try:
        return b"".join(part.read_bytes() for part in parts)
    except OSError as problem:
        raise MissingPartError(f"the network of the voice {whose} is not there ({problem}): reinstall it") from problem


def open_parts(parts: Sequence[Path], whose: str, output: str) -> onnxruntime.InferenceSession:
    """Open a model that may be cut into several files, with one output more, leaving its weights on the disk.

    The graph is taken as it is: one that was optimised when it was exported gains nothing from being optimised again,
    and that takes longer than reading it.

    Raises
    ------
    MissingPartError
        As `read_model` and `open_network`.
    """
    try:
        model, folder = outline(parts)
    except OSError as problem:
        raise MissingPartError(f"the network of the voice {whose} is not there ({problem}): reinstall it") from problem
    except ValueError as problem:
        raise MissingPartError(f"the network of the voice {whose} does not open ({problem}): reinstall it") from problem
    return open_network(with_output(model, output), whose, folder)


def open_network(model: bytes, whose: str, weights: Path | None = None) -> onnxruntime.InferenceSession:
    """Open a model for running on two threads, or on one where ``OMP_NUM_THREADS`` says so: the same bits.

    Parameters
    ----------
    model : bytes
    whose : str
        Name of the voice, for messages.
    weights : Path or None
        The folder from which the model names the files of its weights (`mien.speech.voices.onnx_outline`); such a
        model is run as it is, others are optimised first.

    Raises
    ------
    MissingPartError
        If the model's file is damaged, or onnxruntime cannot run it.
    """
    forbid_telemetry()
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = min(_THREADS, _threads_left())
    options.inter_op_num_threads = 1
    options.log_severity_level = _ERRORS_ONLY
    # Idle threads sleep: spinning ones take the processor from the rest of the work on a small machine.
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    if weights is not None:
        options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_DISABLE_ALL
        options.enable_mem_pattern = False  # sentences differ in length: a pattern for each only takes memory
        options.add_session_config_entry("session.model_external_initializers_file_folder_path", str(weights))
    try:
        return onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])
    except _kinds_of_failure() as problem:
        reason = str(problem).splitlines()[0][:120]
        raise MissingPartError(f"the network of the voice {whose} does not open ({reason}): reinstall it") from problem


def run_once(session: onnxruntime.InferenceSession, given: Mapping[str, NDArray[Any]]) -> list[NDArray[Any]]:
    """All outputs of one run, whose working memory is given back at its end: a long sentence takes 300 MB."""
    import onnxruntime

    options = onnxruntime.RunOptions()
    options.add_run_config_entry("memory.enable_memory_arena_shrinkage", "cpu:0")
    return [np.asarray(made) for made in session.run(None, dict(given), options)]


def _threads_left() -> int:
    """What ``OMP_NUM_THREADS`` allows: one in a worker that shares the cores with others."""
    given = os.environ.get("OMP_NUM_THREADS", "")
    return int(given) if is_whole(given) and int(given) else _THREADS


def _kinds_of_failure() -> tuple[type[Exception], ...]:
    """What onnxruntime raises on a model that it cannot read or run."""
    from onnxruntime.capi import onnxruntime_pybind11_state as state

    names = ("Fail", "InvalidArgument", "InvalidGraph", "InvalidProtobuf", "NotImplemented", "RuntimeException")
    return tuple(getattr(state, name) for name in names)
