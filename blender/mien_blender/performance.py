"""A performance laid on a head: keyframes, sound, markers and strips; what was changed by hand is kept."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Mapping, Sequence
from difflib import SequenceMatcher
from fractions import Fraction
from pathlib import Path

import bpy
import numpy as np
from mathutils import Quaternion

from . import curves
from .hand_edits import Moved, edits_of, moved_borders
from .head_file import Motion
from .heads import Member

OURS = "mien"
"""The custom property by which strips, objects and actions are known to be mien's."""
_STILL = 1e-6


def scene_rate(scene: bpy.types.Scene) -> Fraction:
    """Frames per second, exact for the rates of film and television."""
    return Fraction(scene.render.fps / scene.render.fps_base).limit_denominator(1001)


def read_line(path: str | Path) -> dict:
    """What is said and when, of a native animation (docs/formats.md)."""
    document = json.loads(Path(path).read_text(encoding="utf-8"))
    speech = document["utterance"]
    words, phones = (speech[tier]["intervals"] if speech.get(tier) else [] for tier in ("words", "phones"))
    return {
        "text": speech["text"],
        "words": words,
        "phones": phones,
        "emotions": document["score"]["emotions"],
        "seconds": document["channels"]["frames"] / float(Fraction(document["channels"]["rate"])),
        "rate": document["channels"]["rate"],
    }


# ------------------------------------------------------------------ keyframes


def curves_of(members: Sequence[Member], motion: Motion) -> list[tuple[curves.Curve, np.ndarray]]:
    """Curves with their values; what does not move over time is set and gets no curve."""
    made = []
    for number, member in enumerate(members):
        weights = motion.weights.get(number)
        for column, key in enumerate(member.keys if weights is not None else []):
            values = weights[:, column]
            if np.ptp(values) < _STILL:
                key.value = float(values[0])
                continue
            path = f'key_blocks["{bpy.utils.escape_identifier(key.name)}"].value'
            name = f"shape {member.object.name} {key.name}"
            made.append((curves.Curve(member.object.data.shape_keys, path, -1, name), values))
        turns = motion.turns.get(number)
        if turns is not None:
            made += _turns(member, turns)
    return made


def _turns(member: Member, turns: np.ndarray) -> list[tuple[curves.Curve, np.ndarray]]:
    """A turn in the world as the quaternion that the bone or object holds: basis x rest^-1 x turned."""
    one = member.object
    holder = one.pose.bones[member.bone] if member.bone else one
    before = member.basis @ member.turn.inverted()
    values = np.array([before @ Quaternion((w, x, y, z)) for x, y, z, w in turns])
    flips = np.cumprod(np.where((values[1:] * values[:-1]).sum(axis=1) < 0, -1.0, 1.0))
    values[1:] *= flips[:, None]
    if not member.bone and OURS + "_rest" not in one:
        one[OURS + "_rest"] = list(member.basis)
    holder.rotation_mode = "QUATERNION"
    path = (
        f'pose.bones["{bpy.utils.escape_identifier(member.bone)}"].rotation_quaternion'
        if member.bone
        else "rotation_quaternion"
    )
    name = f"turn {one.name} {member.bone}"
    return [(curves.Curve(one, path, k, f"{name} {k}"), values[:, k]) for k in range(4)]


def _all_curves(members: Sequence[Member]) -> dict[str, bpy.types.FCurve]:
    """What the head plays now, by the names that `curves_of` gives."""
    found = {}
    for member in members:
        shapes = curves.played(member.object.data.shape_keys) if member.keys else {}
        for key in member.keys:
            curve = shapes.get((f'key_blocks["{bpy.utils.escape_identifier(key.name)}"].value', 0))
            if curve:
                found[f"shape {member.object.name} {key.name}"] = curve
        path = (
            f'pose.bones["{bpy.utils.escape_identifier(member.bone)}"].rotation_quaternion'
            if member.bone
            else "rotation_quaternion"
        )
        for (there, index), curve in curves.played(member.object).items():
            if there == path:
                found[f"turn {member.object.name} {member.bone} {index}"] = curve
    return found


# ------------------------------------------------------------------ what is kept from one performance to the next


def _packed(values: Mapping[str, np.ndarray]) -> dict:
    names = list(values)
    flat = np.array([values[name] for name in names], np.float32)
    return {"names": names, "data": base64.b64encode(zlib.compress(flat.tobytes())).decode("ascii")}


def _unpacked(held: Mapping) -> dict[str, np.ndarray]:
    flat = np.frombuffer(zlib.decompress(base64.b64decode(held["data"])), np.float32)
    rows = flat.reshape(len(held["names"]), -1) if held["names"] else []
    return dict(zip(held["names"], rows, strict=True))


