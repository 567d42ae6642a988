# SPDX-License-Identifier: GPL-3.0-or-later
"""What a motion says of itself, for the panel: kept with the scene as text."""

import json
import re

from . import motion

VERDICTS = {
    "physical": "physical",
    "plausible": "plausible, not quite physical",
    "failed": "failed: no motion was found",
}
FITS = {
    "yes": "it explains what was acted",
    "no": "it does not explain what was acted",
    "unknown": "whether it explains what was acted is not known",
}
#: What to do where these doubts speak against it, the first that is there.
NEXT = [
    ({"overlap", "end_touches"}, "It goes into something: mark the bounce there, or put the end before it"),
    ({"fall", "fall_direction"}, "It does not fall as things do: let the tempo be unknown, or look at gravity and units"),
]
#: A time in what is said.
WHEN = re.compile(r"at (\d+\.\d+) s\b")
#: Suspects that are shown.
SHOWN = 3


def said_of(solved):
    """All that the panel shows of a motion, a dict."""
    estimate = solved.estimate
    report = estimate.report
    return {
        "verdict": estimate.verdict,
        "reason": estimate.reason,
        "fit": estimate.fit,
        "against": [framed(solved, of) for of in (*estimate.against, *(f"nothing touches at `{of}`" for of in missed(report)))],
        "undetermined": list(estimate.undetermined),
        "events": [event(solved, of) for of in estimate.events],
        "suspects": [suspect(of) for of in report["suspects"][:SHOWN]],
        "rest": [lies(of) for of in (report["rest"] or {}).get("goals", [])],
        "notes": list(solved.reading.notes),
        "bodies": solved.reading.flying,
        "next": next_of(estimate, report),
        "freed": {name: {"value": of.value, "sd": of.sd, "unit": of.unit} for name, of in estimate.parameters.items()},
    }


def framed(solved, text):
    """The same with the frame beside each time."""
    return WHEN.sub(lambda of: f"{of[0]} (frame {motion.frame_of(solved, float(of[1])):.1f})", text)


def missed(report):
    """Collisions that a simulation from the first state does not have."""
    checks = report["verification"]
    return checks["missed"] if checks else []


def event(solved, of):
    """When it is, in frames."""
    fps = solved.reading.units.fps
    row = {"event": of.name, "frame": motion.frame_of(solved, of.time), "contact": of.contact or ""}
    return row | ({"sd_frames": of.sd * fps} if of.sd is not None else {})


def suspect(of):
    """What would explain a misfit if it were free."""
    return {key: of[key] for key in ("quantity", "value", "unit", "explains")}


def lies(of):
    """How a body lies in the end."""
    met = "as asked" if of["is_met"] else f"asked was {of['asked']}"
    return f"{of['body']} shows {of['face_up']}, {met}"


def next_of(estimate, report):
    """What to do next, in words."""
    rest = report["rest"] or {}
    if estimate.verdict == "failed":
        return "Move the marker to the impact, remove a goal, or let the tempo be unknown"
    if rest and not rest["reached"]:
        return "Let the labels be free, ask for other faces, or act another throw"
    doubts = {of["quantity"] for of in report["doubts"]}
    for quantities, words in NEXT:
        if doubts & quantities:
            return words
    if estimate.verdict == "plausible" and report["goals"]:
        return "Give a goal room (Within), make it a wish, or set the bounciness free"
    if estimate.verdict == "plausible":
        return "Look at what speaks against it; where times were acted, let the tempo be unknown"
    if report["suspects"] and estimate.fit == "no":
        return "Set free what is suspected, or look at what speaks against it"
    if estimate.against:
        return "Look at what speaks against it"
    if estimate.fit == "no":
        return "Look for a bounce without a marker: Propose Markers"
    return "Use it"


def lines(said):
    """All of it as lines of text."""
    found = [VERDICTS[said["verdict"]], FITS[said["fit"]]]
    found += [said["reason"]] if said["verdict"] != "physical" else []
    found += [f"against: {of}" for of in said["against"]] + said["rest"] + [f"note: {of}" for of in said["notes"]]
    return found + [f"next: {said['next']}"]


def when(of):
    """An event's frame with its deviation: `bounce 32.41 ± 0.2`."""
    sd = f" ± {of['sd_frames']:.2g}" if "sd_frames" in of else ""
    return f"{of['event']}  {of['frame']:.2f}{sd}"


def keep(scene, said):
    """Keeps it with the scene."""
    scene.motion_sketch.said = json.dumps(said)


def kept(scene):
    """What was said last; None where nothing was, or it cannot be read."""
    try:
        return json.loads(scene.motion_sketch.said) if scene.motion_sketch.said else None
    except ValueError:
        return None
