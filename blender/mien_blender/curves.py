"""Keyframes: written at once, read back, in Blender with slots (4.4 on) and without."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

LINEAR = 1  # Blender's number for straight lines between keyframes


@dataclass(frozen=True)
class Curve:
    """One F-curve: whose it is (an ID), its path and place there."""

    owner: bpy.types.ID
    path: str
    index: int
    name: str
    """Unlike any other's of the head, the same in every performance."""


def write(title: str, curves: list[tuple[Curve, np.ndarray]], frames: np.ndarray) -> list[bpy.types.Action]:
    """Make an action (before Blender 4.4 one for each data-block) and let the owners play it."""
    made: dict[bpy.types.ID, tuple[bpy.types.Action, object]] = {}
    shared = bpy.data.actions.new(title) if "slots" in bpy.types.Action.bl_rna.properties else None
    for curve, values in curves:
        owner = curve.owner
        if owner not in made:
            made[owner] = _container(owner, shared, title)
        fcurve = made[owner][1].new(curve.path, index=curve.index)
        fcurve.keyframe_points.add(len(frames))
        flat = np.stack([frames, values], axis=1).astype(np.float32).ravel()
        fcurve.keyframe_points.foreach_set("co", flat)
        fcurve.keyframe_points.foreach_set("interpolation", np.full(len(frames), LINEAR, np.int32))
        fcurve.update()
    actions = {action.name: action for action, _ in made.values()}
    return list(actions.values())


def _container(owner: bpy.types.ID, shared: bpy.types.Action | None, title: str) -> tuple:
    data = owner.animation_data_create()
    if shared is None:
        action = bpy.data.actions.new(f"{title} {owner.name}")
        data.action = action
        return action, action.fcurves
    slot = shared.slots.new(id_type=owner.id_type, name=owner.name)
    layer = shared.layers[0] if shared.layers else shared.layers.new("mien")
    strip = layer.strips[0] if layer.strips else layer.strips.new(type="KEYFRAME")
    data.action, data.action_slot = shared, slot
    return shared, strip.channelbag(slot, ensure=True).fcurves


def played(owner: bpy.types.ID) -> dict[tuple[str, int], bpy.types.FCurve]:
    """The F-curves that an ID plays, by path and index."""
    data = owner.animation_data
    if data is None or data.action is None:
        return {}
    if not hasattr(data.action, "slots"):
        found = data.action.fcurves
    else:
        found = []
        for layer in data.action.layers:
            for strip in layer.strips:
                bag = strip.channelbag(data.action_slot) if data.action_slot else None
                found += list(bag.fcurves) if bag else []
    return {(curve.data_path, curve.array_index): curve for curve in found}


def sampled(fcurve: bpy.types.FCurve, frames: np.ndarray) -> np.ndarray:
    """A curve's values at frames."""
    return np.array([fcurve.evaluate(float(frame)) for frame in frames])
