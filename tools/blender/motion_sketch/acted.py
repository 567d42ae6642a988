# SPDX-License-Identifier: GPL-3.0-or-later
"""What was acted: an object's own action, or that of its ghost once it was made physical."""

from .refusal import Refused


def is_made(thing):
    """Whether the action that an object has was made of another one."""
    settings, data = thing.motion_sketch, thing.animation_data
    action = data.action if data else None
    return action is not None and settings.made is not None and action == settings.made


def source(thing):
    """The object that moves as was acted, and its action; None where it has none. Refused by name where the ghost is gone."""
    if not is_made(thing):
        data = thing.animation_data
        return thing, data.action if data else None
    settings = thing.motion_sketch
    ghost = settings.ghost
    if ghost is not None and ghost.animation_data and ghost.animation_data.action is not None:
        return ghost, ghost.animation_data.action
    name = settings.acted.name if settings.acted else "the acted one"
    raise Refused(thing.name, f"its ghost is gone, expected the action {name!r} on it: undo, or assign that action again")
