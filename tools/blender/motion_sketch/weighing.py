# SPDX-License-Identifier: GPL-3.0-or-later
"""What times mean, how far a hand strays, and what pulls."""

import numpy as np

#: Farthest that a hand is taken to stray, of the extent of a motion; and its bounds in millimetres.
STRAYS, STRAYS_MM = 0.02, (2.0, 200.0)


def free_end(events, tables, settings, units):
    """The end may move where a goal holds there and times may."""
    end = next(of for of in events if of["kind"] == "end")
    if settings.timing == "WITHIN" and any(of["event"] == end["name"] for of in tables):
        within_ms = 1e3 * settings.within_frames / units.fps
        end |= {"time": "free", "earliest_ms": -within_ms, "latest_ms": within_ms}


def timing(settings, units):
    """What the times of keys mean; a marker is on a whole frame."""
    stamps = "tempo" if settings.timing == "TEMPO" else "physical"
    frames = max(settings.within_frames, 0.5) if settings.timing == "WITHIN" else 0.5
    of = {"stamps": stamps}
    return of if stamps == "tempo" else of | {"mark_sd_ms": max(4.2, 1e3 * frames / units.fps)}


def keys_within(settings, units):
    """How far keys may be from their times; None of samples."""
    if settings.reads != "KEYS":
        return None
    return settings.within_frames / units.fps if settings.timing == "WITHIN" else 0.0


def strays(settings, bodies):
    """How far the acting is from what was meant, millimetres."""
    if settings.strays_mm > 0:
        return settings.strays_mm
    extent_mm = 1e3 * max(float(np.ptp(of.position, axis=0).max()) for of in bodies if not of.held)
    return round(float(np.clip(STRAYS * extent_mm, *STRAYS_MM)), 3)


def gravity(scene, units):
    """Metres per second squared."""
    return [units.metre * of for of in scene.gravity] if scene.use_gravity else [0.0, 0.0, 0.0]


def notes(scene, units):
    """What looks like a mistake of the scene."""
    size = np.linalg.norm(gravity(scene, units))
    if scene.use_gravity and not 9.0 < size < 10.5:
        return [f"gravity is {size:.3g} m/s²: Scene > Gravity, and Units > Unit Scale"]
    return []
