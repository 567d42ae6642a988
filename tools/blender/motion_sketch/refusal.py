# SPDX-License-Identifier: GPL-3.0-or-later
"""Why something is not done."""


class Refused(Exception):
    """What is there cannot be made a motion: of which object or marker, what was expected, what to do next."""

    def __init__(self, where, what):
        super().__init__(f"{where}: {what}")
        self.where = where
        self.what = what
