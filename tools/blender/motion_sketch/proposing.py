# SPDX-License-Identifier: GPL-3.0-or-later
"""Where markers may be: at the kinks of what was acted, and at its end."""

from . import solving
from .refusal import Refused


def proposed(reading):
    """Names and frames of markers, in order."""
    raise Refused("markers", "not yet")
