"""What several takes of a ball share, by `enact_motion.fit` and by MuJoCo's own toolbox of system identification, `mujoco.sysid`,
on the same takes of known truth.

    pip install 'mujoco[sysid]==4.0.0' scipy enact-motion    # the wheel of tools/python
    python tools/peers/several.py ANSWERS [--seeds 5] [--takes 10] [--first 9000]

ANSWERS is a JSON file, written anew after each answer: answers that are there are kept, so that a run that ended goes on from there. An answer of MuJoCo
takes a minute of a core and more.

A ball is thrown along a table, slides as it bounces once, and its tracker sees all of that with white noise. Friction, the contact, gravity, where
the tracker is and each take's motion are unknown to both. MuJoCo shoots through the impact, from where lines through the first twelve samples
begin, with residuals in units of the true noise; from a wrong friction it does not find its best, so that it is also begun at the truth. Its contact
gives way, by a stiffness and a damping that are free, and has no restitution: that is one of a drop in the fitted model, without an interval.
"""

import argparse
import importlib.metadata
import json
import os
import pathlib
import platform
import subprocess
import time

# Matrices are small: more threads would only wait for each other, and time of a core would count that.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import enact_motion
import mujoco
import numpy as np
from mujoco import rollout, sysid
from scipy.spatial.transform import Rotation

G = 9.80665
RADIUS = 0.03
MASS = 0.11
TRUE = {"restitution": 0.6, "friction": 0.15, "gravity": [0, 0, -G], "tracker": [0, 0, 0]}
SCENE = f"""name = "a ball that bounces"
hand = "none"
[timing]
stamps = "physical"
[[body]]
name = "ball"
shape = {{ kind = "sphere", radius_mm = {1e3 * RADIUS} }}
mass_g = {1e3 * MASS}
restitution = 0.5
friction = 0.3
[[surface]]
name = "table"
point_mm = [0, 0, 0]
normal = [0, 0, 1]
[[event]]
name = "go"
kind = "start"
[[event]]
name = "bounce"
kind = "collision"
body = "ball"
surface = "table"
[[event]]
name = "end"
kind = "end"
"""

STEP = 5e-4
XML = f"""<mujoco><option timestep="{STEP}" integrator="implicitfast" cone="elliptic" impratio="10"/>
<default><geom friction="0.3 0 0" condim="3" solimp="0.95 0.99 0.001"/></default>
<worldbody><geom type="plane" size="50 50 1"/><body><freejoint/>
<geom type="sphere" size="{RADIUS}" mass="{MASS}"/></body></worldbody></mujoco>"""
# The contact by the logarithms of its stiffness [1/s²] and damping [1/s].
BEGINS = {
    "the scene's values": {"friction": 0.3, "contact": np.log([5e5, 300]), "gravity": [0, 0, -G], "tracker": [0, 0, 0]},
    "the truth": {"friction": 0.15, "contact": np.log([5e5, 230]), "gravity": [0, 0, -G], "tracker": [0, 0, 0]},
}
BOUNDS = {"friction": (0.01, 2), "contact": (np.log([5e4, 10]), np.log([4e6, 3000])), "gravity": (-11, 11), "tracker": (-0.05, 0.05)}
# How far a first state may be from where it begins: place, turn, velocity, spin.
ROUND = np.repeat([0.02, 0.5, 2, 15], 3)


def thrown(random):
    """A take: a parabola, an even spin, and at the table the impulse of Coulomb's law on a solid sphere."""
    height = random.uniform(0.5, 0.9)
    velocity = np.array([random.uniform(5, 7), random.uniform(-0.5, 0.5), 0])
    spin = random.uniform(-6, 6, 3)
    falls = np.sqrt(2 * (height - RADIUS) / G)
    t = np.arange(0, falls + 0.35, 1 / 200)
    slip = (velocity + np.cross(spin, [0, 0, -RADIUS])) * [1, 1, 0]
    impulse = min(TRUE["friction"] * (1 + TRUE["restitution"]) * G * falls, 2 / 7 * np.linalg.norm(slip))
    change = -impulse * slip / np.linalg.norm(slip)
    spun = np.cross([0, 0, -RADIUS], change) / (0.4 * RADIUS**2)
    before, after = np.minimum(t, falls), np.maximum(t - falls, 0)
    place = np.outer(before, velocity) + np.outer(after, velocity + change)
    place[:, 2] = np.where(t < falls, height - 0.5 * G * t**2, RADIUS + TRUE["restitution"] * G * falls * after - 0.5 * G * after**2)
    turn = Rotation.from_rotvec(np.outer(after, spin + spun)) * Rotation.from_rotvec(np.outer(before, spin))
    noise = random.uniform(2e-4, 8e-4), random.uniform(2e-3, 8e-3)
    place = place + random.normal(0, noise[0], place.shape)
    turn = turn * Rotation.from_rotvec(random.normal(0, noise[1], place.shape))
    marks = {"go": 0.005, "bounce": falls + random.normal(0, 0.003), "end": t[-1] - 0.01}
    return {"t": t, "place": place, "turn": turn, "noise": noise, "marks": marks}


