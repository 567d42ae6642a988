"""Estimates, and the records that they are told in."""

import math
from collections import namedtuple

from . import _arrays

Impact = namedtuple(
    "Impact", "contact point normal impulse moment approach_speed slip_speed parting_speed slip_speed_after"
)
Impact.__doc__ = """What happens at one contact of a collision, to the event's first body against what it hits; world axes.

``contact``: what touches. ``point``: where, three metres. ``normal``: unit, towards the body. ``impulse``: on the body, N s.
``moment``: on it beside the impulse, N m s. ``approach_speed``, ``parting_speed``: along the normal, before and after, m/s.
``slip_speed``, ``slip_speed_after``: across it.
"""

Parameter = namedtuple("Parameter", "value sd determined unit lower upper at_bound")
Parameter.__doc__ = """A free quantity as estimated, in its ``unit`` ("" of ratios).

``sd``: its standard deviation, None where it is not determined. ``lower``, ``upper``: least and greatest value allowed.
``at_bound``: "lower", "upper" or "cone" where it is there, else None.
"""

Motion = namedtuple("Motion", "t position quaternion velocity angular_velocity")
Motion.__doc__ = """The motion of a body: of the frame in which the scene gives it.

``t`` (n,): physical seconds. ``position`` (n, 3): of the frame's origin, world, metres. ``quaternion`` (n, 4): w x y z, world from
the frame. ``velocity`` (n, 3): of that origin, world, m/s. ``angular_velocity`` (n, 3): about the frame's axes, rad/s. Of a single
time all have one axis less.
"""

Residuals = namedtuple("Residuals", "acted t position rotation")
Residuals.__doc__ = """What a track saw less what the motion shows, sample by sample.

``acted`` (n,), ``t`` (n,): acted and physical seconds. ``position`` (n, 3): of the centre of mass or of the point that is seen, world,
metres. ``rotation`` (n, 3): rotation vector about the body's principal axes, radians. NaN of what the track does not see.
"""

Proposal = namedtuple("Proposal", "event t body score")
Proposal.__doc__ = """Where an event may be: ``t`` seconds since the first sample.

``event``: its name in the scene, None where another count was asked for. ``body``: whose motion has the kink, and ``score``: what
the cut there gains over a superfluous one; None of starts and ends.
"""

TimeMap = namedtuple("TimeMap", "acted physical")
TimeMap.__doc__ = """``acted`` (n,) against ``physical`` (n,) seconds of a track's samples."""


class Event(namedtuple("Event", "name kind time sd determined acted at_bound bodies contact impacts")):
    """An event as estimated.

    ``kind``: "start", "collision", "change", "waypoint" or "end". ``time``: physical seconds, ``sd`` its standard deviation, None
    where it is fixed or not determined. ``acted``: acted seconds. ``bodies``: whom it concerns. ``contact``: what touches, or None.
    ``impacts``: an :class:`Impact` for each contact.
    """

    __slots__ = ()

    @property
    def impulse(self):
        """The sum of all impulses on the first body, three N s; None where nothing hits."""
        if not self.impacts:
            return None
        return tuple(math.fsum(axis) for axis in zip(*(of.impulse for of in self.impacts)))

    @property
    def contact_point(self):
        """Where the first contact is, three metres; None where nothing hits."""
        return self.impacts[0].point if self.impacts else None

    @property
    def approach_speed(self):
        """How fast the first contact closes, m/s; None where nothing hits."""
        return self.impacts[0].approach_speed if self.impacts else None


def _number(value):
    # JSON has no number that is not finite.
    return math.nan if value is None else value