def kept_of(head: bpy.types.Object) -> dict | None:
    """What the last performance on a head left: line, curves as mien wrote them, its frames."""
    return json.loads(head[OURS]) if OURS in head else None


def borders_moved(scene: bpy.types.Scene, head: bpy.types.Object) -> list[dict]:
    """Edits for mien's layer: phones whose markers were moved, with those of earlier performances."""
    kept = kept_of(head)
    if kept is None:
        return []
    fps, starts = float(scene_rate(scene)), {}
    for marker, (_, frame, number) in our_markers(scene):
        if number is not None and marker.frame != frame:
            starts[number] = (marker.frame - kept["start"]) / fps
    return kept["borders"] + moved_borders(kept["line"]["phones"], kept["line"]["words"], starts, 0.5 / fps)


def lay_on(
    scene: bpy.types.Scene,
    head: bpy.types.Object,
    members: Sequence[Member],
    motion: Motion,
    line: dict,
    borders: list[dict],
    keep: bool,
) -> list[str]:
    """Write a performance on a head; gives notes for the user, one line each."""
    fps, start = float(scene_rate(scene)), scene.mien.start
    made = curves_of(members, motion)
    written = {curve.name: values for curve, values in made}
    notes = []
    old = kept_of(head) if keep else None
    edits = {}
    if old is not None:
        before, now = _unpacked(old["curves"]), _all_curves(members)
        frames = old["start"] + np.arange(old["frames"]) * old["step"]
        ours = {name: curve for name, curve in now.items() if OURS in curve.id_data}  # not another action's
        edits = edits_of({name: curves.sampled(curve, frames) for name, curve in ours.items()}, before)
    if edits:
        old_fps = fps / old["step"]
        moved = Moved(old["line"], line)
        shown, have = [], {curve.name: curve for curve, _ in made}
        for name, edit in edits.items():
            carried = moved.carried(edit, old_fps, motion.seconds)
            if name not in have and carried.any():
                curve = _curve_called(name, members)
                if curve is not None:
                    made.append((curve, np.full(len(motion.seconds), 0.0)))
                    have[name] = curve
            shown.append((name, carried))
        by_name = dict(shown)
        made = [(curve, _within(curve, values + by_name.get(curve.name, 0.0))) for curve, values in made]
        notes.append(f"{len(edits)} curves edited by hand are kept")
        for word in moved.lost(edits, old_fps):
            notes.append(f"what was edited on {word!r} is lost: the line has it no longer")
    step = fps * (motion.seconds[1] - motion.seconds[0]) if len(motion.seconds) > 1 else 1.0
    step = round(step) if abs(step - round(step)) < 1e-4 else float(step)
    frames = start + np.arange(len(motion.seconds)) * step
    title = f"mien {' '.join(line['text'].split())[:40]}".strip()
    for action in curves.write(title, made, frames):
        action[OURS] = line["text"]
    head[OURS] = json.dumps(
        {
            "line": line,
            "curves": _packed(written),
            "start": start,
            "step": step,
            "frames": len(frames),
            "borders": borders,
        }
    )
    scene.frame_end = max(scene.frame_end, int(np.ceil(frames[-1])) if len(frames) else 0)
    return notes


def _within(curve: curves.Curve, values: np.ndarray) -> np.ndarray:
    if not curve.path.startswith("key_blocks"):
        return values
    key = curve.owner.path_resolve(curve.path.rsplit(".", 1)[0])
    return np.clip(values, key.slider_min, key.slider_max)


def _curve_called(name: str, members: Sequence[Member]) -> curves.Curve | None:
    for member in members:
        for key in member.keys:
            if name == f"shape {member.object.name} {key.name}":
                path = f'key_blocks["{bpy.utils.escape_identifier(key.name)}"].value'
                return curves.Curve(member.object.data.shape_keys, path, -1, name)
    return None


# ------------------------------------------------------------------ sound, markers, emotions


def strips_of(scene: bpy.types.Scene):
    """The sequencer's strips, as Blender 4.4 and later or earlier call them."""
    editor = scene.sequence_editor or scene.sequence_editor_create()
    return editor.strips if hasattr(editor, "strips") else editor.sequences


