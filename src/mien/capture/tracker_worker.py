"""The process that finds the face's landmarks in pictures; runs in the tracker's own environment, without mien.

Frames in on standard input: width and height as 32-bit little-endian numbers, then the pixels (RGB, 8 bit); width 0
ends. Answers out on standard output: one byte (1: a face was found), then 478 times x, y, z as 32-bit floats in pixels
of the frame (z has the scale of x, negative towards the camera), zeros without a face. Every frame is looked at by
itself: the smoothing of the tracker's video mode blunts the closures of the lips.
"""

from __future__ import annotations

import struct
import sys
from typing import Any

LANDMARKS = 478


def main() -> None:
    """Answer frame after frame."""
    import mediapipe  # type: ignore[import-not-found]  # lives in the tracker's environment only
    import numpy as np

    mesh: Any = mediapipe.solutions.face_mesh.FaceMesh(
        static_image_mode=True, max_num_faces=1, refine_landmarks=True, min_detection_confidence=0.5
    )
    incoming, outgoing = sys.stdin.buffer, sys.stdout.buffer
    outgoing.write(b"R")  # ready
    outgoing.flush()
    while True:
        header = incoming.read(8)
        if len(header) < 8:
            return
        width, height = struct.unpack("<II", header)
        if width == 0:
            return
        picture = np.frombuffer(incoming.read(3 * width * height), np.uint8).reshape(height, width, 3)
        faces = mesh.process(picture).multi_face_landmarks
        points = np.zeros((LANDMARKS, 3), np.float32)
        if faces:
            points[:] = [(p.x * width, p.y * height, p.z * width) for p in faces[0].landmark]
        outgoing.write((b"\x01" if faces else b"\x00") + points.tobytes())
        outgoing.flush()


if __name__ == "__main__":
    main()
