# SPDX-License-Identifier: GPL-3.0-or-later
"""Readings become motions. Nothing here touches a scene: it runs in any thread."""

from dataclasses import dataclass, replace

import enact_motion
import numpy as np

from .refusal import Refused
from .toml_text import text

#: How good each verdict is.
ORDER = {"physical": 2, "plausible": 1, "failed": 0}


@dataclass
class Solved:
    """A motion and what it was made of."""

    reading: object
    estimate: object
    #: Physical time zero in seconds since the first sample.
    zero_s: float = 0.0

    @property
    def is_motion(self):
        """Whether there is a motion to show."""
        return self.estimate.verdict != "failed" and all(
            self.estimate.span(name) is not None for name in self.reading.flying
        )


def with_goals(reading, goals):
    """The text of the scene with goals."""
    whole = "".join("\n[[goal]]\n" + text(of) for of in goals)
    return reading.text + whole


def take_of(reading):
    """The take of a reading: what the command line reads where it is saved."""
    scene = enact_motion.Scene.from_toml(with_goals(reading, reading.goals))
    take = enact_motion.Take(scene)
    for name, (t, position, quaternion, held) in reading.poses.items():
        if reading.keys_within is None or held:
            take.poses(name, t, position, quaternion, order="wxyz")
        elif reading.keys_within == 0 or len(t) < 3:
            take.keyframes(name, t, position, quaternion, order="wxyz")
        else:
            # The first and the last say when it is.
            ends, inner = [0, -1], slice(1, -1)
            take.keyframes(name, t[ends], position[ends], quaternion[ends], order="wxyz")
            take.keyframes(name, t[inner], position[inner], quaternion[inner], order="wxyz", within=reading.keys_within)
    for event, t in reading.marks:
        take.mark(event, t)
    return take


def solve(reading, before=None, *, quick=False, told=None, deadline=None):
    """The motion of a reading. `before`: one of an earlier reading, from which it goes on where only goals differ.

    `quick`: without standard deviations where it goes on, and without a search for mistakes. `told` is called with the phase now and
    then; where it returns true the work ends. Raises Refused.
    """
    try:
        if quick and can_go_on(reading, before):
            found = before.estimate.update(goals=reading.goals, sd=False, told=told, deadline=deadline, chained=False)
        else:
            found = take_of(reading).estimate(diagnose=not quick, told=told, deadline=deadline)
            found = best_face(reading, found, quick, told)
    except enact_motion.SceneError as error:
        raise Refused("scene", said_of(error, reading)) from None
    except enact_motion.TakeError as error:
        raise Refused(", ".join(reading.flying), "; ".join([error.message, *error.diagnoses])) from None
    return Solved(reading, found, zero_of(found))


def preview(reading):
    """The motion of a reading as it is shown while a key is dragged: within what a hand strays of the other. Raises Refused."""
    try:
        found = take_of(reading).preview()
    except enact_motion.SceneError as error:
        raise Refused("scene", said_of(error, reading)) from None
    except enact_motion.TakeError as error:
        raise Refused(", ".join(reading.flying), error.message) from None
    return Solved(reading, found, zero_of(found))


def said_of(error, reading):
    """What is wrong with a scene, with the line of its text."""
    lines = with_goals(reading, reading.goals).splitlines()
    line = lines[error.line - 1] if 0 < error.line <= len(lines) else ""
    return f"{error.message} ({line.strip()})" if line.strip() else error.message


def can_go_on(reading, before):
    """Whether a motion of other goals leads to this one."""
    if before is None or not before.is_motion:
        return False
    at_rest = any(of["event"] == "rest" for of in (*reading.goals, *before.reading.goals))
    return not at_rest and reading.is_same_but_goals(before.reading)


def best_face(reading, found, quick, told):
    """Of several faces that may be up the one that is shown physically, nearest to what was acted."""
    for place, faces in reading.faces.items():
        for face in faces:
            goals = [dict(of) for of in reading.goals]
            goals[place]["face_up"] = face
            other = take_of(replace(reading, goals=goals)).estimate(diagnose=not quick, told=told)
            if rank(other, reading) > rank(found, reading):
                found, reading = other, replace(reading, goals=goals)
    return found


def rank(estimate, reading):
    """What is better is greater."""
    rest = estimate.report["rest"] or {}
    shows = rest.get("reached", not reading.faces)
    off = [float(np.nanmean(estimate.residuals(of).position ** 2)) for of in reading.flying] if estimate.verdict != "failed" else [np.inf]
    return shows, ORDER[estimate.verdict], -sum(off)


def zero_of(estimate):
    """Physical time zero in seconds since the first sample: where the first sample that was used is."""
    zero = estimate.report["time_map"]["physical_zero"]
    return zero["sec"] + 1e-9 * zero["nsec"]


def recording(reading):
    """The bytes of the recording of a reading."""
    try:
        return take_of(reading).to_bytes()
    except enact_motion.SceneError as error:
        raise Refused("scene", said_of(error, reading)) from None
    except enact_motion.TakeError as error:
        raise Refused(", ".join(reading.flying), error.message) from None