class Sysid:
    """The takes as a problem of `mujoco.sysid`."""

    def __init__(self, takes, begins):
        self.takes, self.begins = takes, begins
        self.model = mujoco.MjModel.from_xml_string(XML)
        self.datas = [mujoco.MjData(self.model) for _ in range(2)]
        self.start = [self.begun(take) for take in takes]
        self.steps = int(max(take["t"][-1] for take in takes) / STEP) + 2

    def begun(self, take, count=12):
        t, turns = take["t"][:count], take["turn"][:count]
        fallen = 0.5 * np.outer(t**2, self.begins["gravity"])
        place, velocity = np.polynomial.polynomial.polyfit(t, take["place"][:count] - fallen, 1)
        turn, spin = np.polynomial.polynomial.polyfit(t, (turns[0].inv() * turns).as_rotvec(), 1)
        return np.concatenate([place, turn, velocity, spin])

    def parameters(self):
        free = sysid.ParameterDict()
        for name, value in self.begins.items():
            value = np.atleast_1d(np.array(value, dtype=float))
            lower, upper = (np.broadcast_to(np.array(bound, dtype=float), value.shape).copy() for bound in BOUNDS[name])
            free.add(sysid.Parameter(name, value, lower, upper))
        for at, start in enumerate(self.start):
            free.add(sysid.Parameter(f"state {at}", start, start - ROUND, start + ROUND))
        return free

    def set(self, parameters):
        self.model.geom_friction[:, 0] = parameters["friction"].value[0]
        self.model.geom_solref[:] = -np.exp(parameters["contact"].value)
        self.model.opt.gravity[:] = parameters["gravity"].value

    def flown(self, states):
        initial = np.zeros((len(states), mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_FULLPHYSICS)))
        for row, take, state in zip(initial, self.takes, states):
            row[1:4], row[8:14] = state[:3], state[6:]
            row[4:8] = (take["turn"][0] * Rotation.from_rotvec(state[3:6])).as_quat(scalar_first=True)
        found, _ = rollout.rollout(self.model, self.datas, initial, nstep=self.steps)
        return np.concatenate([initial[:, None], found], axis=1)

    def residual(self, x, parameters):
        """Of each take; of many points at once, one a column, as the toolbox asks for differences."""
        if np.ndim(x) == 1:
            return self.residuals(x, parameters), None, None
        each = [self.residuals(column, parameters) for column in np.transpose(x)]
        return [np.stack(of, axis=1) for of in zip(*each)], None, None

    def residuals(self, x, parameters):
        parameters = parameters.copy()
        parameters.update_from_vector(x)
        self.set(parameters)
        motions = self.flown([parameters[f"state {at}"].value for at in range(len(self.takes))])
        residuals = []
        for take, motion in zip(self.takes, motions):
            at = take["t"] / STEP
            before = np.minimum(at.astype(int), len(motion) - 2)
            there = motion[before] + (at - before)[:, None] * (motion[before + 1] - motion[before])
            turn = Rotation.from_quat(there[:, 4:8], scalar_first=True)
            off = there[:, 1:4] + turn.apply(parameters["tracker"].value) - take["place"]
            turned = (take["turn"].inv() * turn).as_rotvec()
            residuals.append(np.concatenate([(off / take["noise"][0]).ravel(), (turned / take["noise"][1]).ravel()]))
        return residuals

    def restitution(self):
        data = mujoco.MjData(self.model)
        self.model.opt.gravity[:] = 0
        data.qpos[2], data.qvel[2] = 0.1, -3.0
        while not (data.qvel[2] > 0 and data.qpos[2] > 0.09) and data.time < 1:
            mujoco.mj_step(self.model, data)
        return max(data.qvel[2], 0.0) / 3.0

    def answer(self):
        # Steps of differences so long that they see past the steps of the simulation.
        found, result = sysid.optimize(self.parameters(), self.residual, verbose=False, max_iters=60, x_scale="jac", eps=1e-4)
        residuals = self.residuals(found.as_vector(), found)
        _, half = sysid.calculate_intervals(residuals, np.asarray(result.jac))
        answer, at = {}, 0
        for name, begins in self.begins.items():
            count = np.size(begins)
            answer[name] = found[name].value, half[at : at + count]
            at += count
        self.set(found)
        answer["restitution"] = np.array([self.restitution()]), None
        return answer


