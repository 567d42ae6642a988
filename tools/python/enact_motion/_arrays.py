"""Arguments become bytes of float64, bytes become arrays; numpy is loaded when the first is needed."""


def array(name, value, expected, check):
    """The array of an argument; its shape is checked, and that its numbers are finite."""
    import numpy as np

    try:
        of = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: {error}, expected numbers of shape {expected}") from None
    if not check(of.shape):
        raise ValueError(f"{name}: shape {of.shape}, expected {expected}")
    bad = np.argwhere(~np.isfinite(of))
    if bad.size and of.ndim:
        at = bad[0][0]
        raise ValueError(f"{name}[{at}]: {of[at]}, expected finite numbers: leave out rows without any")
    if bad.size or (of.ndim == 0 and not np.isfinite(of)):
        raise ValueError(f"{name}: {of}, expected a finite number")
    return of


def time(t):
    """The seconds of a mark."""
    t = float(t)
    if not 0 <= t < 9e9:
        raise ValueError(f"t: {t}, expected seconds, not negative")
    return t


def limit(deadline):
    """The seconds of a deadline."""
    if deadline is None:
        return None
    deadline = float(deadline)
    if not deadline >= 0:
        raise ValueError(f"deadline: {deadline}, expected seconds, not negative")
    return deadline


def poses(t, position, quaternion, order, sees):
    """Bytes of times, positions and quaternions x y z w."""
    import numpy as np

    t = array("t", t, "(n,)", lambda shape: len(shape) == 1)
    rows = "a row for each of t"
    n = len(t)
    if n and not 0 <= t.min() <= t.max() < 9e9:
        raise ValueError(f"t: {t.min()} to {t.max()}, expected seconds, not negative")
    back = np.flatnonzero(np.diff(t) <= 0)
    if back.size:
        at = back[0] + 1
        raise ValueError(f"t[{at}]: {t[at]} after {t[at - 1]}, expected increasing times")
    position = array("position", position, f"({n}, 3): {rows}", lambda shape: shape == (n, 3))
    if quaternion is None:
        if sees != "point":
            raise ValueError(f"quaternion: None, expected ({n}, 4): the track sees a {sees}")
        return t.tobytes(), position.tobytes(), b""
    if hasattr(quaternion, "as_quat"):
        quaternion, order = np.atleast_2d(quaternion.as_quat()), "xyzw"
    elif order not in ("wxyz", "xyzw"):
        raise ValueError(f"order: {order!r}, expected 'wxyz' or 'xyzw': the numbers of a quaternion do not say it")
    quaternion = array("quaternion", quaternion, f"({n}, 4): {rows}", lambda shape: shape == (n, 4))
    zero = np.flatnonzero(~quaternion.any(axis=1))
    if zero.size:
        raise ValueError(f"quaternion[{zero[0]}]: all zero, expected an orientation")
    if order == "wxyz":
        quaternion = np.roll(quaternion, -1, axis=1)
    return t.tobytes(), position.tobytes(), quaternion.tobytes()


def rows(data, columns):
    """The array (n, columns) of bytes, which nobody can write."""
    import numpy as np

    return np.frombuffer(data, dtype=np.float64).reshape(-1, columns)


def matrix(rows):
    """The array (n, n) of lists."""
    import numpy as np

    return np.array(rows, dtype=np.float64).reshape(len(rows), len(rows))
