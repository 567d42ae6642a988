# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves of an object's action, as every version from 4.2 on has them: with slots and layers, or in the action itself."""

import bpy

HAS_SLOTS = hasattr(bpy.types, "ActionSlot")
LINEAR = bpy.types.Keyframe.bl_rna.properties["interpolation"].enum_items["LINEAR"].value


def _bag(action, slot):
    """The curves of a slot, in the first strip that has some."""
    for layer in action.layers:
        for strip in layer.strips:
            bag = strip.channelbag(slot)
            if bag is not None:
                return bag
    return None


def curves_of(animation_data):
    """All curves that move an object by its action; none where it has no action, or no slot of it."""
    action = animation_data.action if animation_data else None
    if action is None:
        return []
    if not HAS_SLOTS:
        return list(action.fcurves)
    slot = animation_data.action_slot
    bag = _bag(action, slot) if slot else None
    return list(bag.fcurves) if bag else []


def new_action(name, slot_name):
    """A new action with room for the curves of one object: the action, its slot (None without slots), and where curves go."""
    action = bpy.data.actions.new(name)
    if not HAS_SLOTS:
        action.id_root = "OBJECT"
        return action, None, action.fcurves
    slot = action.slots.new("OBJECT", slot_name)
    strip = action.layers.new("Layer").strips.new(type="KEYFRAME")
    return action, slot, strip.channelbag(slot, ensure=True).fcurves


def assign(datablock, action, slot):
    """Makes an action the one that moves a datablock."""
    data = datablock.animation_data or datablock.animation_data_create()
    data.action = action
    if HAS_SLOTS and slot is not None:
        data.action_slot = slot


def slot_of_action(datablock):
    """The slot of its action that moves a datablock; None without slots."""
    data = datablock.animation_data
    return data.action_slot if HAS_SLOTS and data else None


def write_linear(curves, path, index, frames, values):
    """A curve with a linear key at each frame."""
    curve = curves.new(path, index=index)
    points = curve.keyframe_points
    points.add(len(frames))
    flat = [0.0] * (2 * len(frames))
    flat[0::2], flat[1::2] = map(float, frames), map(float, values)
    points.foreach_set("co", flat)
    points.foreach_set("interpolation", [LINEAR] * len(frames))
    curve.update()
    return curve
