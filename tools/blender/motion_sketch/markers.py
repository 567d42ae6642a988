# SPDX-License-Identifier: GPL-3.0-or-later
"""Markers as events: `bounce`, `through`, `start`, `end`; with names after a colon, `bounce: Die, Table`."""

import re
from dataclasses import dataclass

from .refusal import Refused

KINDS = {"bounce": "collision", "through": "waypoint", "start": "start", "end": "end"}
WORD = re.compile(r"^\s*([A-Za-z]+)(?:[.\s_-]*\d+)?\s*(?::\s*(.*))?$")


@dataclass
class Marked:
    """A marker that is an event."""

    kind: str
    frame: float
    names: tuple
    #: Its name in the scene: `bounce`, or `bounce 2` where there are several.
    event: str = ""
    #: Whether nobody made a marker of it.
    assumed: bool = False


def kind_of(name):
    """The word of a marker and the names after it; None where it is no event."""
    found = WORD.match(name)
    if found is None or found[1].lower() not in KINDS:
        return None
    names = tuple(of.strip() for of in (found[2] or "").split(",") if of.strip())
    return found[1].lower(), names


def marked(scene, sources, first, last):
    """The events of the scene's markers and of those of the actions, from the first frame to the last, in order of time.

    `sources`: each body's action, or None, by name.
    """
    found = []
    for marker in scene.timeline_markers:
        of = kind_of(marker.name)
        if of is not None:
            found.append(Marked(of[0], float(marker.frame), of[1]))
    for name, action in sources.items():
        for marker in action.pose_markers if action else ():
            of = kind_of(marker.name)
            if of is not None:
                found.append(Marked(of[0], float(marker.frame), of[1] if name in of[1] else (name, *of[1])))
    found = [of for of in found if first <= of.frame <= last]
    found.sort(key=lambda of: (of.frame, of.kind == "end"))
    return numbered(checked(found, last))


def begin(found, first):
    """Adds a start where there is none."""
    if not any(of.kind == "start" for of in found):
        found.insert(0, Marked("start", first, (), event="start", assumed=True))


def checked(found, last):
    """The same with an end; refused where there are two ends or starts, or something is after the end."""
    for word in ("start", "end"):
        several = [of.frame for of in found if of.kind == word]
        if len(several) > 1:
            raise Refused(f"marker {word!r}", f"at frames {several[0]:g} and {several[1]:g}, expected one: remove one")
    if not any(of.kind == "end" for of in found):
        found.append(Marked("end", last, (), assumed=True))
    end = next(of for of in found if of.kind == "end")
    for of in found:
        if of is not end and of.frame >= end.frame and not end.assumed:
            raise Refused(f"marker {of.kind!r}", f"at frame {of.frame:g}, not before 'end' at {end.frame:g}: move one of them")
    return found


def numbered(found):
    """The same with names of events: numbers where a word is there twice."""
    for word in KINDS:
        same = [of for of in found if of.kind == word]
        for number, of in enumerate(same, 1):
            of.event = word if len(same) == 1 else f"{word} {number}"
    return found


def event_named(found, text, where):
    """The event that a goal names; the first of several where it says no number. `rest` is after all."""
    wanted = " ".join(text.lower().replace(".", " ").split()) or "end"
    if wanted == "rest":
        return "rest"
    for of in found:
        if of.event in (wanted, f"{wanted} 1") or (wanted == f"{of.kind} 1"):
            return of.event
    known = ", ".join(dict.fromkeys([*(of.event for of in found), "rest"]))
    raise Refused(where, f"its event is {text!r}, expected a marker in the interval: {known}")


def table(of, body, other, standing, contact):
    """What a scene says of an event. `contact`: restitution and friction there."""
    event = {"name": of.event, "kind": KINDS[of.kind]}
    if of.kind in ("bounce", "through"):
        event["body"] = body
    if of.kind == "bounce":
        if other is not None:
            event["other"] = other
        if standing is not None:
            event["surface"] = standing
        event |= contact
    return event
