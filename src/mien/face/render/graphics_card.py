"""The graphics card (OpenGL 4.3 through moderngl, an extra): a context for each process, and the thread it lives in."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any, TypeVar

from mien.core.errors import MissingPartError

__all__ = ["GraphicsCard", "graphics_card"]

_LEAST_GL = 430
_Result = TypeVar("_Result")


class GraphicsCard:
    """An OpenGL context without a window, and the one thread that may use it.

    Attributes
    ----------
    context : moderngl.Context
    name : str
        Of what draws, as its driver says; Mesa's llvmpipe is no card but the processor again.
    """

    def __init__(self, moderngl: Any) -> None:
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="mien-graphics")
        backend = {"backend": "egl"} if sys.platform.startswith("linux") else {}
        self.context: Any = self.do(lambda: moderngl.create_context(standalone=True, require=_LEAST_GL, **backend))
        self.context.gc_mode = "context_gc"  # what no renderer needs any more is freed in the thread, by `do`
        self.name = str(self.do(lambda: self.context.info["GL_RENDERER"]))

    def do(self, work: Callable[[], _Result]) -> _Result:
        """The result of ``work``, done in the context's thread, after what others asked for before."""
        return self._thread.submit(work).result()


def graphics_card() -> GraphicsCard:
    """The card of this process.

    Raises
    ------
    MissingPartError
        If moderngl is not installed, or there is no OpenGL 4.3 without a window.
    """
    return _card(os.getpid())


@cache
def _card(process: int) -> GraphicsCard:
    try:
        import moderngl
    except ImportError:
        raise MissingPartError(
            "the painter gpu needs the package moderngl, which is not installed: pip install 'mien[gpu]', "
            "or --painter processor"
        ) from None
    try:
        return GraphicsCard(moderngl)
    except Exception as problem:  # of many kinds, of the driver's and moderngl's making
        said = " ".join(str(problem).split())
        raise MissingPartError(
            f"the painter gpu needs OpenGL 4.3 through EGL ({said}): install the card's driver, "
            "or Mesa (Debian: apt install libegl1 libgl1-mesa-dri), or --painter processor"
        ) from problem
