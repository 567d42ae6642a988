"""What type checkers know of the module: mypy reads this, nobody runs it."""

from typing import assert_type

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import enact_motion


def estimated(path: str) -> float | None:
    take = enact_motion.read(path)
    estimate = take.estimate(free="auto", deadline=0.05)
    assert_type(estimate.sample(240).position, NDArray[np.float64])
    assert_type(estimate.covariance(["bounce"]), NDArray[np.float64])
    for event in estimate.events:
        assert_type(event.impulse, tuple[float, float, float] | None)
        for impact in event.impacts:
            assert_type(impact.approach_speed, float)
    return estimate.parameters["bounce.restitution"].sd


def acted(t: list[float]) -> enact_motion.Take:
    scene = enact_motion.Scene.new("die", size_mm=[16, 16, 16], mass_g=5)
    turns = Rotation.identity(len(t))
    return enact_motion.Take(scene).poses("die", t, np.zeros((len(t), 3)), turns).mark("bounce", 0.2)
