"""Arrays of a motion agree with each other, with the events, and with what the file has."""

import math

import numpy as np
import pytest
from conftest import RECORDINGS

import enact_motion


@pytest.fixture(scope="module")
def estimates():
    return {path.stem: enact_motion.read(path).estimate() for path in RECORDINGS}


def turned(quaternion, vector):
    w, v = quaternion[..., :1], quaternion[..., 1:]
    cross = 2 * np.cross(v, vector)
    return vector + w * cross + np.cross(v, cross)


def names():
    return [path.stem for path in RECORDINGS]


@pytest.mark.parametrize("name", names())
def test_velocities_are_the_changes_of_poses(estimates, name):
    estimate = estimates[name]
    times = [event.time for event in estimate.events]
    for body in estimate.take.scene.bodies:
        begin, end = estimate.span(body)
        motion = estimate.sample(200, body)
        assert motion.position.shape == (len(motion.t), 3) and motion.quaternion.shape == (len(motion.t), 4)
        assert begin <= motion.t[0] and motion.t[-1] <= end
        assert np.allclose(np.linalg.norm(motion.quaternion, axis=1), 1, atol=1e-12)
        # A tree's flow goes in steps, whose error at their ends a small difference would show.
        h = 1e-4
        far = [t for t in motion.t if min(abs(t - at) for at in [*times, begin, end]) > 3 * h]
        before, at, after = (estimate.at(np.array(far) + by, body) for by in (-h, 0, h))
        assert len(far) > 20
        assert np.allclose((after.position - before.position) / (2 * h), at.velocity, rtol=1e-4, atol=2e-4)
        # q̇ = q ω / 2, with ω in the frame's axes.
        sign = np.sign((after.quaternion * before.quaternion).sum(axis=1, keepdims=True))
        change = (sign * after.quaternion - before.quaternion) / (2 * h)
        w, v, spin = at.quaternion[:, :1], at.quaternion[:, 1:], at.angular_velocity
        sign = np.sign((at.quaternion * before.quaternion).sum(axis=1, keepdims=True))
        expected = 0.5 * np.hstack([-(v * spin).sum(axis=1, keepdims=True), w * spin + np.cross(v, spin)])
        scale = 1 + np.linalg.norm(spin, axis=1, keepdims=True) ** 3
        assert (abs(sign * change - expected) < 1e-5 * scale).all()


@pytest.mark.parametrize("name", names())
def test_one_time_is_a_row_of_many(estimates, name):
    estimate = estimates[name]
    body = estimate.take.scene.bodies[0]
    motion = estimate.sample(50, body)
    one = estimate.at(motion.t[7], body)
    assert one.position.shape == (3,) and one.quaternion.shape == (4,) and one.t.shape == ()
    for part, of_one in zip(motion, one):
        assert (part[7] == of_one).all()


def test_flights_fall(estimates):
    estimate = estimates["pencil_tip"]
    bounce = estimate.events[0].time
    motion = estimate.sample(100)
    flights = motion.t < bounce, motion.t > bounce
    gravity = np.array(estimate.report["gravity_m_s2"])
    for of in flights:
        # Of the centre of mass; the frame's origin is elsewhere only where the scene puts it there.
        change = np.diff(motion.velocity[of], axis=0) * 100
        assert np.allclose(change.mean(axis=0), gravity, atol=0.3), change.mean(axis=0)


def test_an_impact_turns_approach_into_parting(estimates):
    for name in ["pencil_tip", "die", "hat_box"]:
        hits = [event for event in estimates[name].events if event.impacts]
        assert hits
        for event in hits:
            (impact,) = event.impacts
            assert impact.approach_speed > 0 and event.approach_speed == impact.approach_speed
            assert event.contact_point == impact.point
            assert math.isclose(math.dist(impact.normal, (0, 0, 0)), 1, abs_tol=1e-9)
            along = sum(a * b for a, b in zip(event.impulse, impact.normal))
            assert along > 0, "it pushes and does not pull"
    quiet = [event for event in estimates["chain"].events if not event.impacts]
    assert quiet and quiet[0].impulse is None and quiet[0].contact_point is None


@pytest.mark.parametrize("name", names())
def test_residuals_are_those_of_the_report(estimates, name):
    estimate = estimates[name]
    squares, count = 0.0, 0
    for track in estimate.take.scene.tracks:
        residuals = estimate.residuals(track)
        n = len(residuals.t)
        assert residuals.position.shape == residuals.rotation.shape == (n, 3) and n > 10
        assert (np.diff(residuals.t) >= 0).all()
        seen = residuals.position[~np.isnan(residuals.position).any(axis=1)]
        squares, count = squares + (seen**2).sum(), count + len(seen)
    rms_mm = 1e3 * math.sqrt(squares / count)
    # Samples beside an impact count on the other flight here.
    assert rms_mm == pytest.approx(estimate.report["residual_mm"], rel=0.02)


