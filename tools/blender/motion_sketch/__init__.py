# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion Sketch: act a motion, and it becomes a physical one that meets its goals."""

from . import editing, handlers, operators, panel, properties

PARTS = (properties, operators, editing, panel, handlers)


def register():
    for part in PARTS:
        part.register()


def unregister():
    for part in reversed(PARTS):
        part.unregister()
