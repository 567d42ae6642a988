# SPDX-License-Identifier: GPL-3.0-or-later
"""What is called when something changes: handlers, the timer, and what draws paths."""

import bpy
from bpy.app.handlers import persistent

from . import live

#: Seconds between two ticks.
TICK_S = 1 / 60
_drawn = None


@persistent
def changed(scene, depsgraph):
    live.note(scene, depsgraph)


@persistent
def forget(*_):
    """Another file is there."""
    live.end()


def timer():
    """Looks for changes, as long as something is followed."""
    if live.state is None:
        return None
    scene = bpy.context.scene
    if live.tick(scene) == "final":
        make_final(scene)
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()
    return TICK_S


def make_final(scene):
    """The motion once nothing changes any more, with a step of undo."""
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, scene=scene):
        try:
            bpy.ops.motion_sketch.make_physical("EXEC_DEFAULT", True, of_live=True)
        except RuntimeError as error:
            # What is refused is said by the operator, and the scene stays as it was.
            live.state.words = str(error).strip()


def start_timer():
    if not bpy.app.timers.is_registered(timer):
        bpy.app.timers.register(timer, first_interval=TICK_S)


def draw():
    """The paths, over all else."""
    if live.state is None or not live.state.paths:
        return
    import gpu
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    shader.bind()
    shader.uniform_float("color", (1.0, 0.55, 0.1, 1.0))
    for path in live.state.paths.values():
        batch_for_shader(shader, "LINE_STRIP", {"pos": [tuple(of) for of in path]}).draw(shader)


def register():
    global _drawn
    bpy.app.handlers.depsgraph_update_post.append(changed)
    bpy.app.handlers.load_pre.append(forget)
    if not bpy.app.background:
        _drawn = bpy.types.SpaceView3D.draw_handler_add(draw, (), "WINDOW", "POST_VIEW")


def unregister():
    global _drawn
    live.end()
    if bpy.app.timers.is_registered(timer):
        bpy.app.timers.unregister(timer)
    if _drawn is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_drawn, "WINDOW")
        _drawn = None
    bpy.app.handlers.load_pre.remove(forget)
    bpy.app.handlers.depsgraph_update_post.remove(changed)
