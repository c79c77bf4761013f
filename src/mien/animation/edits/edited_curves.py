"""Edited channels laid on motion."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mien.animation.edits.applied import Lost
from mien.animation.edits.edited_emotions import found_points
from mien.animation.edits.edited_places import Places
from mien.animation.edits.layer import EditLayer, channel_range
from mien.core.opposed_channels import OPPOSED, apart
from mien.core.tracks import ChannelTrack
from mien.core.utterance import Utterance
from mien.text.key_tangents import tangents_of
from mien.text.parameter_curves import ParameterCurve, lay_over

__all__ = ["with_curves"]

_SHORTEST_FADE = 1e-4  # seconds; anything shorter is at once


def with_curves(
    layer: EditLayer, utterance: Utterance, track: ChannelTrack
) -> tuple[ChannelTrack, tuple[Lost, ...], dict[str, NDArray[np.float64]]]:
    """Lay the edited channels of a layer on a track: first those that replace, in their order, then those that add.

    No model is asked. Edited channels are kept in the range of `mien.animation.edits.layer.channel_range`. A channel
    that is opposed to an edited one (`mien.core.opposed_channels`) gives way to it; where both are edited they take
    one another off, and the later edit is told as lost.

    Parameters
    ----------
    layer : EditLayer
    utterance : Utterance
        With its borders moved.
    track : ChannelTrack
        Without edits.

    Returns
    -------
    track : ChannelTrack
        The same one where nothing is edited.
    lost : tuple of Lost
    before : dict of str to ndarray, shape (frames,)
        The edited channels, and those that gave way to them, as they were.
    """
    if not layer.curves:
        return track, (), {}
    places, lost, curves = Places(layer, utterance), list[Lost](), list[ParameterCurve]()
    for number, edit in layer.curves:
        if edit.channel not in track.names:
            lost.append(Lost(number, None, f"the animation has no channel {edit.channel!r}"))
            continue
        points = found_points(number, edit.keys, places, lost, edit.tangents)
        if points:
            keys = tuple((time * 1000, value) for time, value, _ in points)
            tangents = tangents_of([tangent for *_, tangent in points], edit.interpolation) if edit.tangents else ()
            mode: Literal["set", "add"] = "set" if edit.mode == "replace" else "add"
            fade = edit.fade * 1000 if edit.fade >= _SHORTEST_FADE else 0.0
            curves.append(ParameterCurve(edit.channel, keys, edit.interpolation, mode, fade, tangents))
    if not curves:
        return track, tuple(lost), {}
    times = track.rate.times(len(track))
    values = lay_over(track.values, track.names, curves, times)
    edited = {edit.channel: number for number, edit in layer.curves if edit.channel in {c.parameter for c in curves}}
    for channel in edited:
        column, (least, most) = track.names.index(channel), channel_range(channel)
        values[:, column] = np.clip(values[:, column], least, most)
    untouched = np.full_like(values, -1.0)
    held = lay_over(untouched, track.names, [curve for curve in curves if curve.mode == "set"], times) != untouched
    pairs = [pair for pair in OPPOSED if edited.keys() & set(pair) and set(pair) <= set(track.names)]
    for one, other in pairs:
        clash = np.minimum(*(values[:, track.names.index(name)] for name in (one, other)))
        if one in edited and other in edited and clash.max(initial=0.0) > 0:
            later, first = sorted((one, other), key=edited.__getitem__, reverse=True)
            lost.append(Lost(edited[later], None, f"{later} and {first} are opposed: what both have is taken off both"))
    values = apart(values, track.names, held, pairs)
    before = {
        name: track.values[:, column].copy()
        for column, name in enumerate(track.names)
        if name in edited or (values[:, column] != track.values[:, column]).any()
    }
    return ChannelTrack(track.names, values, track.rate), tuple(lost), before