def _event(of):
    impacts = tuple(
        Impact(
            impact["contact"],
            tuple(impact["point_m"]),
            tuple(impact["normal"]),
            tuple(map(_number, impact["impulse_n_s"])),
            tuple(map(_number, impact["moment_n_m_s"])),
            *(_number(impact[key]) for key in ("approach_m_s", "slip_m_s", "parting_m_s", "slip_after_m_s")),
        )
        for impact in of["impacts"]
    )
    return Event(
        of["name"],
        of["kind"],
        _number(of["time_s"]),
        of["time_sd_s"],
        of["time_is_determined"],
        of["acted_s"],
        of["time_at_bound"],
        tuple(of["bodies"]),
        of["contact"],
        impacts,
    )


def _parameter(of):
    lower, upper = of["bounds"]
    return Parameter(
        _number(of["value"]),
        of["sd"],
        of["sd"] is not None,
        of["unit"],
        -math.inf if lower is None else lower,
        math.inf if upper is None else upper,
        of["at_bound"],
    )


class Estimate:
    """A motion that fits a take best and is physically correct; what speaks against that, and how certain it is.

    Made by :meth:`Take.estimate`. Immutable. It pickles as its take and all that it says; what needs the motion itself
    (:meth:`sample`, :meth:`at`, :meth:`residuals`, :meth:`write`) makes that again from the take when it is first asked
    for, to the same bits, and is refused of an estimate that its deadline ended.
    """

    __slots__ = ("_base", "_core", "_options", "_said", "_take", "_text")

    def __init__(self):
        raise TypeError("expected take.estimate()")

    @classmethod
    def _of(cls, take, options, core, *, text=None, is_late=False, base=None):
        of = object.__new__(cls)
        if core is not None:
            is_late = core.is_late
        # Of a preview there are no options.
        options = (*(options or (None, None)), is_late)
        parts = {"_base": base, "_core": core, "_options": options, "_said": None, "_take": take, "_text": text}
        for name, value in parts.items():
            object.__setattr__(of, name, value)
        return of

    def __setattr__(self, name, value):
        raise AttributeError(f"{name}: an estimate is immutable")

    @property
    def report(self):
        """All that it says: the JSON of its file (``docs/report.md``) as a dict, a copy each time."""
        import json

        return json.loads(self._words())

    def _words(self):
        if self._text is None:
            object.__setattr__(self, "_text", self._core.report())
        return self._text

    def _of_report(self, key):
        if self._said is None:
            object.__setattr__(self, "_said", self.report)
        return self._said[key]

    @property
    def take(self):
        """What it is an estimate of."""
        return self._take

    @property
    def verdict(self):
        """"physical", "plausible" or "failed"; :attr:`reason` says why."""
        return self._of_report("verdict")

    @property
    def reason(self):
        """Why the estimation ended, a sentence."""
        return self._of_report("reason")

    @property
    def fit(self):
        """Whether the motion explains the performance: "yes", "unknown" or "no"."""
        return self._of_report("fits")

    @property
    def against(self):
        """What speaks against the motion, the gravest first, and likely mistakes: sentences."""
        doubts = [of["text"] for of in self._of_report("doubts")]
        return (*doubts, *(of["sentence"] for of in self._of_report("diagnoses")))

    @property
    def events(self):
        """What happens: a tuple of :class:`Event` in order of time."""
        return tuple(map(_event, self._of_report("events")))

    @property
    def parameters(self):
        """The scene's free quantities, and what was set free: a dict of :class:`Parameter` by name."""
        return {name: _parameter(of) for name, of in self._of_report("parameters").items()}

    @property
    def undetermined(self):
        """Names of what the performance does not determine."""
        return tuple(self._of_report("undetermined"))

    @property
    def is_late(self):
        """Whether its deadline ended it."""
        return self._options[2]

    @property
    def is_warm(self):
        """Whether :meth:`update` made it from another estimate."""
        return self._made().is_warm

    @property
    def spent(self):
        """How long each phase of the run took: a dict of seconds by name."""
        return dict(self._made().spent)

    @property
    def time_map(self):
        """Acted time against physical time: a dict of :class:`TimeMap` by track."""
        import numpy as np

        of_tracks = {}
        for of in self._of_report("time_map")["bodies"]:
            pair = [np.array(of[key], dtype=np.float64) for key in ("acted_s", "physical_s")]
            for times in pair:
                times.flags.writeable = False
            of_tracks[of["body"]] = TimeMap(*pair)
        return of_tracks

    def span(self, body=None):
        """From when to when the motion of a body is known, two seconds; None where it has none."""
        span = self._made().span(self._body(body))
        return None if span is None else tuple(span)

    def sample(self, rate, body=None):
        """The :class:`Motion` of a body ``rate`` times a second: at the whole multiples of 1/rate within :meth:`span`.

        ``body`` may be left out where the scene has one. Raises ValueError for a rate that is not of 0.001 to 100 000, and where
        the body has no motion.
        """
        import numpy as np

        rate = float(rate)
        if not 1e-3 <= rate <= 1e5:
            raise ValueError(f"rate: {rate}, expected 0.001 to 100000 Hz")
        span = self.span(body)
        if span is None or not (math.isfinite(span[0]) and math.isfinite(span[1])):
            raise ValueError(f"body: {self._body(body)!r} has no motion; the verdict is {self.verdict}")
        first, last = math.ceil(span[0] * rate), math.floor(span[1] * rate)
        if last - first > 1e7:
            raise ValueError(f"rate: {last - first} frames, expected 10 million at most")
        return self.at(np.arange(first, last + 1) / rate, body)

    def at(self, t, body=None):
        """The :class:`Motion` of a body at ``t``: one time or (n,) of them, physical seconds.

        At an impact it is that before it. Beyond :meth:`span` flights are continued.
        """
        import numpy as np

        times = _arrays.array("t", t, "() or (n,)", lambda shape: len(shape) < 2)
        states = _arrays.rows(self._made().states(self._body(body), times.tobytes()), 13)
        if len(states) != times.size:
            raise ValueError(f"body: {self._body(body)!r} has no motion; the verdict is {self.verdict}")
        if times.ndim == 0:
            states = states[0]
        parts = (states[..., a:b] for a, b in ((0, 3), (3, 7), (7, 10), (10, 13)))
        return Motion(np.frombuffer(times.tobytes()).reshape(times.shape), *parts)

    def simulated(self, body=None):
        """What is simulated after the end until it rests (``settle_s``): t (n,), position (n, 3), quaternion (n, 4), as in :class:`Motion`.

        Empty where the scene asks for none. The first row is at the end of the motion; bounces between rows are not shown exactly.
        """
        rows = _arrays.rows(self._made().simulated(self._body(body)), 8)
        return rows[:, 0], rows[:, 1:4], rows[:, 4:8]

    def residuals(self, track=None):
        """What a track saw less what the motion shows: :class:`Residuals`, of all samples that were used.

        ``track`` may be left out where the scene has one.
        """
        track = self._only("track", track, self._take.scene.tracks)
        rows = _arrays.rows(self._made().residuals(track), 8)
        return Residuals(rows[:, 0], rows[:, 1], rows[:, 2:5], rows[:, 5:8])

    @property
    def numbers(self):
        """The names that :meth:`covariance` takes: events, parameters, and the states of flights.

        Of an event it is the time. ``<body>.flight.<n>.<part>.<axis>``, n from 1, is of the state of a flight at its epoch
        (``report["arcs"]``): ``position`` and ``velocity`` of the centre of mass, world axes; ``orientation``, a rotation vector
        on the right, and ``angular_velocity`` about the principal axes. Empty where nothing tells how certain the motion is: of
        one that failed, of joined bodies, of several groups of bodies that never meet.
        """
        return tuple(self._varied()[0])

    def covariance(self, names=None):
        """The covariances (n, n) of numbers, in the order of their names, :attr:`numbers` by default.

        Units are seconds for events, those of :attr:`parameters`, and SI for states. A fixed number has zeros, one that is not
        determined NaN. The diagonal has the squares of the ``sd`` of events and parameters. Raises KeyError for another name.
        """
        import numpy as np

        known, data = self._varied()
        whole = _arrays.rows(data, max(len(known), 1))
        if names is None:
            return whole
        place = {name: at for at, name in enumerate(known)}
        for name in names:
            if name not in place:
                raise KeyError(f"names: no {name!r}, expected names of estimate.numbers")
        at = [place[name] for name in names]
        chosen = whole[np.ix_(at, at)]
        chosen.flags.writeable = False
        return chosen

    def update(self, *, goals, sd=True, deadline=None, told=None, chained=True):
        """The estimate of the same take with other goals, from this one on: the live path of an editor.

        ``goals``: a list of dicts with the keys of ``[[goal]]`` (``docs/goals.md``), in place of all of the scene's. ``sd``: whether
        standard deviations are told, which takes most of the time; without, nothing is said to be determined, and
        :meth:`covariance` tells them later. ``deadline``, ``told``: as for :meth:`Take.estimate`. The same optimum to the solver's tolerance, in a few steps, samples weighed as in this
        one; checked for gaps and overlaps, and not asked whether it fits. Where that leads nowhere (:attr:`is_warm`) it is estimated
        anew. ``chained``: whether it keeps this one, of which it can be made again once it was pickled; who updates without end and
        pickles nothing says False. Raises :class:`SceneError` for a goal that is refused.

        >>> import enact_motion
        >>> estimate = enact_motion.read("recordings/pencil_tip.mcap").estimate()
        >>> goals = estimate.take.scene.goals
        >>> goals[0]["position_mm"][0] += 5
        >>> updated = estimate.update(goals=goals)
        >>> updated.is_warm, updated.verdict
        (True, 'physical')
        """
        import json

        def plain(of):
            return of.tolist()

        core = self._take.scene._core.with_goals(json.dumps(list(goals), default=plain))
        free, diagnose = map(bool, self._options[:2])
        found = self._made().update(core, bool(sd), free, diagnose, _arrays.limit(deadline), told)
        return Estimate._of(self._take._in_scene(core), (free, diagnose), found, base=(self if chained else None, bool(sd)))

    def write(self, path):
        """Writes the recording with the estimate beside it: byte for byte what ``enact replay`` writes.

        Raises OSError where that fails, and :class:`TakeError` where ``path`` is one of the files that were read.
        """
        import os

        self._made().write(os.fspath(path))

    def _body(self, body):
        return self._only("body", body, self._take.scene.bodies)

    @staticmethod
    def _only(what, name, names):
        if name is None and len(names) != 1:
            raise ValueError(f"{what}: None, expected one of {', '.join(names)}")
        return names[0] if name is None else name

    def _varied(self):
        return self._made().varied_together() or ([], b"")

    def _made(self):
        if self._core is None:
            free, diagnose, is_late = self._options
            if is_late:
                raise ValueError("its deadline ended this estimate, and it was pickled: its motion cannot be made again")
            if self._base is None:
                core = self._take._made().estimate(free, diagnose, None, None)
            else:
                base, sd = self._base
                core = base._made().update(self._take.scene._core, sd, free, diagnose, None, None)
            if core.report() != self._text:
                raise ValueError("another version made this estimate, and it was pickled: its motion is another one")
            object.__setattr__(self, "_core", core)
        return self._core

    def __repr__(self):
        return f"<Estimate of {self._of_report('scene')!r}: {self.verdict}, fits: {self.fit}>"

    def __reduce__(self):
        if self._base is not None and self._base[0] is None:
            raise TypeError("the estimate was updated with chained=False, expected True of one that is pickled")
        if self._options[0] is None:
            raise TypeError("a preview cannot be pickled, expected an estimate: estimate.take.estimate()")
        return _estimate, (self._take, self._options, self._words(), self._base)


def _estimate(take, options, text, base):
    return Estimate._of(take, options[:2], None, text=text, is_late=options[2], base=base)
