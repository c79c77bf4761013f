"""FFmpeg's libraries, fenced in: a sound or video file is opened as what it is, and makes no other file be read.

Playlists (ffconcat, HLS, DASH) and movies with references name further files and addresses. Here nothing but the one
file can be opened: FFmpeg gets an open file and no protocol to open another with.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from mien.core.border import reading
from mien.core.errors import InputError
from mien.core.limits import check_size

if TYPE_CHECKING:
    from av.container import InputContainer

__all__ = ["open_media"]

_PLAYLISTS = {"concat", "hls", "applehttp", "dash", "imf", "sdp", "rtsp", "webm_dash_manifest"}
_NO_PROTOCOL = {"protocol_whitelist": "none"}


@contextmanager
def open_media(path: str | Path, kind: str = "a sound or video file") -> Iterator[InputContainer]:
    """Open a media file for decoding; what goes wrong inside is one line.

    Parameters
    ----------
    path : path-like
    kind : str
        What is expected, with its article, for messages.

    Raises
    ------
    InputError
        If it cannot be decoded, is a picture or a playlist, or its picture is larger than the limit ``pixels``.
    """
    import av

    path = Path(path)
    with reading(path, kind):
        if not path.is_file():
            raise InputError(f"{path}: no such file" if not path.exists() else f"{path}: expected a file")
        with path.open("rb") as file:
            try:
                container: InputContainer = av.open(file, "r", options=_NO_PROTOCOL)
            except av.FFmpegError as problem:
                raise InputError(f"{path}: expected {kind}, got something that no decoder knows") from problem
            with container:
                if container.format.name == "image2" or container.format.name.endswith("_pipe"):
                    raise InputError(f"{path}: expected {kind}, got a picture")
                if _PLAYLISTS & set(container.format.name.split(",")):
                    raise InputError(f"{path}: a list of other files ({container.format.long_name}): give those")
                for stream in container.streams.video:
                    check_size("pixels", stream.width * stream.height, path)
                yield container