def put_sound(scene: bpy.types.Scene, path: str | Path, title: str) -> list[str]:
    """Lay the sound on the sequencer, packed into the .blend file, in the place of mien's last one."""
    strips = strips_of(scene)
    channel = 1
    for strip in list(strips):
        if strip.get(OURS) == "sound":
            channel = strip.channel
            strips.remove(strip)
    try:
        strip = strips.new_sound(title, str(path), channel, scene.mien.start)
    except RuntimeError as problem:
        return [f"no sound on the sequencer: {str(problem).strip()}"]
    strip[OURS] = "sound"
    strip.sound.pack()
    scene.sync_mode = "AUDIO_SYNC"
    return []


def our_markers(scene: bpy.types.Scene) -> list[tuple[bpy.types.TimelineMarker, list]]:
    """Markers of mien's last performance that are still there, each with its name, frame and phone as written.

    Markers hold no properties from Blender 5.0 on; they keep their order, so they are known by their names.
    """
    written, there = json.loads(scene.get(OURS + "_markers", "[]")), list(scene.timeline_markers)
    matcher = SequenceMatcher(None, [entry[0] for entry in written], [marker.name for marker in there], autojunk=False)
    blocks = matcher.get_matching_blocks()
    return [(there[block.b + k], written[block.a + k]) for block in blocks for k in range(block.size)]


def put_markers(scene: bpy.types.Scene, line: dict) -> None:
    """Markers of words and phones, in the place of mien's last ones."""
    fps, written = float(scene_rate(scene)), []
    for marker, _ in our_markers(scene):
        scene.timeline_markers.remove(marker)
    wanted = [(label, start, None) for start, _, label in line["words"]] if scene.mien.markers != "NONE" else []
    if scene.mien.markers == "BOTH":
        wanted += [(f"/{label}/", start, number) for number, (start, _, label) in enumerate(line["phones"])]
    for label, seconds, number in wanted:
        marker = scene.timeline_markers.new(label, frame=scene.mien.start + round(seconds * fps))
        written.append([marker.name, marker.frame, number])
    scene[OURS + "_markers"] = json.dumps(written)


def emotion_strips(scene: bpy.types.Scene) -> list:
    """The emotions of the line as strips."""
    if scene.sequence_editor is None:
        return []
    return [strip for strip in strips_of(scene) if strip.get(OURS) == "emotion"]


def put_emotion(scene: bpy.types.Scene, emotion: str, strength: float, start: float, end: float):
    """A strip for an emotion between two frames; its opacity is how strong it is. Muted, so that no render shows it."""
    strips = strips_of(scene)
    taken = {strip.channel for strip in strips}
    channel = next(number for number in range(2, 129) if number not in taken)
    begin, after = round(start), max(round(start) + 1, round(end))
    ends = strips.bl_rna.functions["new_effect"].parameters
    length = {"frame_end": after} if "frame_end" in ends else {"length": after - begin}
    strip = strips.new_effect(name=emotion, type="COLOR", channel=channel, frame_start=begin, **length)
    strip[OURS] = "emotion"
    strip.mute = True
    strip.blend_type = "ALPHA_OVER"
    strip.blend_alpha = strength
    return strip


def asked_emotions(scene: bpy.types.Scene, folder: Path, seconds: float | None) -> list[str]:
    """Values for ``--emotion``: from the strips where there are any, else from the panel."""
    settings, fps = scene.mien, float(scene_rate(scene))
    strips = emotion_strips(scene)
    if not strips:
        return [f"{settings.emotion}:{settings.strength:.3f}"] if settings.emotion else []
    asked = []
    for number, strip in enumerate(strips):
        emotion = strip.name.split(".")[0]
        begin, end = strip.frame_final_start, strip.frame_final_end
        first, last = (begin - settings.start) / fps, (end - settings.start) / fps
        path = strip.path_from_id("blend_alpha")
        curve = next((c for (there, _), c in curves.played(scene).items() if there == path), None)
        if curve is None:
            ending = "" if seconds is not None and last >= seconds - 0.5 / fps else f"{last:.3f}"
            starting = "" if first <= 0 else f"{first:.3f}"
            span = f"[{starting}-{ending}]" if starting or ending else ""
            asked.append(f"{emotion}{span}:{strip.blend_alpha:.3f}")
            continue
        rows = [(first - 0.3, 0.0)] if first > 0.3 else []
        rows += [((f - settings.start) / fps, curve.evaluate(f)) for f in range(begin, end)]
        rows += [(last + 0.3, 0.0)] if seconds is None or last < seconds - 0.5 / fps else []
        table = folder / f"emotion_{number}.csv"
        table.write_text("".join(f"{t:.4f},{min(max(v, 0.0), 1.0):.4f}\n" for t, v in rows if t >= 0), encoding="utf-8")
        asked.append(f"{emotion}:{table}")
    return asked
