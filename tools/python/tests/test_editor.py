"""What an editor asks: keyframes, proposals, what is simulated, progress, previews, updates without end."""

import gc
import pickle

import numpy as np
import pytest

import enact_motion

G = 9.80665


WISH = """
[[goal]]
event = "end"
body = "ball"
position_mm = [300, 0, 140]
sd_mm = 1
"""


def ball(settle="", goal=""):
    return enact_motion.Scene.from_toml(f"""
name = "ball"
{settle}
[timing]
stamps = "physical"
[[body]]
name = "ball"
shape = {{ kind = "sphere", radius_mm = 50 }}
mass_g = 100
restitution = 0.5
[[surface]]
name = "table"
point_mm = [0, 0, 0]
normal = [0, 0, 1]
[[event]]
name = "bounce"
kind = "collision"
body = "ball"
surface = "table"
[[event]]
name = "end"
kind = "end"
{goal}
""")


END = '[[event]]\nname = "end"\nkind = "end"\n'
HIT = np.sqrt(2 * 0.45 / G)
LAST = HIT + 0.3


def fallen(t):
    after = t - HIT
    z = np.where(after < 0, 0.5 - G * t**2 / 2, 0.05 + 0.5 * G * HIT * after - G * after**2 / 2)
    return np.stack([0.5 * t, 0 * t, z], axis=1)


def take(scene=None, rate=120):
    t = np.arange(0, LAST, 1 / rate)
    of = enact_motion.Take(scene or ball()).poses("ball", t, fallen(t), [[1, 0, 0, 0]] * len(t), order="wxyz")
    return of.mark("bounce", HIT + 0.01).mark("end", t[-1])


TURNS = [[np.cos(a), 0, np.sin(a), 0] for a in (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)]


def test_keyframes_are_a_few_of_each_flight():
    t = np.array([0.05, 0.15, 0.25, 0.35, 0.45, 0.55])
    of = enact_motion.Take(ball()).keyframes("ball", t, fallen(t), TURNS[:6], order="wxyz")
    estimate = of.mark("bounce", HIT + 0.005).mark("end", 0.55).estimate()
    # A ball may have turned once more between two of them, which is said.
    assert all("turns least" in said for said in estimate.against), estimate.against
    assert estimate.events[0].time + 0.05 == pytest.approx(HIT, abs=2e-3)
    again = enact_motion.read(of.to_bytes()).estimate()
    assert np.array_equal(again.sample(100).position, estimate.sample(100).position)
    assert pickle.loads(pickle.dumps(of)).to_bytes() == of.to_bytes()


def test_keyframes_within_a_time():
    """Of a flight whose ends are known, the keys between are at the times at which it was there."""
    t = np.array([0.02, 0.08, 0.14, 0.2, 0.26])
    wrong = t + np.array([0, 0.02, -0.02, 0.015, 0])
    scene = enact_motion.Scene.from_toml(ball().toml.replace(ball().toml[ball().toml.index("[[event]]") :], END))
    of = enact_motion.Take(scene).keyframes("ball", t[[0, -1]], fallen(t)[[0, -1]], np.array(TURNS)[[0, 4]], order="wxyz")
    of = of.keyframes("ball", wrong[1:-1], fallen(t)[1:-1], TURNS[1:4], order="wxyz", within=0.03)
    estimate = of.mark("end", 0.26).estimate()
    assert estimate.verdict == "physical", estimate.against
    assert estimate.time_map["ball"].physical + 0.02 == pytest.approx(t, abs=3e-3)
    with pytest.raises(ValueError, match="not negative"):
        of.keyframes("ball", t, fallen(t), TURNS[:5], order="wxyz", within=-1)


def test_proposals_are_where_it_bounces():
    bounce, end = take().proposals()
    assert (bounce.event, bounce.body, end.event, end.body, end.score) == ("bounce", "ball", "end", None, None)
    assert bounce.t == pytest.approx(HIT, abs=1 / 120) and bounce.score > 100
    assert [of.event for of in take().proposals(2)][:2] == [None, None]
    short = enact_motion.Take(ball()).poses("ball", [0], [[0, 0, 1]], [[1, 0, 0, 0]], order="wxyz")
    assert not any(of.event == "bounce" for of in short.proposals())


def test_what_is_simulated_goes_on_from_the_end():
    estimate = take(ball("settle_s = 3")).estimate()
    t, place, turn = estimate.simulated()
    end = estimate.span()[1]
    assert t[0] == pytest.approx(end) and len(t) > 50 and place.shape == (len(t), 3) and turn.shape == (len(t), 4)
    assert np.abs(place[0] - estimate.at(end).position).max() < 1e-9
    assert place[-1][2] == pytest.approx(0.05, abs=2e-3) and np.allclose(np.linalg.norm(turn, axis=1), 1)
    assert len(take().estimate().simulated()[0]) == 0


def test_who_is_told_stops_it(recordings):
    phases = []
    whole = enact_motion.read(recordings["hat_box"]).estimate(told=phases.append)
    assert not whole.is_late and "finish" in phases and set(phases) <= {*whole.spent, "done"}
    stopped = enact_motion.read(recordings["hat_box"]).estimate(told=lambda phase: True)
    assert stopped.is_late and sum(stopped.spent.values()) < sum(whole.spent.values())

    def fails(phase):
        raise RuntimeError(f"told {phase}")

    with pytest.raises(RuntimeError, match="told"):
        enact_motion.read(recordings["hat_box"]).estimate(told=fails)


def test_a_preview_is_near_the_estimate():
    whole, quick = take().estimate(), take().preview()
    t = np.linspace(*whole.span(), 50)
    assert quick.verdict in ("physical", "plausible")
    assert np.abs(whole.at(t).position - quick.at(t).position).max() < 2e-3
    with pytest.raises(TypeError, match="a preview cannot be pickled"):
        pickle.dumps(quick)
    assert not quick.update(goals=[]).is_warm


def test_updates_without_end_keep_nothing():
    estimate = take(ball(goal=WISH)).estimate()
    first = estimate.update(goals=estimate.take.scene.goals, sd=False, chained=False)
    assert first.is_warm

    with pytest.raises(TypeError, match="chained=False"):
        pickle.dumps(first)
    gc.collect()
    before = sum(isinstance(of, enact_motion.Estimate) for of in gc.get_objects())
    for _ in range(20):
        goals = first.take.scene.goals
        goals[0]["position_mm"][0] += 0.5
        first = first.update(goals=goals, sd=False, chained=False)
    gc.collect()
    assert sum(isinstance(of, enact_motion.Estimate) for of in gc.get_objects()) <= before