# The flights of an edited sketch have clocks of their own.
@pytest.mark.parametrize("name", [name for name in names() if name != "die"])
def test_time_maps_lead_acted_times_to_physical_ones(estimates, name):
    estimate = estimates[name]
    for track, of in estimate.time_map.items():
        assert track in estimate.take.scene.tracks
        assert len(of.acted) == len(of.physical) > 10
        order = np.argsort(of.acted)
        assert (np.diff(of.physical[order]) > -1e-9).all()


@pytest.mark.parametrize("name", ["pencil_tip", "pencil_eraser", "hat_box", "hat_box_bent", "die"])
def test_covariances_have_the_deviations_on_their_diagonal(estimates, name):
    estimate = estimates[name]
    whole = estimate.covariance()
    assert whole.shape == (len(estimate.numbers),) * 2
    sd = dict(zip(estimate.numbers, np.sqrt(np.diag(whole))))
    told = [(event.name, event.sd) for event in estimate.events]
    told += [(key, parameter.sd) for key, parameter in estimate.parameters.items()]
    assert any(of for _, of in told)
    for key, of in told:
        if of is not None:
            assert sd[key] == pytest.approx(of, rel=1e-6), key
    known = ~np.isnan(np.diag(whole))
    matrix = whole[np.ix_(known, known)]
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-30))
    correlation = matrix / np.outer(scale, scale)
    assert np.allclose(correlation, correlation.T, atol=1e-9)
    assert np.linalg.eigvalsh(correlation).min() > -1e-6
    few = [estimate.numbers[3], estimate.numbers[0]]
    chosen = estimate.covariance(few)
    assert chosen[0, 1] == whole[3, 0] and chosen[1, 1] == whole[0, 0]
    with pytest.raises(KeyError, match="no 'x'"):
        estimate.covariance(["x"])


def test_states_vary_as_the_file_says(estimates):
    """At a flight's epoch the pose's own deviation is that of the report's lines, to their four digits."""
    estimate = estimates["pencil_tip"]
    names = [f"pencil.flight.1.velocity.{axis}" for axis in "xyz"]
    sd = math.sqrt(np.trace(estimate.covariance(names)))
    line = estimate.report["certainty"][0]["velocity_sd_mm_s"]
    values = [value for value in line.values() if isinstance(value, (int, float))] if isinstance(line, dict) else line
    assert min(values) / 1e3 <= sd * 1.2 and sd <= 1.2 * max(values) / 1e3, (line, sd)


def test_joined_bodies_have_no_covariance(estimates):
    assert estimates["chain"].numbers == () and estimates["chain"].covariance().size == 0


@pytest.mark.parametrize("name", ["pencil_tip", "pencil_eraser", "hat_box", "die"])
def test_other_goals_are_met_from_the_last_motion_on(estimates, name):
    estimate = estimates[name]
    goals = estimate.take.scene.goals
    asked = goals[-1]
    asked["position_mm"][0] += 4
    updated = estimate.update(goals=goals)
    assert updated.is_warm and updated.verdict == estimate.verdict
    event = next(event for event in updated.events if event.name == asked["event"])
    met = updated.at(event.time, asked["body"]).position
    before = estimate.at(next(e for e in estimate.events if e.name == asked["event"]).time, asked["body"]).position
    # A goal's position is that of the centre of mass, which moves as the origin does where the orientation is the same.
    assert met[0] - before[0] == pytest.approx(4e-3, abs=1e-6)
    # The same motion as anew, but for the weights of a hand's errors.
    cold = enact_motion.read(estimate.take.to_bytes(), scene=updated.take.scene).estimate()
    a, b = (of.sample(60, asked["body"]).position for of in (updated, cold))
    n = min(len(a), len(b))
    assert abs(a[:n] - b[:n]).max() < 2e-3
    # Back again.
    back = updated.update(goals=estimate.take.scene.goals)
    assert back.is_warm
    for one, other in zip(back.events, estimate.events):
        assert one.time == pytest.approx(other.time, abs=1e-5)
        assert one.sd == pytest.approx(other.sd, rel=1e-2)
    # The same without deviations, which can be asked for later.
    quick = estimate.update(goals=goals, sd=False)
    assert quick.verdict == updated.verdict and quick.fit == updated.fit
    assert (quick.sample(60, asked["body"]).position == updated.sample(60, asked["body"]).position).all()
    assert quick.undetermined and all(event.sd is None for event in quick.events)
    assert (quick.covariance([asked["event"]]) == updated.covariance([asked["event"]])).all()


def test_goals_that_are_refused_or_far_away(estimates):
    estimate = estimates["pencil_tip"]
    with pytest.raises(enact_motion.SceneError, match="nowhere"):
        estimate.update(goals=[{"event": "nowhere", "body": "pencil", "position_mm": [0, 0, 0]}])
    with pytest.raises(ValueError, match="goals"):
        estimate.update(goals=[{"event": None}])
    free = estimate.update(goals=[])
    assert free.verdict in ("physical", "plausible") and free.take.scene.goals == []
    chain = estimates["chain"]
    again = chain.update(goals=chain.take.scene.goals)
    assert not again.is_warm and again.events == chain.events
