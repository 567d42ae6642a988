# SPDX-License-Identifier: GPL-3.0-or-later
"""What is shown in the sidebar of the 3D view."""

import bpy

from . import account, acted, goals, live, operators, working


class Panel:
    """A panel of the sidebar."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Motion Sketch"


class Main(Panel, bpy.types.Panel):
    bl_idname = "VIEW3D_PT_motion_sketch"
    bl_label = "Motion Sketch"

    def draw(self, context):
        layout, settings = self.layout, context.scene.motion_sketch
        if working.current is not None:
            row = layout.row()
            row.label(text=working.current.phase, icon="TIME")
            row.operator("motion_sketch.stop", icon="CANCEL")
            return
        column = layout.column(align=True)
        column.operator("motion_sketch.make_body", icon="RIGID_BODY")
        column.operator("motion_sketch.propose", icon="MARKER_HLT")
        column = layout.column(align=True)
        column.prop(settings, "reads")
        column.prop(settings, "timing")
        if settings.timing == "WITHIN":
            column.prop(settings, "within_frames")
        column.prop(settings, "use_interval")
        if settings.use_interval:
            row = column.row(align=True)
            row.prop(settings, "first")
            row.prop(settings, "last")
        column.prop(settings, "settle_s")
        column.prop(settings, "strays_mm")
        column.prop(settings, "loops")
        layout.operator("motion_sketch.make_physical", icon="PHYSICS")
        is_on = live.is_on(context.scene)
        layout.operator("motion_sketch.live", text="Live", icon="PAUSE" if is_on else "PLAY", depress=is_on)
        if is_on and live.state.words:
            wrapped(layout, [live.state.words])
        active = context.active_object
        if active is not None and acted.is_made(active.motion_sketch.acts or active):
            layout.operator("motion_sketch.restore", icon="LOOP_BACK")
        layout.operator("motion_sketch.save_take", icon="EXPORT")


class Goal(Panel, bpy.types.Panel):
    bl_idname = "VIEW3D_PT_motion_sketch_goal"
    bl_label = "Goals"
    bl_parent_id = "VIEW3D_PT_motion_sketch"

    def draw(self, context):
        layout, active = self.layout, context.active_object
        layout.operator_menu_enum("motion_sketch.add_goal", "goal", icon="EMPTY_AXIS")
        if active is None or not goals.is_goal(active):
            return
        settings = active.motion_sketch
        column = layout.column(align=True)
        column.prop(settings, "goal")
        column.prop(settings, "body")
        if settings.goal == "FACES":
            column.prop(settings, "faces")
            column.prop(settings, "free_labels")
            return
        column.prop(settings, "event")
        if settings.goal == "POSE":
            row = column.row(align=True)
            row.prop(settings, "is_place", toggle=True)
            row.prop(settings, "is_turn", toggle=True)
            column.prop(settings, "within_mm")
        if settings.goal == "DIRECTION":
            column.prop(settings, "axis")
        if settings.goal in ("POSE", "DIRECTION"):
            column.prop(settings, "within_deg")
        if settings.goal in ("POSE", "REGION"):
            column.prop(settings, "wish_mm")


class Result(Panel, bpy.types.Panel):
    bl_idname = "VIEW3D_PT_motion_sketch_result"
    bl_label = "What It Says"
    bl_parent_id = "VIEW3D_PT_motion_sketch"

    @classmethod
    def poll(cls, context):
        return operators.said(context.scene) is not None

    def draw(self, context):
        layout, said = self.layout, operators.said(context.scene)
        wrapped(layout, account.lines(said))
        column = layout.column(align=True)
        for of in said["events"]:
            column.operator("motion_sketch.jump", text=account.when(of), icon="MARKER").frame = of["frame"]
        for of in said["suspects"]:
            row = layout.row()
            row.label(text=f"{of['quantity']}: {of['value']:.3g} {of['unit']}")
            row.operator("motion_sketch.set_free").quantity = of["quantity"]
        for name, of in said["freed"].items():
            sd = f" ± {of['sd']:.2g}" if of["sd"] is not None else ", not determined"
            layout.label(text=f"{name}: {of['value']:.3g}{sd} {of['unit']}")
        if context.scene.motion_sketch.free:
            layout.operator("motion_sketch.fix_all")


def wrapped(layout, lines, width=46):
    """Lines of text, broken where they are too long."""
    column = layout.column(align=True)
    for line in lines:
        words = line.split()
        row = ""
        for word in words:
            if row and len(row) + len(word) + 1 > width:
                column.label(text=row)
                row = "   "
            row = f"{row} {word}" if row else word
        if row:
            column.label(text=row)


CLASSES = (Main, Goal, Result)


def register():
    for of in CLASSES:
        bpy.utils.register_class(of)


def unregister():
    for of in reversed(CLASSES):
        bpy.utils.unregister_class(of)
