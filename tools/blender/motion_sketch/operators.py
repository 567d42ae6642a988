# SPDX-License-Identifier: GPL-3.0-or-later
"""Buttons that make a motion. What fails is said, and leaves the scene as it was."""

import bpy
from bpy.props import BoolProperty, StringProperty

from . import account, baking, handlers, live, reading, solving, working
from .refusal import Refused

#: What was said of a motion that was not written, by scene: it is not kept with the file.
unkept = {}


def said(scene):
    """What was said last."""
    return unkept.get(scene.session_uid) or account.kept(scene)


def read(context):
    """What is in the scene, as a reading."""
    context.view_layer.update()
    chosen = reading.bodies_wanted(context.scene, context.selected_objects, context.active_object)
    return reading.read(context.scene, chosen)


def written(scene, solved):
    """Writes a motion, or says why there is none; the level of what is said and its words."""
    words = account.said_of(solved)
    if not solved.is_motion:
        unkept[scene.session_uid] = words
        return "ERROR", f"{solved.estimate.reason}. {words['next']}"
    baking.bake(scene, solved, scene.motion_sketch.loops)
    unkept.pop(scene.session_uid, None)
    account.keep(scene, words)
    level = "INFO" if words["verdict"] == "physical" and not words["against"] else "WARNING"
    return level, f"{account.VERDICTS[words['verdict']]}; {account.FITS[words['fit']]}"


class Says:
    """Of an operator: what is refused is an error."""

    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        try:
            return self.do(context) or {"FINISHED"}
        except Refused as refused:
            self.report({"ERROR"}, str(refused))
            return {"CANCELLED"}


class MakePhysical(Says, bpy.types.Operator):
    """Makes the selected objects' motion physical, in a new action; what was acted stays on a ghost"""

    bl_idname = "motion_sketch.make_physical"
    bl_label = "Make Physical"

    of_live: BoolProperty(options={"HIDDEN", "SKIP_SAVE"})

    def do(self, context):
        if self.of_live and live.state is not None:
            context.view_layer.update()
            taken = reading.read(context.scene, live.chosen_of(context.scene))
        else:
            taken = read(context)
        return self.end(context, solving.solve(taken))

    def end(self, context, solved):
        if isinstance(solved, Refused):
            raise solved
        level, words = written(context.scene, solved)
        self.report({level}, words)
        return {"CANCELLED"} if level == "ERROR" else {"FINISHED"}

    def invoke(self, context, _event):
        if bpy.app.background:
            return self.execute(context)
        if working.current is not None:
            self.report({"ERROR"}, "an estimate goes on, expected its end: Stop, or wait")
            return {"CANCELLED"}
        try:
            working.current = working.Work(read(context))
        except Refused as refused:
            self.report({"ERROR"}, str(refused))
            return {"CANCELLED"}
        self.timer = context.window_manager.event_timer_add(0.05, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        work = working.current
        if event.type == "ESC":
            work.is_stopped = True
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        context.workspace.status_text_set(f"Motion Sketch: {work.phase} (Esc stops)")
        if not work.is_done:
            return {"PASS_THROUGH"}
        working.current = None
        context.window_manager.event_timer_remove(self.timer)
        context.workspace.status_text_set(None)
        if work.is_stopped:
            self.report({"WARNING"}, "stopped: the scene is as it was")
            return {"CANCELLED"}
        try:
            return self.end(context, work.found)
        except Refused as refused:
            self.report({"ERROR"}, str(refused))
            return {"CANCELLED"}


class Stop(bpy.types.Operator):
    """Stops the estimate that goes on; the scene stays as it is"""

    bl_idname = "motion_sketch.stop"
    bl_label = "Stop"

    @classmethod
    def poll(cls, _context):
        return working.current is not None

    def execute(self, _context):
        working.current.is_stopped = True
        return {"FINISHED"}


class SetFree(Says, bpy.types.Operator):
    """Lets this be estimated, and makes the motion again"""

    bl_idname = "motion_sketch.set_free"
    bl_label = "Set Free"

    quantity: StringProperty()

    def do(self, context):
        settings = context.scene.motion_sketch
        before = settings.free
        settings.free = "|".join(dict.fromkeys([*(of for of in before.split("|") if of), self.quantity]))
        try:
            level, words = written(context.scene, solving.solve(read(context)))
        except Refused:
            settings.free = before
            raise
        if level == "ERROR":
            settings.free = before
        self.report({level}, words)
        return {"CANCELLED"} if level == "ERROR" else {"FINISHED"}


class FixAll(Says, bpy.types.Operator):
    """Takes everything as the scene has it again"""

    bl_idname = "motion_sketch.fix_all"
    bl_label = "Set Nothing Free"

    def do(self, context):
        context.scene.motion_sketch.free = ""


class Live(Says, bpy.types.Operator):
    """Shows the path while a key, a goal, a marker or a surface is dragged; the motion is made once it rests"""

    bl_idname = "motion_sketch.live"
    bl_label = "Live"
    bl_options = {"REGISTER"}

    def do(self, context):
        if live.is_on(context.scene):
            live.end()
            return
        context.view_layer.update()
        chosen = reading.bodies_wanted(context.scene, context.selected_objects, context.active_object)
        solving.recording(reading.read(context.scene, chosen, is_live=True))
        live.begin(context.scene, chosen)
        handlers.start_timer()


CLASSES = (MakePhysical, Stop, SetFree, FixAll, Live)


def register():
    for of in CLASSES:
        bpy.utils.register_class(of)


def unregister():
    for of in reversed(CLASSES):
        bpy.utils.unregister_class(of)
