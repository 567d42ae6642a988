# SPDX-License-Identifier: GPL-3.0-or-later
"""What buttons do. What fails is said, and leaves the scene as it was."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from . import account, acted, baking, goals, handlers, live, markers, proposing, reading, solving, working
from .properties import GOALS
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


class Propose(Says, bpy.types.Operator):
    """Puts markers where the motion has kinks, and at its end"""

    bl_idname = "motion_sketch.propose"
    bl_label = "Propose Markers"

    def do(self, context):
        found = proposing.proposed(read(context))
        known = live.marks_of(context.scene)
        added = [of for of in found if not any(is_same(of, each) for each in known)]
        for name, frame in added:
            context.scene.timeline_markers.new(name, frame=frame)
        self.report({"INFO"}, f"{len(added)} markers: " + ", ".join(f"{name} {frame}" for name, frame in added))


def is_same(one, other):
    """Whether two markers mean the same: the same word, and at most two frames apart; there is one end."""
    word = one[0].split(":")[0]
    return word == markers.kind_of(other[0])[0] and (word == "end" or abs(one[1] - other[1]) <= 2)


class AddGoal(Says, bpy.types.Operator):
    """Adds a goal where the object is: an empty that says what must hold at an event"""

    bl_idname = "motion_sketch.add_goal"
    bl_label = "Add Goal"

    goal: EnumProperty(name="Goal", items=GOALS[1:])
    event: StringProperty(name="Event", default="end")

    def do(self, context):
        body = context.active_object
        if body is None or body.type != "MESH":
            raise Refused("goal", "no object is active, expected the one that moves")
        body = body.motion_sketch.acts or body
        shapes = {"POSE": "ARROWS", "REGION": "CUBE", "DIRECTION": "SINGLE_ARROW", "FACES": "PLAIN_AXES", "STILL": "SPHERE"}
        made = bpy.data.objects.new(f"{body.name} {self.goal.lower()}", None)
        made.empty_display_type = shapes[self.goal]
        made.empty_display_size = max(body.dimensions) / 2 or 1.0
        made.matrix_world = body.matrix_world.copy()
        settings = made.motion_sketch
        settings.goal, settings.body = self.goal, body
        settings.event = "rest" if self.goal == "FACES" else self.event
        context.scene.collection.objects.link(made)


class MakeBody(Says, bpy.types.Operator):
    """Gives the selected objects Rigid Body settings: what is animated is active and goes by its action, all else is passive"""

    bl_idname = "motion_sketch.make_body"
    bl_label = "Make Body"

    def do(self, context):
        things = [of for of in context.selected_objects if of.type == "MESH" and not goals.is_goal(of)]
        if not things:
            raise Refused("selection", "no mesh, expected objects that move or stand")
        for thing in things:
            is_acted = thing.animation_data is not None and thing.animation_data.action is not None
            with context.temp_override(object=thing, active_object=thing, selected_objects=[thing]):
                context.view_layer.objects.active = thing
                if thing.rigid_body is None:
                    bpy.ops.rigidbody.object_add(type="ACTIVE" if is_acted else "PASSIVE")
            thing.rigid_body.kinematic = is_acted
            if is_acted:
                thing.rigid_body.restitution = max(thing.rigid_body.restitution, 0.5)


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


class Jump(bpy.types.Operator):
    """Goes to the frame of this event"""

    bl_idname = "motion_sketch.jump"
    bl_label = "Go to Event"
    bl_options = {"INTERNAL"}

    frame: FloatProperty()

    def execute(self, context):
        whole = int(self.frame // 1)
        context.scene.frame_set(whole, subframe=self.frame - whole)
        return {"FINISHED"}


class Restore(Says, bpy.types.Operator):
    """Gives the selected objects back the action that was acted, and removes their ghosts"""

    bl_idname = "motion_sketch.restore"
    bl_label = "Back to Acted"

    def do(self, context):
        meant = {of.motion_sketch.acts or of for of in context.selected_objects}
        made = [of for of in meant if acted.is_made(of)]
        if not made:
            raise Refused("selection", "nothing was made physical, expected objects that were")
        for thing in made:
            baking.restore(thing)


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


class SaveTake(Says, bpy.types.Operator, ExportHelper):
    """Saves what was read as a recording, which the program enact reads"""

    bl_idname = "motion_sketch.save_take"
    bl_label = "Save Recording"
    bl_options = {"REGISTER"}

    filename_ext = ".mcap"
    filter_glob: StringProperty(default="*.mcap", options={"HIDDEN"})

    def do(self, context):
        data = solving.recording(read(context))
        try:
            with open(self.filepath, "wb") as file:
                file.write(data)
        except OSError as error:
            raise Refused(self.filepath, f"{error.strerror}, expected a file that can be written") from None
        self.report({"INFO"}, f"{len(data)} bytes in {self.filepath}")


CLASSES = (MakePhysical, Stop, Propose, AddGoal, MakeBody, SetFree, FixAll, Jump, Restore, Live, SaveTake)


def register():
    for of in CLASSES:
        bpy.utils.register_class(of)


def unregister():
    for of in reversed(CLASSES):
        bpy.utils.unregister_class(of)

