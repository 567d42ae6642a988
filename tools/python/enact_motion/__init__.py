"""Acted motions become physically correct ones.

Somebody picks up an object with a tracker on it and acts a motion: it bounces, twirls, lands. A :class:`Take` has what the
tracker saw, a :class:`Scene` says what the object is and what happens to it, and an :class:`Estimate` is the rigid-body motion
that fits the performance best and is physically correct.

All is in SI units: metres, seconds, radians, newton seconds; where a name says otherwise (``size_mm``) it is that. Arrays have a
row for each time. Quaternions are Hamilton and unit, world from body. Physical times count from the first sample used, acted
times from the first sample.

>>> import enact_motion
>>> scene = enact_motion.Scene.new("die", mass_g=1000, size_mm=[100, 100, 100], stamps="physical")
>>> scene.bodies, scene.tracks, scene.events
(('die',), ('die',), ('bounce', 'landing'))
"""

from . import _arrays
from ._core import Scene as _Scene
from ._core import Take as _Take
from ._errors import SceneError, TakeError
from ._estimate import Estimate, Event, Impact, Motion, Parameter, Proposal, Residuals, TimeMap
from ._fit import Fit, FitParameter, fit, join, reduce

__all__ = [
    "Estimate",
    "Event",
    "Fit",
    "FitParameter",
    "Impact",
    "Motion",
    "Parameter",
    "Proposal",
    "Residuals",
    "Scene",
    "SceneError",
    "Take",
    "TakeError",
    "TimeMap",
    "fit",
    "join",
    "read",
    "reduce",
]

_UNITS_M = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
_NAME = "take.mcap"


class Scene:
    """What moves, what it meets, and what happens: a scene file. Immutable; equal where the texts are.

    Made by :meth:`from_toml`, :meth:`from_file` or :meth:`new`. Raises :class:`SceneError` where it is refused.

    >>> Scene.from_toml("name = 'x'\\nmass = 3")
    Traceback (most recent call last):
        ...
    enact_motion._errors.SceneError: scene:2:1: unknown key `mass`, expected one of ...
    """

    __slots__ = ("_core",)

    def __init__(self, core):
        object.__setattr__(self, "_core", core)

    def __setattr__(self, name, value):
        raise AttributeError(f"{name}: a scene is immutable, expected another one: Scene.from_toml(text)")

    @classmethod
    def from_toml(cls, text):
        """The scene of a text of TOML.

        >>> Scene.from_toml(Scene.new("die").toml) == Scene.new("die")
        True
        """
        return cls(_Scene(text, None))

    @classmethod
    def from_file(cls, path):
        """The scene in a file of TOML. Raises OSError where the file cannot be read."""
        import os

        path = os.fspath(path)
        with open(path, encoding="utf-8") as file:
            return cls(_Scene(file.read(), path))

    @classmethod
    def new(
        cls,
        object,
        *,
        mass_g=None,
        size_mm=None,
        material=None,
        tracker_mm=None,
        bounces=1,
        stamps="tempo",
        lands=None,
        unit=None,
        hull=False,
    ):
        """A scene of an object over a table, as ``enact scene new`` makes it.

        ``object``: a preset (``enact scene objects`` lists them) or a mesh file (.obj, .stl, .glb), which needs ``mass_g`` and,
        but for .glb, ``unit`` ("mm", "cm", "m" or "in"); ``hull`` takes its convex hull. ``size_mm``: three sides of a box, with
        ``mass_g``. ``material``: how it bounces or rubs. ``tracker_mm``: where the tracker is, in the axes of the object.
        ``bounces``: how often it bounces before it lands. ``stamps``: "tempo" where the performer's tempo is not known,
        "physical" where stamps are times of the motion itself. ``lands``: the axis or face that is up in the end.

        >>> Scene.new("die", bounces=2).events
        ('bounce 1', 'bounce 2', 'landing')
        >>> Scene.new("dye")
        Traceback (most recent call last):
            ...
        enact_motion._errors.TakeError: dye: no object "dye", ...
        """
        if unit is not None and unit not in _UNITS_M:
            raise ValueError(f"unit: {unit!r}, expected one of {', '.join(_UNITS_M)}")
        text = _Scene.text_of_new(
            str(object),
            mass_g=mass_g,
            size_mm=size_mm,
            material=material,
            tracker_mm=tracker_mm,
            bounces=bounces,
            stamps=stamps,
            lands=lands,
            unit_m=_UNITS_M.get(unit),
            hull=hull,
        )
        return cls.from_toml(text)

    @property
    def toml(self):
        """Its text."""
        return self._core.toml

    @property
    def file(self):
        """The file that it was read from, a str; None of a text."""
        file = self._core.file
        return None if file is None else str(file)

    @property
    def name(self):
        """Its name."""
        return self._core.name

    @property
    def bodies(self):
        """Names of its bodies."""
        return tuple(self._core.bodies)

    @property
    def tracks(self):
        """Names of what trackers deliver: that of the body, unless it has several."""
        return tuple(name for name, _ in self._core.tracks)

    @property
    def goals(self):
        """Its goals: a list of dicts with the keys of ``[[goal]]``, a copy each time."""
        import tomllib

        return tomllib.loads(self.toml).get("goal", [])

    @property
    def events(self):
        """Names of what happens, in order of time; a repeated collision has one."""
        return tuple(self._core.events)

    def __eq__(self, other):
        if not isinstance(other, Scene):
            return NotImplemented
        return (self.toml, self.file) == (other.toml, other.file)

    def __hash__(self):
        return hash(self.toml)

    def __repr__(self):
        return f"<Scene {self.name!r}: bodies {', '.join(self.bodies)}>"

    def __reduce__(self):
        return _scene, (self.toml, self.file)


