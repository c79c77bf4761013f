"""What the default face shows when a model speaks: the mouth that is scored.

A model that gives channels moves the face itself. One that gives markers, as the papers and the baselines do, is
captured first as any recording is (`mien.capture`): its markers become channels of the face.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mien.capture import Person, capture_take, fit_person
from mien.core.channels import WEIGHTS
from mien.core.errors import InputError
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.metrics.face_track import FaceTrack, landmark_names, shown_landmarks
from mien.metrics.scored_takes import Recording

__all__ = ["Stage", "constant_offsets"]

Array = NDArray[np.float64]
TAKES_FOR_A_PERSON = 30
"""Takes in which a speaker's face at rest is looked for, spread over those that there are."""


class Stage:
    """The default face, and the recorded people, so that markers of theirs can be shown on it.

    Parameters
    ----------
    ready : sequence of Recording
        In which the faces at rest are found.
    """

    def __init__(self, ready: Sequence[Recording]) -> None:
        self._ready = ready
        self._people: dict[tuple[str, tuple[str, ...]], Person] = {}

    def check(self, recording: Recording) -> None:
        """Refuse a recording whose mouth markers are not on the default face.

        Raises
        ------
        InputError
        """
        strangers = sorted(set(recording.take.markers.names) - set(landmark_names()))
        if strangers:
            raise InputError(
                f"take {recording.take.name!r}: markers {', '.join(strangers[:3])} are not on the default face"
            )

    def of_channels(self, recording: Recording, track: ChannelTrack) -> Array:
        """Where the recording's mouth markers are on the face, shape (frames, markers, 3), mm."""
        known = track.select([name for name in track.names if name in WEIGHTS])
        shown = FaceTrack("shown", shown_landmarks(known))
        return shown.places(recording.take.markers.names)

    def of_markers(self, recording: Recording, positions: Array) -> Array:
        """The same for positions of the recorded person's markers, shape (frames, markers, 3), mm."""
        markers = MarkerTrack(recording.take.markers.names, positions, recording.take.markers.rate)
        captured = capture_take(markers, recording.take.layout, head=self._person(recording))
        return self.of_channels(recording, captured.channels)

    def recorded(self, recording: Recording) -> Array:
        """The recording itself as the face shows it: how far capture follows."""
        if recording.take.channels is not None:
            return self.of_channels(recording, recording.take.channels)
        return self.of_markers(recording, recording.bridged)

    def _person(self, recording: Recording) -> Person:
        names = recording.take.markers.names
        key = recording.take.speaker, names
        if key not in self._people:
            same = [r.take.markers for r in self._ready if (r.take.speaker, r.take.markers.names) == key]
            tracks = same[:: -(-len(same) // TAKES_FOR_A_PERSON)] or [recording.take.markers]
            self._people[key] = fit_person(tracks, recording.take.layout)
        return self._people[key]


def constant_offsets(
    recorded: Mapping[str, Recording], shown: Mapping[str, Array], counted: Mapping[str, NDArray[np.bool_]]
) -> dict[str, Array]:
    """For each speaker what a row's markers are off by all the time, shape (markers, 3), mm.

    Parameters
    ----------
    recorded : mapping of str to Recording
    shown : mapping of str to ndarray, shape (frames, markers, 3)
        By take.
    counted : mapping of str to ndarray of bool, shape (frames,)
        Frames that are scored.
    """
    sums: dict[str, Array] = {}
    frames: dict[str, int] = {}
    for name, positions in shown.items():
        speaker, held = recorded[name].take.speaker, counted[name]
        away = (positions[held] - recorded[name].positions[held]).sum(axis=0)
        sums[speaker] = sums.get(speaker, 0.0) + away
        frames[speaker] = frames.get(speaker, 0) + int(held.sum())
    return {speaker: total / max(frames[speaker], 1) for speaker, total in sums.items()}
