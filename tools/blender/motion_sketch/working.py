# SPDX-License-Identifier: GPL-3.0-or-later
"""One estimate in a thread of its own, with progress and a way to stop it."""

import threading

from . import solving
from .refusal import Refused


class Work:
    """An estimate that goes on."""

    def __init__(self, reading):
        self.reading = reading
        self.phase = "begins"
        self.is_stopped = False
        self.found = None
        self.thread = threading.Thread(target=self.run, name="motion sketch", daemon=True)
        self.thread.start()

    def told(self, phase):
        self.phase = phase
        return self.is_stopped

    def run(self):
        try:
            self.found = solving.solve(self.reading, told=self.told)
        except Refused as refused:
            self.found = refused
        except Exception as error:
            self.found = Refused("estimate", f"{type(error).__name__}: {error}")

    @property
    def is_done(self):
        return not self.thread.is_alive()


#: What goes on, for the panel; None where nothing does.
current = None