def _scene(toml, file):
    return Scene(_Scene(toml, file))


class Take:
    """What trackers saw of one performance, and when the performer marked events.

    Poses and marks are added one after the other; :func:`read` gives one that is complete. It pickles as its recording.

    >>> import numpy as np
    >>> scene = Scene.new("die", stamps="physical")
    >>> t = np.linspace(0, 0.2, 21)
    >>> position = np.stack([t, 0 * t, 1 - 4.9 * t**2], axis=1)
    >>> take = Take(scene).poses("die", t, position, np.tile([1, 0, 0, 0], (21, 1)), order="wxyz")
    >>> take.mark("bounce", 0.2)
    <Take of 'die': 21 poses, 1 marks>
    """

    __slots__ = ("_core", "_marks", "_name", "_poses", "_read", "_scene")

    def __init__(self, scene):
        if not isinstance(scene, Scene):
            raise TypeError(f"scene: {type(scene).__name__}, expected a Scene")
        self._scene = scene
        self._name = _NAME
        self._poses = []
        self._marks = []
        self._core = None
        self._read = False

    def poses(self, track, t, position, quaternion=None, *, order=None):
        """Adds what a tracker saw; returns the take.

        ``track``: one of ``scene.tracks``. ``t``: (n,) seconds, not negative, increasing. ``position``: (n, 3) metres, the
        tracker's in the world. ``quaternion``: (n, 4), world from tracker, of any norm but zero, with ``order`` "wxyz" or
        "xyzw", which no numbers tell; or a ``scipy.spatial.transform.Rotation`` of n. Of a track that sees a point there is
        none. Anything that numpy makes an array of float64 of is taken: lists, float32, strided views.

        Raises ValueError for a shape, an order, or numbers that are not finite, and KeyError for a track that is not in the scene.

        >>> take = Take(Scene.new("die"))
        >>> take.poses("die", [0, 1], [[0, 0, 1], [0, 0, 1]], [[1, 0, 0, 0]] * 2)
        Traceback (most recent call last):
            ...
        ValueError: order: None, expected 'wxyz' or 'xyzw': the numbers of a quaternion do not say it
        >>> take.poses("die", [0, 1], [0, 0, 1], [[1, 0, 0, 0]] * 2, order="wxyz")
        Traceback (most recent call last):
            ...
        ValueError: position: shape (3,), expected (2, 3): a row for each of t
        """
        self._check_open()
        sees = dict(self._scene._core.tracks)
        if track not in sees:
            raise KeyError(f"track: no {track!r} in the scene, expected one of {', '.join(sees)}")
        self._poses.append((track, *_arrays.poses(t, position, quaternion, order, sees[track]), None))
        self._core = None
        return self

    def keyframes(self, body, t, position, quaternion, *, order, within=0):
        """Adds poses that somebody wrote, a few of each flight (``docs/sketch.md``); returns the take.

        ``body``: one of ``scene.bodies`` whose pose is tracked. ``t``, ``position``, ``quaternion``, ``order``: as for :meth:`poses`, of the
        body's frame. ``within``: how far each true time may be from ``t``, seconds; where not 0 the scene's stamps are physical.

        >>> take = Take(Scene.new("die", stamps="physical"))
        >>> take.keyframes("die", [0, 0.2], [[0, 0, 1], [0, 0, 0.5]], [[1, 0, 0, 0]] * 2, order="wxyz", within=0.04)
        <Take of 'die': 2 poses, 0 marks>
        """
        within = _arrays.limit(within) or 0.0
        self.poses(body, t, position, quaternion, order=order)
        self._poses[-1] = (*self._poses[-1][:-1], within)
        return self

    def mark(self, event, t):
        """Adds the performer's mark that an event happens at about ``t`` seconds, on the clock of the poses; returns the take.

        ``event``: a name of ``scene.events``, or None for the next one in order. Raises KeyError where there is no such
        event.

        >>> Take(Scene.new("die")).mark("bonuce", 0.2)
        Traceback (most recent call last):
            ...
        KeyError: "event: no 'bonuce' in the scene, expected one of bounce, landing"
        """
        self._check_open()
        # One of a repeated collision has a number after its name.
        stem = None if event is None else event.rstrip("0123456789").rstrip()
        if event is not None and event not in self._scene.events and stem not in self._scene.events:
            events = ", ".join(self._scene.events)
            raise KeyError(f"event: no {event!r} in the scene, expected one of {events}")
        self._marks.append((event, _arrays.time(t)))
        self._core = None
        return self

    def proposals(self, count=None):
        """Where events may be, as ``enact mark --propose`` says: a tuple of :class:`Proposal` in order of time.

        ``count``: how many collisions of each body are looked for; as many as the scene has by default. Marks of the take do
        not count. Raises :class:`TakeError` where the streams are too short.
        """
        return tuple(Proposal(*of) for of in self._made().proposals(count))

    def estimate(self, *, free=None, deadline=None, diagnose=True, told=None):
        """Estimates the motion, as ``enact replay`` does; returns an :class:`Estimate`, whatever its verdict.

        ``free``: "auto" sets free what explains a misfit, the fewest of the quantities that the scene keeps fixed. ``deadline``:
        seconds after which the best so far is given; such an estimate depends on the machine. ``diagnose``: whether likely
        mistakes are looked for where something speaks against the motion, at up to ten times the work. ``told``: called some
        50 times a second with the name of the phase; where it returns true the best so far is given, as at the deadline.

        Other Python threads go on meanwhile; Ctrl-C ends it with KeyboardInterrupt. The same take gives the same bits, in any
        thread. Raises :class:`TakeError` where no estimate is possible.
        """
        if free not in (None, "auto"):
            raise ValueError(f"free: {free!r}, expected 'auto' or None; [[free]] of the scene names single quantities")
        options = (free == "auto", bool(diagnose))
        return Estimate._of(self, options, self._made().estimate(*options, _arrays.limit(deadline), told))

    def preview(self):
        """The motion as a live preview has it, an :class:`Estimate`: for an editor whose keys are dragged.

        Without the errors of a hand, with nothing told of how it fits, checked for overlaps alone, in a fraction of the time. It is
        within what a hand strays of the motion of :meth:`estimate`. It cannot be pickled. Raises :class:`TakeError` where no
        estimate is possible, and of joined bodies.
        """
        return Estimate._of(self, None, self._made().preview())

    def to_bytes(self):
        """The recording, an MCAP file with the scene in it: what :func:`read` and ``enact replay`` take."""
        return self._made().bytes

    @property
    def scene(self):
        """Its scene."""
        return self._scene

    @property
    def notes(self):
        """What to know of how the recording was read: what of it was lost, what was guessed."""
        return tuple(self._made().notes)

    def _in_scene(self, core):
        take = Take(Scene(core))
        take._core, take._name = self._made().in_scene(core), self._name
        take._read = "scene"
        return take

    def _check_open(self):
        if self._read:
            raise ValueError("the take was read, expected Take(scene) to add poses and marks to")

    def _made(self):
        if self._core is None:
            recording = _Take.recording(self._name, self._scene._core, self._poses, self._marks)
            self._core = _Take.of_bytes(self._name, recording, None)
        return self._core

    def __repr__(self):
        if self._read:
            return f"<Take of {self._scene.name!r}: {self._name}>"
        poses = sum(len(t) // 8 for _, t, *_ in self._poses)
        return f"<Take of {self._scene.name!r}: {poses} poses, {len(self._marks)} marks>"

    def __reduce__(self):
        if self._read:
            own = self._scene if self._read == "scene" else None
            return _read_again, (self._name, self.to_bytes(), own)
        return _take, (self._scene, self._poses, self._marks)


def _take(scene, poses, marks):
    take = Take(scene)
    take._poses, take._marks = list(poses), list(marks)
    return take


def _of_core(core, name, scene):
    take = Take(scene or Scene.from_toml(core.scene_toml))
    take._core, take._name = core, name
    take._read = "scene" if scene else "own"
    return take


def _read_again(name, data, scene):
    core = _Take.of_bytes(name, data, scene and scene._core)
    return _of_core(core, name, scene)


def read(source, *, scene=None):
    """The take of a recording: an MCAP file, by its path, or its bytes.

    ``scene``: another :class:`Scene` than the one that travels in it. Raises OSError where the file cannot be read,
    :class:`SceneError` for a scene and :class:`TakeError` for anything else.

    >>> read(b"no recording")
    Traceback (most recent call last):
        ...
    enact_motion._errors.TakeError: take.mcap: ...
    """
    import os

    if isinstance(source, (bytes, bytearray, memoryview)):
        return _read_again(_NAME, bytes(source), scene)
    name = os.fspath(source)
    return _of_core(_Take.of_file(name, scene and scene._core), name, scene)
