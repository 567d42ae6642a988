# SPDX-License-Identifier: GPL-3.0-or-later
"""Where markers may be: at the kinks of what was acted, and at its end."""

import enact_motion

from . import solving
from .refusal import Refused

#: Most bounces that are looked for.
MOST = 8
#: What the least of the kinks must gain over a superfluous cut, by itself and of what the greatest gains.
LEAST, LEAST_SHARE = 50.0, 1e-3
#: Kinks nearer to each other, to the beginning or to the end are the curve's, seconds.
APART_S = 0.06


def proposed(reading):
    """Names and frames of markers, in order of time."""
    try:
        take = solving.take_of(reading)
        found = [take.proposals(count) for count in range(1, MOST + 1)]
    except enact_motion.TakeError as error:
        raise Refused(", ".join(reading.flying), error.message) from None
    units, kinks = reading.units, []
    for body in reading.flying:
        first, last = (float(reading.poses[body][0][end]) for end in (0, -1))
        times = max((kinks_of(of, body, first, last) for of in found), key=len)
        name = "bounce" if len(reading.flying) == 1 else f"bounce: {body}"
        kinks += [(name, round(units.frame(of))) for of in times]
    ends = [of.t for of in found[0] if of.event == "end"]
    return sorted(kinks, key=lambda of: of[1]) + [("end", int(units.frame(of) + 1e-6)) for of in ends[:1]]


def kinks_of(proposals, body, first, last):
    """The times of all cuts of a body where each of them stands out; none otherwise."""
    own = [of for of in proposals if of.body == body]
    if not own:
        return []
    times = sorted(of.t for of in own)
    least = max(LEAST, LEAST_SHARE * max(of.score for of in own))
    are_apart = all(b - a > APART_S for a, b in zip([first, *times], [*times, last]))
    return times if are_apart and min(of.score for of in own) > least else []
