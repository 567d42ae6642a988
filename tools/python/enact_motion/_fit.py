"""One answer from many takes."""

import os
from collections import namedtuple

from . import _arrays
from ._core import fit_takes, join_blocks, reduce_take

FitParameter = namedtuple("FitParameter", "value sd interval unit drawn spread spread_interval determined at_bound in_scene")
FitParameter.__doc__ = """What takes share, in its ``unit`` ("" of ratios).

``interval``: its two ends at 95 %, by how takes differ, with ``sd``; None where there is none. ``drawn``: whether each take draws its own
value; then ``value`` is the mean over takes, ``spread`` its standard deviation over them, ``spread_interval`` that one's ends. ``determined``:
whether the takes together tell it. ``at_bound``: whether it is at a bound. ``in_scene``: what the scene says.
"""


class Fit:
    """What many takes share, by :func:`fit` or :func:`join`. Immutable."""

    __slots__ = ("_texts", "_report")

    def __init__(self, texts):
        import json

        line, takes, _ = texts
        report = json.loads(line)
        report["takes_each"] = json.loads(takes)
        object.__setattr__(self, "_texts", texts)
        object.__setattr__(self, "_report", report)

    def __setattr__(self, name, value):
        raise AttributeError(f"{name}: a fit is immutable")

    @property
    def parameters(self):
        """Of each name a :class:`FitParameter`."""
        return {of["name"]: _parameter(of) for of in self._report["parameters"]}

    @property
    def correlations(self):
        """(n, n): of the parameters, in their order."""
        return _arrays.matrix(self._report["correlations"])

    @property
    def against(self):
        """What speaks against it, a sentence each; nothing where it is whole."""
        return tuple(self._report["against"])

    @property
    def undetermined(self):
        """Combinations of parameters that the takes together do not tell, in words."""
        return tuple(self._report["undetermined"])

    @property
    def held_out(self):
        """Of takes that were held out: a dict of their residuals with the answer and with the scene's own values; None without."""
        return self._report["held_out"]

    @property
    def takes(self):
        """What became of each take: dicts as lines of ``enact fit --format ndjson``, in the order in which they were given."""
        return self._report["takes_each"]

    @property
    def report(self):
        """All of it, a dict."""
        return self._report

    @property
    def toml(self):
        """The answer as ``enact scene calibrated`` takes it."""
        return self._texts[2]

    def __repr__(self):
        names = ", ".join(f"{name} {of.value:.4g}" for name, of in self.parameters.items())
        return f"<Fit of {self._report['takes']} takes: {names}>"

    def __reduce__(self):
        return Fit, (self._texts,)


def _parameter(of):
    spread = of["spread"] or {"sd": None, "interval": None}
    ends = (None if pair is None else tuple(pair) for pair in (of["interval"], spread["interval"]))
    interval, spread_interval = ends
    return FitParameter(
        of["value"],
        of["sd"],
        interval,
        of["unit"],
        of["is_drawn"],
        spread["sd"],
        spread_interval,
        of["is_determined"],
        of["is_at_bound"],
        of["in_scene"],
    )


def _names(what, names):
    if isinstance(names, str):
        raise TypeError(f"{what}: a str, expected a list of names such as ['bounce.restitution']")
    return [str(name) for name in names]


def _input(of):
    core = getattr(of, "_made", None)
    if core is not None:
        return {"name": of._name, "core": core()}
    return os.fspath(of)


def fit(takes, *, shared=(), drawn=(), hold_out=None):
    """What takes share, as ``enact fit`` finds it; returns a :class:`Fit`.

    ``takes``: paths of recordings, or takes. ``shared``: names of ``[[free]]`` quantities with one value in all; ``drawn``: of those that each
    take draws about a mean. ``hold_out``: a share of the takes, or paths, by which the answer is tried and not made.

    Other Python threads go on meanwhile; Ctrl-C ends it between two takes. Raises :class:`TakeError` where there is no answer.

    >>> import enact_motion
    >>> enact_motion.fit([], shared=["gravity"])
    Traceback (most recent call last):
        ...
    enact_motion._errors.TakeError: no take says anything of gravity
    """
    if hold_out is not None and not isinstance(hold_out, (int, float)):
        hold_out = [os.fspath(path) for path in hold_out]
    elif hold_out is not None and not 0 < hold_out < 1:
        raise ValueError(f"hold_out: {hold_out}, expected a share between 0 and 1, or paths")
    inputs = [_input(of) for of in takes]
    return Fit(fit_takes(inputs, _names("shared", shared), _names("drawn", drawn), hold_out))


def reduce(take, *, shared=(), drawn=(), question=None):
    """What one take says where a question asks it: a block of a few kilobytes, bytes; None where it is not asked.

    A pure function of the take, the names and the question, for a map over many machines. ``take``: a path or a take. ``question``: what
    :func:`join` gave; without one the take is asked at its own values. A take of which nothing can be asked has a block that says why.
    """
    return reduce_take(_input(take), _names("shared", shared), _names("drawn", drawn), question)


def join(blocks):
    """Joins blocks of all rounds so far, in any order: the next question, bytes, or in the end the :class:`Fit`.

    Raises ValueError for what is no block and :class:`TakeError` where blocks are not of one fit, or lead to no answer.

    >>> join([])
    Traceback (most recent call last):
        ...
    enact_motion._errors.TakeError: no blocks of the first round, expected those of every take: fit --reduce
    """
    question, texts = join_blocks([bytes(block) for block in blocks])
    return question if texts is None else Fit(texts)
