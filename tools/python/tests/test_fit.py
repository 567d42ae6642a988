"""One answer from many takes: as by the program, of arrays, in parts, and what is refused."""

import json
import pickle
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import enact_motion

G = 9.80665
RADIUS = 0.0335


def thrown(seed, restitution):
    """A take of a ball that bounces upright, with that restitution and a camera's noise."""
    random = np.random.default_rng(seed)
    scene = enact_motion.Scene.new("ball", stamps="physical")
    height = random.uniform(0.7, 1.1)
    falls = np.sqrt(2 * (height - RADIUS) / G)
    speed = restitution * G * falls
    ends = falls + 0.9 * 2 * speed / G
    t = np.arange(0, ends, 1 / 240)
    after = np.maximum(t - falls, 0)
    z = np.where(t < falls, height - 0.5 * G * t**2, RADIUS + speed * after - 0.5 * G * after**2)
    position = np.stack([0 * t, 0 * t, z], axis=1) + random.normal(0, 2e-4, (len(t), 3))
    quaternion = np.tile([1.0, 0, 0, 0], (len(t), 1)) + np.c_[0 * t, random.normal(0, 1e-3, (len(t), 3))]
    take = enact_motion.Take(scene).poses("ball", t, position, quaternion, order="wxyz")
    return take.mark("bounce", falls).mark("landing", ends - 0.004)


@pytest.fixture(scope="module")
def takes():
    return [thrown(seed, 0.6) for seed in range(6)]


@pytest.fixture(scope="module")
def files(takes, tmp_path_factory):
    folder = tmp_path_factory.mktemp("takes")
    paths = [folder / f"take_{at}.mcap" for at in range(len(takes))]
    for path, take in zip(paths, takes):
        path.write_bytes(take.to_bytes())
    return paths


def test_restitution_of_takes_is_one_line(files):
    fit = enact_motion.fit(files, shared=["ball.restitution"])
    of = fit.parameters["ball.restitution"]
    assert of.determined and not of.drawn and of.interval[0] < of.value < of.interval[1]
    assert abs(of.value - 0.6) < 0.001
    assert fit.correlations.shape == (1, 1) and fit.against == ()
    assert [take["part"] for take in fit.takes] == ["fitted"] * len(files)
    assert pickle.loads(pickle.dumps(fit)).parameters == fit.parameters


def test_an_answer_is_that_of_the_program(program, files):
    command = [program, "fit", *map(str, files), "--shared", "ball.restitution", "--hold-out", "0.4", "--format", "ndjson"]
    ran = subprocess.run(command, capture_output=True, timeout=120)
    assert ran.returncode in (0, 3), ran.stderr
    said = [json.loads(line) for line in ran.stdout.splitlines()]
    said = next(of for of in said if of["schema"] == "enact.fit/1")
    fit = enact_motion.fit(files, shared=["ball.restitution"], hold_out=0.4)
    for key in ("parameters", "held_out", "against", "rounds"):
        assert fit.report[key] == said[key]


def test_takes_of_arrays_say_what_their_files_say(takes, files):
    of_takes = enact_motion.fit(takes, shared=["ball.restitution", "gravity"])
    of_files = enact_motion.fit(files, shared=["ball.restitution", "gravity"])
    for name, of in of_files.parameters.items():
        assert of_takes.parameters[name].value == of.value


def test_what_takes_draw_has_a_spread(tmp_path):
    restitutions = 0.6 + 0.05 * np.random.default_rng(5).standard_normal(8)
    fit = enact_motion.fit([thrown(40 + at, of) for at, of in enumerate(restitutions)], drawn=["ball.restitution"])
    of = fit.parameters["ball.restitution"]
    assert of.drawn and abs(of.value - restitutions.mean()) < 0.001
    assert abs(of.spread - restitutions.std(ddof=1)) < 0.001
    assert of.spread_interval[0] < of.spread < of.spread_interval[1]


def joined(takes, **names):
    blocks = [enact_motion.reduce(take, **names) for take in takes]
    for _ in range(40):
        answer = enact_motion.join(blocks)
        if isinstance(answer, enact_motion.Fit):
            return answer
        more = [enact_motion.reduce(take, question=answer, **names) for take in takes]
        blocks += [block for block in more if block is not None]
    raise AssertionError("no answer")


def test_blocks_that_are_made_apart_have_the_same_answer(takes):
    names = {"shared": ["ball.restitution"]}
    of = joined(takes, **names).parameters["ball.restitution"]
    whole = enact_motion.fit(takes, **names).parameters["ball.restitution"]
    assert abs(of.value - whole.value) < 0.1 * whole.sd
    assert abs(of.sd - whole.sd) < 0.1 * whole.sd


def test_what_cannot_be_asked_is_said(files, tmp_path):
    with pytest.raises(enact_motion.TakeError, match="nothing is asked for"):
        enact_motion.fit(files)
    with pytest.raises(TypeError, match="expected a list of names"):
        enact_motion.fit(files, shared="gravity")
    with pytest.raises(ValueError, match="a share between 0 and 1"):
        enact_motion.fit(files, shared=["gravity"], hold_out=1.5)
    with pytest.raises(ValueError, match="blocks\\[0\\]"):
        enact_motion.join([b"{}"])
    bad = tmp_path / "bad.mcap"
    bad.write_bytes(b"no recording")
    fit = enact_motion.fit([*files, bad], shared=["ball.restitution"])
    assert fit.takes[-1]["part"] == "left_out" and "1 takes took no part" in fit.against
    assert enact_motion.reduce(bad, shared=["gravity"]) is not None


def test_ctrl_c_ends_it_between_takes(files, tmp_path):
    script = tmp_path / "long.py"
    script.write_text(
        "import signal, sys, enact_motion\n"
        # A shell that runs it in the background has it ignored.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "print('begun', flush=True)\n"
        "try:\n"
        "    while True:\n"
        "        enact_motion.fit(sys.argv[1:], shared=['ball.restitution', 'gravity'])\n"
        "except KeyboardInterrupt:\n"
        "    print('ended', flush=True)\n"
    )
    import signal

    ran = subprocess.Popen([sys.executable, "-P", str(script), *map(str, files)], stdout=subprocess.PIPE)
    assert ran.stdout.readline() == b"begun\n"
    time.sleep(0.5)
    ran.send_signal(signal.SIGINT)
    said, _ = ran.communicate(timeout=30)
    assert said == b"ended\n" and ran.returncode == 0


def test_the_example_on_ray_has_the_same_answer(files):
    ray = pytest.importorskip("ray", reason="no ray: pip install 'ray[data]'")
    assert ray.__version__
    example = Path(__file__).parents[1] / "examples" / "on_ray.py"
    command = [sys.executable, "-P", str(example), str(files[0].parent), "ball.restitution"]
    ran = subprocess.run(command, capture_output=True, timeout=300)
    assert ran.returncode == 0, ran.stderr
    name, value = ran.stdout.split()[-2:]
    whole = enact_motion.fit(files, shared=["ball.restitution"]).parameters["ball.restitution"]
    assert name == b"ball.restitution" and abs(float(value) - whole.value) < 0.1 * whole.sd
