"""onnxruntime without its diary."""

from __future__ import annotations

import os

__all__ = ["forbid_telemetry"]


def forbid_telemetry() -> None:
    """Call this before anything imports onnxruntime.

    The runtime would keep a diary of its use in the home folder and try to send it to its makers.
    """
    os.environ["ORT_DISABLE_TELEMETRY"] = "1"
