"""The panel in the sidebar of the 3D view."""

from __future__ import annotations

import bpy

from . import environment, performance
from .heads import has_shapes


class MIEN_PT_panel(bpy.types.Panel):
    """Everything, from top to bottom in the order in which it is needed."""

    bl_idname = "MIEN_PT_panel"
    bl_label = "mien"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "mien"

    def draw(self, context: bpy.types.Context) -> None:
        layout, line = self.layout, context.scene.mien
        layout.use_property_split = True
        if environment.program() is None:
            layout.label(text="mien is not on this computer", icon="ERROR")
            layout.operator("mien.install", icon="IMPORT")
            return
        head = line.head or context.object
        layout.prop(line, "head")
        if not has_shapes(head):
            layout.operator("mien.add_face", icon="USER")
            layout.operator("mien.fit_face", icon="MOD_SHRINKWRAP")
            return
        layout.row().prop(line, "source", expand=True)
        if line.source == "TEXT":
            layout.prop(line, "text")
            layout.prop(line, "voice")
        elif line.source == "SOUND":
            layout.prop(line, "sound")
            layout.prop(line, "transcript")
        else:
            layout.prop(line, "file")
        if line.source != "FILE":
            layout.prop(line, "language")
        strips = performance.emotion_strips(context.scene)
        column = layout.column(align=True)
        column.prop(line, "emotion")
        column.prop(line, "strength")
        if strips:
            column.label(text=f"{len(strips)} emotion strip(s) count; their opacity is the strength", icon="SEQUENCE")
        column.operator("mien.add_emotion", icon="ADD")
        column = layout.column(align=True)
        for name in ("start", "seed", "markers", "keep"):
            column.prop(line, name)
        row = layout.row()
        row.scale_y = 1.6
        row.operator("mien.perform", icon="PLAY")
        layout.operator("mien.import_line", icon="FILE_FOLDER")
        if line.status:
            layout.label(text=line.status)


def register() -> None:
    bpy.utils.register_class(MIEN_PT_panel)


def unregister() -> None:
    bpy.utils.unregister_class(MIEN_PT_panel)
