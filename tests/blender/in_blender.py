"""Runs inside Blender: the extension on mien's face and on a made head. Started by `test_extension.py`; prints JSON."""

from __future__ import annotations

import importlib.util
import json
import os
import sys
import traceback
from pathlib import Path

import bpy
import numpy as np

FOLDER = Path(sys.argv[1])
EXTENSION = Path(__file__).parents[2] / "blender" / "mien_blender"
FACTS: dict = {"version": bpy.app.version_string}


def main() -> None:
    extension = load()
    extension.register()
    from mien_blender import curves, operators, performance
    from mien_blender.heads import members_of, objects_of

    scene = start_scene(30)
    bpy.ops.mien.add_face()
    head = scene.mien.head
    FACTS["default"] = {
        "objects": sorted(one.name for one in objects_of(head)),
        "keys": len(head.data.shape_keys.key_blocks),
    }
    scene.mien.start = 11
    bpy.ops.ed.undo_push(message="before")
    scene.mien.source, scene.mien.file = "FILE", str(FOLDER / "line.json")
    FACTS["result"] = list(bpy.ops.mien.perform())
    bpy.ops.ed.undo_push(message="performed")
    FACTS["default"] |= played(curves, members_of(scene.mien.head)[0])
    FACTS["turned"] = turned(scene)
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    FACTS["undone"] = [len(curves.played(scene.mien.head.data.shape_keys)), len(scene.timeline_markers)]

    scene.mien.source, scene.mien.text, scene.mien.emotion, scene.mien.strength = (
        "TEXT",
        "I never said that.",
        "happy",
        0.5,
    )
    bpy.ops.mien.perform()
    FACTS["sequencer"] = [
        [s.get("mien"), s.name, s.type, s.frame_final_start, s.frame_final_end, s.mute]
        for s in performance.strips_of(scene)
    ]
    FACTS["markers"] = [[m.name, m.frame] for m in scene.timeline_markers]

    # an edit by hand, a moved marker and a weaker emotion, performed again with one word more
    shapes = scene.mien.head.data.shape_keys
    brow = curves.played(shapes)[('key_blocks["browInnerUp"].value', 0)]
    said = next(m.frame for m in scene.timeline_markers if m.name == "said")
    for point in brow.keyframe_points:
        if said <= point.co.x < said + 5:
            point.co.y += 0.4
    next(s for s in performance.strips_of(scene) if s.get("mien") == "emotion").blend_alpha = 0.2
    scene.mien.text = "But I never said that."
    bpy.ops.mien.perform()
    brow = curves.played(shapes)[('key_blocks["browInnerUp"].value', 0)]
    kept = json.loads(operators.performance_holder(scene.mien.head)["mien"])
    written = performance._unpacked(kept["curves"])["shape " + scene.mien.head.name + " browInnerUp"]
    now = curves.sampled(brow, kept["start"] + np.arange(kept["frames"]))
    start = next(word[0] for word in kept["line"]["words"] if word[2] == "said")
    edited = np.flatnonzero(np.abs(now - written) > 0.05) / 30
    FACTS["again"] = {
        "said": start, "edited": [float(edited.min()), float(edited.max())], "most": float((now - written).max()),
        "emotions": kept["line"]["emotions"], "words": [word[2] for word in kept["line"]["words"]],
    }  # fmt: skip
    FACTS["shift"] = shifted(scene, performance)
    picture(scene)

    made_head(curves, members_of, scene)
    FACTS["cancelled"] = cancelled()
    extension.unregister()
    FACTS["unregistered"] = not hasattr(bpy.types.Scene, "mien")


def load():
    """The extension's package under its own name, wherever it lies."""
    spec = importlib.util.spec_from_file_location(
        "mien_blender", EXTENSION / "__init__.py", submodule_search_locations=[str(EXTENSION)]
    )
    package = importlib.util.module_from_spec(spec)
    sys.modules["mien_blender"] = package
    spec.loader.exec_module(package)
    return package


def start_scene(fps: int):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="io_scene_gltf2")
    scene = bpy.context.scene
    scene.render.fps = fps
    return scene


def played(curves, members) -> dict:
    """Every curve with its keyframes, by object (or bone) and shape (or index)."""
    found = {}
    for member in members:
        if member.keys:
            for (path, _), curve in curves.played(member.object.data.shape_keys).items():
                found[f"{member.object.name} {path.split(chr(34))[1]}"] = points(curve)
        if not member.bone:
            for (path, index), curve in curves.played(member.object).items():
                name = path.split('"')[1] if '"' in path else member.object.name
                found[f"{name} {index}"] = points(curve)
    return {"curves": found}


