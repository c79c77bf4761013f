"""Runs inside Blender, as a program apart: ``blender_worker.py -- IN OUT FPS BASE`` turns a GLB into an FBX or back.

Nothing of mien is imported here, and nothing of mien imports Blender.
"""

from __future__ import annotations

import os
import sys
import traceback


def convert(source: str, target: str, fps: int, base: float) -> None:
    """Read one file with Blender's own importer and write the other with its own exporter."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    for module in ("io_scene_gltf2", "io_scene_fbx"):
        bpy.ops.preferences.addon_enable(module=module)
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = fps, base
    if source.lower().endswith(".fbx"):
        bpy.ops.import_scene.fbx(filepath=source, use_anim=False)
        bpy.ops.export_scene.gltf(
            filepath=target, export_format="GLB", export_animations=False, export_morph=True, export_apply=False
        )
        return
    bpy.ops.import_scene.gltf(filepath=source)
    for one in list(bpy.data.objects):  # where the importer took a mesh away to its bones; shapes of bones
        if (one.type == "EMPTY" and not one.children) or any(
            c.name == "glTF_not_exported" for c in one.users_collection
        ):
            bpy.data.objects.remove(one)
    keys = [curve for action in bpy.data.actions for curve in action.frame_range]
    scene.frame_start, scene.frame_end = 0, round(max(keys, default=0))
    bpy.ops.export_scene.fbx(
        filepath=target, add_leaf_bones=False, path_mode="COPY", embed_textures=True, mesh_smooth_type="OFF",
        bake_anim=True, bake_anim_use_all_actions=False, bake_anim_use_nla_strips=False, bake_anim_simplify_factor=0.0,
    )  # fmt: skip


def main() -> None:
    """Convert, and leave at once: Blender as a module may hang when Python ends."""
    source, target, fps, base = sys.argv[sys.argv.index("--") + 1 :]
    try:
        convert(source, target, int(fps), float(base))
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
        os._exit(1)
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
