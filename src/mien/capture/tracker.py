"""The face tracker: MediaPipe in an environment of its own, spoken to through pipes.

Its wheels need older numpy and protobuf than mien does, so it lives in a virtual environment that
`install_tracker` makes (``mien tracker install``). Where that is: ``MIEN_TRACKER``, else a folder of the user's data.
Only versions 0.10.14 to 0.10.21 carry their models in the wheel; nothing is fetched when it runs.
"""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import tempfile
import threading
import venv
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.capture import tracker_worker
from mien.core.errors import InputError, MissingPartError, OutputError

__all__ = ["Tracker", "TrackerError", "install_tracker", "shared_tracker", "tracker_folder", "tracker_python"]

_ALONE = "mediapipe==0.10.21"
# What of its stated needs the face mesh really uses; the others are 400 MB and need system libraries.
_WITH = (
    "absl-py",
    "attrs>=19.1.0",
    "flatbuffers>=2.0",
    "matplotlib",
    "numpy<2",
    "opencv-contrib-python-headless<4.12",
    "protobuf>=4.25.3,<5",
)
_PYTHONS = ((3, 9), (3, 12))  # first and last for which there is a wheel
_SECONDS_PER_FRAME = 20.0  # a frame that takes longer means that the tracker hangs
_ANSWER = 1 + tracker_worker.LANDMARKS * 3 * 4


class TrackerError(InputError):
    """The tracker's process ended, hung or could not start."""


def tracker_folder() -> Path:
    """Where the tracker's environment is, or would be."""
    given = os.environ.get("MIEN_TRACKER")
    if given:
        return Path(given)
    data = os.environ.get("XDG_DATA_HOME") or os.environ.get("LOCALAPPDATA") or str(Path.home() / ".local" / "share")
    return Path(data) / "mien" / "tracker"


def tracker_python() -> Path:
    """The interpreter of the tracker's environment.

    Raises
    ------
    MissingPartError
        If the tracker is not installed.
    """
    folder = tracker_folder()
    for python in (folder / "bin" / "python", folder / "Scripts" / "python.exe"):
        if python.exists():
            return python
    raise MissingPartError(f"the face tracker is not installed (looked in {folder}): run 'mien tracker install'")


def install_tracker(folder: Path | None = None) -> Path:
    """Make the tracker's environment with pip (about 430 MB) and try it on an empty picture; returns its folder.

    Raises
    ------
    MissingPartError
        If this Python has no wheel of the tracker.
    OutputError
        If the environment cannot be made.
    """
    if not _PYTHONS[0] <= sys.version_info[:2] <= _PYTHONS[1]:
        raise MissingPartError(
            f"the face tracker has wheels for Python 3.9 to 3.12, not for this one; make an environment "
            f"with one of those, install {_ALONE} in it, and set MIEN_TRACKER to its folder"
        )
    folder = folder or tracker_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        venv.create(folder, with_pip=True, symlinks=os.name != "nt")
    except (OSError, subprocess.CalledProcessError) as problem:
        raise OutputError(f"cannot make the tracker's environment in {folder}: {problem}") from problem
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    pip = [str(python), "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
    for arguments in (list(_WITH), ["--no-deps", _ALONE]):
        done = subprocess.run([*pip, *arguments], capture_output=True, text=True, check=False)
        if done.returncode:
            last = done.stderr.strip().splitlines()[-1:] or ["no message"]
            raise OutputError(f"cannot install the face tracker in {folder}: {last[0]}")
    with Tracker(python) as tracker:
        tracker.landmarks([np.zeros((64, 64, 3), np.uint8)])
    return folder


class Tracker:
    """A running tracker process; use it in a ``with`` block, or call `close`.

    Parameters
    ----------
    python : Path, optional
        Interpreter of an environment with mediapipe; the default is `tracker_python`.

    Raises
    ------
    TrackerError
        If it does not start.
    """

    def __init__(self, python: Path | None = None) -> None:
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115  # lives as long as the process
        command = [str(python or tracker_python()), str(Path(tracker_worker.__file__))]
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env={**os.environ, "GLOG_minloglevel": "3", "OMP_NUM_THREADS": "1"},
        )
        if self._answer(1) != b"R":
            raise TrackerError(f"the face tracker does not start: {self._last_words()}")

    def __enter__(self) -> Tracker:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def landmarks(self, frames: Iterable[NDArray[np.uint8]]) -> NDArray[np.float64]:
        """Landmarks of each picture.

        Parameters
        ----------
        frames : iterable of ndarray of uint8, shape (height, width, 3)
            RGB.

        Returns
        -------
        ndarray, shape (frames, 478, 3)
            x right, y down, in pixels; z in the scale of x, negative towards the camera; NaN where no face was found.

        Raises
        ------
        TrackerError
            If the process ends or hangs; the message names the frame.
        """
        found = [self._landmarks(number, frame) for number, frame in enumerate(frames)]
        return np.array(found, dtype=np.float64).reshape(len(found), tracker_worker.LANDMARKS, 3)

    def _landmarks(self, number: int, frame: NDArray[np.uint8]) -> NDArray[np.float32]:
        height, width, _ = frame.shape
        stream = self._process.stdin
        try:
            if stream is not None:
                stream.write(struct.pack("<II", width, height) + np.ascontiguousarray(frame).tobytes())
                stream.flush()
            answer = self._answer(_ANSWER)
        except OSError:
            answer = b""
        if len(answer) < _ANSWER:
            self.close()
            raise TrackerError(f"the face tracker ended in frame {number}: {self._last_words()}")
        points = np.frombuffer(answer[1:], np.float32).reshape(-1, 3)
        return points if answer[0] else np.full_like(points, np.nan)

    def _answer(self, size: int) -> bytes:
        stream = self._process.stdout
        watch = threading.Timer(_SECONDS_PER_FRAME, self._process.kill)
        watch.start()
        try:
            return stream.read(size) if stream is not None else b""
        finally:
            watch.cancel()

    def _last_words(self) -> str:
        if self._errors.closed:
            return "no message"
        self._errors.seek(0)
        lines = self._errors.read().decode(errors="replace").strip().splitlines()
        return lines[-1] if lines else "no message"

    @property
    def running(self) -> bool:
        """Whether the process can still answer."""
        return self._process.poll() is None

    def close(self) -> None:
        """End the process."""
        if self._process.stdin is not None and not self._process.stdin.closed:
            with suppress(BrokenPipeError):  # it has ended already
                self._process.stdin.close()
        try:
            self._process.wait(timeout=5)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


_kept: dict[int, Tracker] = {}


def shared_tracker() -> Tracker:
    """The tracker of this process and thread, started when first asked for and again after it broke."""
    key = threading.get_ident()
    tracker = _kept.get(key)
    if tracker is None or not tracker.running:
        tracker = _kept[key] = Tracker()
        _close_at_exit()
    return tracker


@cache
def _close_at_exit() -> None:
    import atexit

    atexit.register(_close_all)


def _close_all() -> None:
    for tracker in _kept.values():
        tracker.close()
