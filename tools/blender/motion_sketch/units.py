# SPDX-License-Identifier: GPL-3.0-or-later
"""Metres and seconds of a scene's units and frames."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Units:
    """How long a unit is, and how many frames a second has."""

    metre: float
    fps: float
    first: float

    @classmethod
    def of(cls, scene, first):
        """Those of a scene; `first` is the frame of time zero."""
        settings, render = scene.unit_settings, scene.render
        metre = 1.0 if settings.system == "NONE" else settings.scale_length
        return cls(metre, render.fps / render.fps_base, first)

    @property
    def mm(self):
        """Millimetres of one unit."""
        return 1e3 * self.metre

    def seconds(self, frame):
        """Seconds since the first sample."""
        return (frame - self.first) / self.fps

    def frame(self, seconds):
        """The frame, with its part, of seconds since the first sample."""
        return self.first + seconds * self.fps
