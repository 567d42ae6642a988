# SPDX-License-Identifier: GPL-3.0-or-later
"""What a file keeps: settings of a scene, goals and pointers of objects."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from . import live
from .goals import AXES

GOALS = [
    ("NONE", "None", "No goal"),
    ("POSE", "Pose", "The object is where this is, and turned as this is"),
    ("REGION", "Region", "The object's origin is within this box"),
    ("DIRECTION", "Direction", "An axis of the object points along this arrow"),
    ("FACES", "Faces", "One of these sides is up when all has come to rest"),
    ("STILL", "At rest", "The object neither moves nor turns then"),
]
READS = [
    ("MOTION", "Motion", "All of the action between its keys: recorded, or keyed closely"),
    ("KEYS", "Keys", "The keys alone: a few poses of each flight"),
]
TIMINGS = [
    ("PHYSICAL", "As keyed", "Times are those of the motion itself"),
    ("TEMPO", "Unknown tempo", "It was acted slower, faster or unevenly; times are found"),
    ("WITHIN", "Within frames", "Keys and markers are within so many frames of their times"),
]


def touched(_self, _context):
    live.touched()


class ObjectSettings(bpy.types.PropertyGroup):
    """Of an object: what it asks as a goal, and what it was made of."""

    goal: EnumProperty(name="Goal", items=GOALS, default="NONE", update=touched)
    event: StringProperty(name="Event", description="A marker: end, bounce, bounce 2, through", default="end", update=touched)
    body: PointerProperty(name="Body", description="Of which object; of the only one", type=bpy.types.Object, update=touched)
    axis: EnumProperty(name="Axis", items=[(of, of.upper(), "") for of in AXES], default="+z", update=touched)
    faces: StringProperty(name="Faces", description="Sides that may be up: +z, -x", default="+z", update=touched)
    free_labels: BoolProperty(
        name="Free labels",
        description="Which side is called what may change: the motion stays as acted",
        default=False,
        update=touched,
    )
    is_place: BoolProperty(name="Place", default=True, update=touched)
    is_turn: BoolProperty(name="Turn", default=True, update=touched)
    within_mm: FloatProperty(name="Within (mm)", description="How far off it may be; 0: exactly there", min=0, update=touched)
    within_deg: FloatProperty(name="Within (°)", description="How far turned off it may be; 0: exactly so", min=0, max=180, update=touched)
    wish_mm: FloatProperty(name="Wish (mm)", description="As a wish: standard deviation; 0: it must hold", min=0, update=touched)
    acts: PointerProperty(name="Acts", description="This is the ghost of that object", type=bpy.types.Object)
    ghost: PointerProperty(name="Ghost", type=bpy.types.Object)
    acted: PointerProperty(name="Acted", type=bpy.types.Action)
    made: PointerProperty(name="Made", type=bpy.types.Action)


class SceneSettings(bpy.types.PropertyGroup):
    """Of a scene: how it is read, and what was said of it last."""

    use_interval: BoolProperty(name="Interval", description="Only frames from First to Last", default=False, update=touched)
    first: IntProperty(name="First", default=1, update=touched)
    last: IntProperty(name="Last", default=250, update=touched)
    reads: EnumProperty(name="Read", items=READS, default="MOTION", update=touched)
    timing: EnumProperty(name="Timing", items=TIMINGS, default="PHYSICAL", update=touched)
    within_frames: FloatProperty(name="Frames", min=0.01, soft_max=10, default=2, update=touched)
    settle_s: FloatProperty(name="Settle", description="Seconds that it goes on by simulation after its end", min=0, max=60, update=touched)
    strays_mm: FloatProperty(
        name="Strays (mm)",
        description="How far the acting is from what was meant; 0: a fiftieth of its extent",
        min=0,
        update=touched,
    )
    loops: IntProperty(name="Times", description="How often it is repeated in the new action", min=1, max=1000, default=1)
    free: StringProperty(name="Free", description="Quantities that are estimated, between bars")
    said: StringProperty(name="Said", description="What was said of the last motion, as JSON")


CLASSES = (ObjectSettings, SceneSettings)


def register():
    for of in CLASSES:
        bpy.utils.register_class(of)
    bpy.types.Object.motion_sketch = PointerProperty(type=ObjectSettings)
    bpy.types.Scene.motion_sketch = PointerProperty(type=SceneSettings)


def unregister():
    del bpy.types.Scene.motion_sketch
    del bpy.types.Object.motion_sketch
    for of in reversed(CLASSES):
        bpy.utils.unregister_class(of)
