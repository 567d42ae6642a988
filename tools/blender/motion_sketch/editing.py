# SPDX-License-Identifier: GPL-3.0-or-later
"""Buttons that prepare a scene, and that look at what was made."""

import bpy
from bpy.props import EnumProperty, FloatProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from . import acted, baking, goals, live, markers, proposing, solving
from .operators import Says, read
from .properties import GOALS
from .refusal import Refused


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


CLASSES = (Propose, AddGoal, MakeBody, Jump, Restore, SaveTake)


def register():
    for of in CLASSES:
        bpy.utils.register_class(of)


def unregister():
    for of in reversed(CLASSES):
        bpy.utils.unregister_class(of)
