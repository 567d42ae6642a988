"""Where real tosses come to rest by MuJoCo, from the states that `predict_tosses` wrote.

    cargo run --release -p enact-tools --bin predict_tosses -- -o tosses.json
    tools/peers/.venv/bin/python tools/peers/tosses.py tosses.json

Friction, stiffness and damping of contacts are fitted to the same half of the tosses by the same measure, the mean square root of the
horizontal distance at rest, and the other half is predicted.
"""

import json
import math
import sys

import mujoco
import numpy as np
from scipy.optimize import minimize

XML = """<mujoco><option timestep="{step}" gravity="{gravity}" integrator="implicitfast" cone="elliptic" impratio="10"/>
<default><geom friction="{friction} 0.0001 0.00001" solref="-{stiffness} -{damping}" solimp="0.9 0.95 0.001"/></default>
<worldbody><geom type="plane" size="5 5 1"/>
<body><freejoint/><inertial pos="0 0 0" mass="{mass}" diaginertia="{moment} {moment} {moment}"/>
<geom type="box" size="{half} {half} {half}" condim="3"/></body></worldbody></mujoco>"""
STEP_S = 0.0005


def flown(toss, gravity):
    """The state at the end of the flight: the spin of a body with equal moments is constant."""
    s = toss["until_end_s"]
    x, v = np.array(toss["state"]["position_m"]), np.array(toss["velocity_m_s"])
    w = np.array(toss["spin_rad_s"])
    turned = np.empty(4)
    angle = np.linalg.norm(w) * s
    axis = w / np.linalg.norm(w)
    turn = np.array([math.cos(angle / 2), *(math.sin(angle / 2) * axis)])
    mujoco.mju_mulQuat(turned, np.array(toss["state"]["wxyz"]), turn)
    return x + v * s + gravity * s * s / 2, turned, v + gravity * s, w


def errors(data, tosses, friction, stiffness, damping):
    gravity = np.array(data["gravity_m_s2"])
    model = mujoco.MjModel.from_xml_string(
        XML.format(step=STEP_S, gravity=" ".join(map(str, gravity)), friction=friction, stiffness=stiffness,
                   damping=damping, mass=data["mass_kg"], moment=data["moment_kg_m2"], half=data["side_m"] / 2))
    state = mujoco.MjData(model)
    out = []
    for toss in tosses:
        mujoco.mj_resetData(model, state)
        x, q, v, w = flown(toss, gravity)
        state.qpos[:3], state.qpos[3:], state.qvel[:3], state.qvel[3:] = x, q, v, w
        for _ in range(int(data["limit_s"] / STEP_S)):
            mujoco.mj_step(model, state)
        off = np.linalg.norm(state.qpos[:2] - np.array(toss["rest"]["position_m"])[:2])
        between = abs(np.dot(state.qpos[3:], toss["rest"]["wxyz"]))
        out.append((off, 2 * math.degrees(math.acos(min(1.0, between)))))
    return np.array(out)


def line(name, half, of):
    mm = of[:, 0] * 1e3
    low, middle, high = np.percentile(mm, [25, 50, 75])
    print(f"{name}, {half}: median {middle:.1f} mm (quartiles {low:.1f}, {high:.1f}), mean {mm.mean():.1f} mm, "
          f"orientation within 20 deg {np.mean(of[:, 1] < 20) * 100:.0f} %, {len(mm)} tosses")


def main():
    data = json.load(open(sys.argv[1]))
    train = [toss for toss in data["tosses"] if not toss["held_out"]]
    held_out = [toss for toss in data["tosses"] if toss["held_out"]]

    def cost(p):
        return np.sqrt(errors(data, train, *np.exp(p))[:, 0]).mean()

    starts = [(0.18, 2000.0, 40.0), (0.2, 4000.0, 60.0)]
    fits = [minimize(cost, np.log(start), method="Nelder-Mead", options={"maxfev": 60, "xatol": 0.01, "fatol": 1e-4})
            for start in starts]
    best = min(fits, key=lambda fit: fit.fun)
    friction, stiffness, damping = np.exp(best.x)
    print(f"MuJoCo {mujoco.__version__}: friction {friction:.3f}, stiffness {stiffness:.0f}, damping {damping:.1f}, cost {best.fun:.4f}")
    line("MuJoCo", "train", errors(data, train, friction, stiffness, damping))
    line("MuJoCo", "held out", errors(data, held_out, friction, stiffness, damping))
    for row in data["predictions"]:
        low, high = row["quartiles_mm"]
        print(f"enact, {row['name']}, {row['half']}: median {row['median_mm']:.1f} mm (quartiles {low:.1f}, {high:.1f}), "
              f"mean {row['mean_mm']:.1f} mm, orientation within 20 deg {row['orientation_within_20_deg'] * 100:.0f} %, {row['tosses']} tosses")


if __name__ == "__main__":
    main()
