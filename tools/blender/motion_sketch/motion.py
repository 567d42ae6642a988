# SPDX-License-Identifier: GPL-3.0-or-later
"""A motion as rows of keys: on frames, and exactly at events. Plain numbers."""

from dataclasses import dataclass

import numpy as np

#: Frames nearer to each other than this are one.
SAME_FRAME = 1e-4


@dataclass
class Keys:
    """Of one body: frames with their parts, metres, quaternions w x y z of one sign."""

    frames: np.ndarray
    position: np.ndarray
    quaternion: np.ndarray


def frame_of(solved, time_s):
    """The frame of a physical time."""
    return solved.reading.units.frame(time_s + solved.zero_s)


def time_of(solved, frame):
    """The physical time of a frame."""
    return solved.reading.units.seconds(frame) - solved.zero_s


def keys_of(solved, name):
    """The keys of a body: of what is estimated, and of what is simulated after the end."""
    estimate = solved.estimate
    begin, end = estimate.span(name)
    later, place, turn = estimate.simulated(name)
    last = float(later[-1]) if len(later) else end
    first = frame_of(solved, begin)
    whole = np.arange(np.ceil(first - SAME_FRAME), np.floor(frame_of(solved, last) + SAME_FRAME) + 1)
    exact = [first, frame_of(solved, end), frame_of(solved, last)]
    exact += [frame_of(solved, of.time) for of in estimate.events if name in of.bodies and begin <= of.time <= end]
    frames = joined(whole, exact)
    times = np.array([time_of(solved, of) for of in frames])
    flown = times <= end + 1e-9
    motion = estimate.at(np.clip(times[flown], begin, end), name)
    position, quaternion = motion.position, motion.quaternion
    if not flown.all():
        after = between(later, place, turn, times[~flown])
        position, quaternion = np.vstack([position, after[0]]), np.vstack([quaternion, after[1]])
    before = solved.reading.before.get(name)
    if before is not None:
        kept = np.array(before[0]) < frames[0] - SAME_FRAME
        frames = np.concatenate([np.array(before[0])[kept], frames])
        position, quaternion = np.vstack([before[1][kept], position]), np.vstack([before[2][kept], quaternion])
    return Keys(frames, position, one_sign(quaternion))


def joined(whole, exact):
    """All frames in order; of those that are nearly the same the first."""
    frames = []
    for of in sorted([*map(float, whole), *map(float, exact)]):
        if not frames or of - frames[-1] >= SAME_FRAME:
            frames.append(of)
    return np.array(frames)


def between(t, place, turn, times):
    """Poses between the rows of a simulation, on the line between two."""
    after = np.clip(np.searchsorted(t, times), 1, len(t) - 1)
    share = np.clip((times - t[after - 1]) / (t[after] - t[after - 1]), 0, 1)[:, None]
    turn = one_sign(turn)
    mixed = turn[after - 1] * (1 - share) + turn[after] * share
    return place[after - 1] * (1 - share) + place[after] * share, mixed / np.linalg.norm(mixed, axis=1, keepdims=True)


def one_sign(quaternion):
    """The same turns without jumps of the sign."""
    if len(quaternion) < 2:
        return np.array(quaternion)
    signs = np.sign((quaternion[1:] * quaternion[:-1]).sum(axis=1))
    signs[signs == 0] = 1
    return quaternion * np.concatenate([[1.0], np.cumprod(signs)])[:, None]


def repeated(keys, times):
    """The same again and again, so often in all; the last pose of one is the first of the next."""
    length = keys.frames[-1] - keys.frames[0]
    frames, place, turn = [keys.frames], [keys.position], [keys.quaternion]
    for number in range(1, times):
        frames.append(keys.frames[1:] + number * length)
        place.append(keys.position[1:])
        turn.append(keys.quaternion[1:])
    return Keys(np.concatenate(frames), np.vstack(place), one_sign(np.vstack(turn)))


def path_of(solved, name, per_second=120):
    """Where a body goes, for the eye: (n, 3) metres."""
    estimate = solved.estimate
    begin, end = estimate.span(name)
    count = max(2, min(2000, round((end - begin) * per_second)))
    place = estimate.at(np.linspace(begin, end, count), name).position
    later = estimate.simulated(name)[1][::2]
    return np.vstack([place, later]) if len(later) else place