def by_enact(takes):
    scene = enact_motion.Scene.from_toml(SCENE)
    made = []
    for take in takes:
        of = enact_motion.Take(scene).poses("ball", take["t"], take["place"], take["turn"].as_quat(), order="xyzw")
        for name, mark in take["marks"].items():
            of = of.mark(name, mark)
        made.append(of)
    fit = enact_motion.fit(made, shared=["ball.restitution", "ball.friction", "gravity", "ball.tracker"])
    answer = {}
    for name in TRUE:
        of = [fit.parameters[key] for key in fit.parameters if key.split(".")[0] == name or key.split(".")[1] == name]
        has_interval = all(p.interval is not None for p in of)
        half = np.array([0.5 * (p.interval[1] - p.interval[0]) for p in of]) if has_interval else None
        answer[name] = np.array([p.value for p in of]), half
    return answer


WAYS = {"enact": by_enact} | {
    f"mujoco.sysid from {name}": lambda takes, begins=begins: Sysid(takes, begins).answer() for name, begins in BEGINS.items()
}


def versions():
    here = pathlib.Path(__file__).parent
    git = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=here, capture_output=True, text=True, check=False)
    packages = {name: importlib.metadata.version(name) for name in ["enact-motion", "mujoco", "mujoco_sysid", "numpy", "scipy"]}
    return packages | {"python": platform.python_version(), "revision": git.stdout.strip() or "unknown"}


def answered(way, seed, count):
    """What one way makes of the takes of a seed: how far each number is off, whether its interval holds, time for all takes."""
    random = np.random.default_rng(seed)
    takes = [thrown(random) for _ in range(count)]
    wall, core = time.perf_counter(), time.process_time()
    numbers, why = {}, None
    try:
        answer = WAYS[way](takes)
    except (RuntimeError, ValueError, np.linalg.LinAlgError) as error:
        why = str(error)
    else:
        for name, truth in TRUE.items():
            values, half = answer[name]
            off = np.abs(values - truth)
            numbers[name] = {"off": off.tolist(), "is_held": None if half is None else (off <= half).tolist()}
    return {
        "way": way,
        "seed": seed,
        "takes": count,
        "why_none": why,
        "numbers": numbers,
        "wall_s": time.perf_counter() - wall,
        "core_s": time.process_time() - core,
    }


def write(path, report):
    beside = path.with_name(path.name + ".part")
    beside.write_text(json.dumps(report))
    os.replace(beside, path)


def table(answers):
    print("| | restitution off: median | friction | gravity, m/s² | tracker, mm | in 95 % intervals | time of a core for a take, s |")
    print("|---|---|---|---|---|---|---|")
    for way in WAYS:
        of = [answer for answer in answers if answer["way"] == way]
        found = [answer["numbers"] for answer in of if answer["numbers"]]
        median = {name: np.median([off for each in found for off in each[name]["off"]]) for name in TRUE}
        held = [is_held for each in found for name in TRUE for is_held in each[name]["is_held"] or []]
        print(
            f"| {way} | {median['restitution']:.2g} | {median['friction']:.2g} | {median['gravity']:.2g} | {1e3 * median['tracker']:.2g} "
            f"| {sum(held)} of {len(held)} | {np.median([answer['core_s'] / answer['takes'] for answer in of]):.2g} |"
        )


def main():
    ask = argparse.ArgumentParser()
    ask.add_argument("answers", type=pathlib.Path)
    ask.add_argument("--seeds", type=int, default=5)
    ask.add_argument("--takes", type=int, default=10)
    ask.add_argument("--first", type=int, default=9000)
    asked = ask.parse_args()
    report = {"versions": versions(), "answers": []}
    if asked.answers.exists():
        report = json.loads(asked.answers.read_text())
    there = {(of["way"], of["seed"], of["takes"]) for of in report["answers"]}
    for seed in range(asked.first, asked.first + asked.seeds):
        for way in WAYS:
            if (way, seed, asked.takes) not in there:
                report["answers"].append(answered(way, seed, asked.takes))
                write(asked.answers, report)
    table(report["answers"])


if __name__ == "__main__":
    main()
