# SPDX-License-Identifier: GPL-3.0-or-later
"""A thread that solves what was asked last. Nothing here touches a scene."""

import threading
import time

from . import solving
from .refusal import Refused

#: Least time between the beginnings of two solves, seconds.
BETWEEN_S = 0.033
#: A solve of what is no longer wanted goes on so long.
STALE_S = 0.5


class Worker:
    """Solves what was asked last, in a thread of its own."""

    def __init__(self):
        self.lock = threading.Condition()
        self.wanted = None
        self.found = None
        #: The last motion from which goals go on.
        self.solved = None
        self.is_working = False
        self.count = 0
        self.began = 0.0
        self.is_over = False
        self.thread = threading.Thread(target=self.run, name="motion sketch", daemon=True)
        self.thread.start()

    def ask(self, wanted):
        """Asks for a motion; what was asked before and is not begun is forgotten."""
        with self.lock:
            self.wanted = wanted
            self.lock.notify()

    def take(self):
        """What was found since the last call: a motion, a refusal, or None."""
        with self.lock:
            found, self.found = self.found, None
            return found

    @property
    def is_idle(self):
        with self.lock:
            return self.wanted is None and not self.is_working

    def wait(self, limit_s):
        """Waits until nothing is left to do; whether that came within the limit."""
        until = time.monotonic() + limit_s
        with self.lock:
            while (self.wanted is not None or self.is_working) and time.monotonic() < until:
                self.lock.wait(0.01)
            return self.wanted is None and not self.is_working

    def stop(self):
        with self.lock:
            self.is_over = True
            self.lock.notify()
        self.thread.join(5)

    def _is_stale(self, _phase):
        with self.lock:
            return self.is_over or self.wanted is not None and time.monotonic() - self.began > STALE_S

    def _is_superseded(self, _phase):
        with self.lock:
            return self.is_over or self.wanted is not None

    def run(self):
        while (wanted := self.next()) is not None:
            if solving.can_go_on(wanted, self.solved):
                self.give(solving.solve, wanted, self.solved, quick=True, told=self._is_stale)
            else:
                self.anew(wanted)
            with self.lock:
                self.is_working = False
                self.lock.notify_all()

    def anew(self, wanted):
        """What is quickly there is shown first; the motion itself is found where nothing newer is wanted."""
        self.give(solving.preview, wanted)
        if not self._is_superseded(""):
            self.give(solving.solve, wanted, quick=True, told=self._is_superseded)

    def next(self):
        """Waits for what is wanted, and until the next solve may begin; None where it is over."""
        with self.lock:
            while not self.is_over:
                pause = BETWEEN_S - (time.monotonic() - self.began)
                if self.wanted is None:
                    self.lock.wait()
                elif pause > 0:
                    self.lock.wait(pause)
                else:
                    wanted, self.wanted, self.is_working = self.wanted, None, True
                    self.began, self.count = time.monotonic(), self.count + 1
                    return wanted
        return None

    def give(self, work, *of, **how):
        """Does the work and keeps what is found, but for what was ended because it is no longer wanted."""
        try:
            found = work(*of, **how)
        except Refused as refused:
            found = refused
        except Exception as error:
            found = Refused("live", f"{type(error).__name__}: {error}")
        if isinstance(found, solving.Solved):
            if found.estimate.is_late:
                return
            if found.is_motion and work is solving.solve:
                self.solved = found
        with self.lock:
            self.found = found