def points(curve) -> list:
    flat = np.empty(2 * len(curve.keyframe_points), np.float32)
    curve.keyframe_points.foreach_get("co", flat)
    return flat.reshape(-1, 2).tolist()


def turned(scene) -> dict:
    """The turn of the head's bone in the world since rest, y up, at a frame in the middle."""
    from mien_blender.heads import UP

    armature = next(one for one in scene.objects if one.type == "ARMATURE")
    bone, up = armature.pose.bones["head"], UP.to_4x4()
    rest = armature.matrix_world @ bone.bone.matrix_local
    scene.frame_set(11 + 20)
    turn = up @ (armature.matrix_world @ bone.matrix @ rest.inverted()) @ up.inverted()
    return {"head": [list(row[:3]) for row in turn.to_3x3()]}


def shifted(scene, performance) -> list:
    """A phone's marker moved by two frames: where mien's border is before and after."""
    holder = sys.modules["mien_blender.operators"].performance_holder(scene.mien.head)
    before = json.loads(holder["mien"])["line"]["phones"]
    number = next(n for n, phone in enumerate(before) if phone[2] == "S")
    next(marker for marker, (_, _, phone) in performance.our_markers(scene) if phone == number).frame += 2
    bpy.ops.mien.perform()
    return [before[number][0], json.loads(holder["mien"])["line"]["phones"][number][0]]


def made_head(curves, members_of, scene) -> None:
    """A ball with shapes of another convention, a bone and an eye; a finished line laid on."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=16, radius=0.1)
    ball = bpy.context.object
    ball.name = "Ball"
    ball.shape_key_add(name="Basis")
    for name, where, move in (
        ("AU26", -0.05, (0, 0, -0.03)),
        ("AU12_L", 0.03, (0.02, 0, 0.01)),
        ("AU45", 0.06, (0, 0, -0.01)),
    ):
        key = ball.shape_key_add(name=name)
        for vertex, point in zip(ball.data.vertices, key.data, strict=True):
            if abs(vertex.co.z - where) < 0.03 and vertex.co.y < 0:
                point.co = [a + b for a, b in zip(vertex.co, move, strict=True)]
    bpy.ops.object.armature_add(enter_editmode=False, location=(0, 0, -0.1))
    bones = bpy.context.object
    bones.data.bones[0].name = "Head"
    ball.parent = bones
    scene.mien.head, scene.mien.emotion = ball, ""
    for strip in sys.modules["mien_blender.performance"].emotion_strips(scene):
        sys.modules["mien_blender.performance"].strips_of(scene).remove(strip)
    scene.mien.source, scene.mien.file = "FILE", str(FOLDER / "line.json")
    FACTS["made_result"] = list(bpy.ops.mien.perform())
    FACTS["made"] = played(curves, members_of(ball)[0])
    FACTS["import_result"] = list(bpy.ops.mien.import_line(filepath=str(FOLDER / "line.csv")))
    FACTS["imported"] = played(curves, members_of(ball)[0])


def cancelled() -> list:
    """A job that is stopped: it ends at once, with what it started."""
    environment = sys.modules["mien_blender.environment"]
    job = environment.Job([[sys.executable, "-c", "import time; time.sleep(600)"], [sys.executable, "-c", "1"]])
    running = job.poll()
    job.stop()
    return [running, job.poll() not in (None, 0)]


def picture(scene) -> None:
    """What the docs show, if a path is given."""
    path = os.environ.get("MIEN_BLENDER_PICTURE")
    if not path:
        return
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.device, scene.cycles.use_denoising = 16, "CPU", True
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler, camera.data.lens = (0, -0.86, -0.015), (np.pi / 2, 0, 0), 70
    for name, place, power in (
        ("key", (0.6, -0.9, 0.6), 14),
        ("fill", (-0.8, -0.8, 0.1), 6),
        ("rim", (0.2, 0.8, 0.7), 10),
    ):
        lamp = bpy.data.objects.new(name, bpy.data.lights.new(name, "AREA"))
        lamp.location, lamp.data.energy, lamp.data.size = place, power, 0.5
        track = lamp.constraints.new("TRACK_TO")
        track.target = scene.mien.head
        scene.collection.objects.link(lamp)
    scene.collection.objects.link(camera)
    world = bpy.data.worlds.new("w")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs[0].default_value = (0.18, 0.2, 0.23, 1)
    scene.world = world
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y = 720, 480
    scene.frame_set(11 + 24)
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)


try:
    main()
except BaseException:
    FACTS["traceback"] = traceback.format_exc()
(FOLDER / "facts.json").write_text(json.dumps(FACTS), encoding="utf-8")
sys.stdout.flush()
os._exit(0)
