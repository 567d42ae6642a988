"""Threads, pickles, deadlines and Ctrl-C."""

import multiprocessing
import pickle
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from conftest import RECORDINGS

import enact_motion


def report(path):
    return enact_motion.read(path).estimate()._words()


def test_threads_and_processes_give_the_same_bits():
    serial = [report(path) for path in RECORDINGS]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(report, RECORDINGS * 3)) == serial * 3
    take = enact_motion.read(RECORDINGS[0])
    with ThreadPoolExecutor(4) as pool:
        of_one = pool.map(lambda _: take.estimate()._words(), range(6))
        assert set(of_one) == {serial[0]}
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        assert pool.map(report, RECORDINGS[:2]) == serial[:2]


def test_other_threads_go_on_meanwhile(recordings):
    take = enact_motion.read(recordings["hat_box_bent"])
    longest = 0.0
    done = threading.Event()

    def look():
        nonlocal longest
        last = time.perf_counter()
        while not done.is_set():
            time.sleep(0.001)
            now = time.perf_counter()
            longest, last = max(longest, now - last), now

    watching = threading.Thread(target=look)
    watching.start()
    begun = time.perf_counter()
    take.estimate()
    spent = time.perf_counter() - begun
    done.set()
    watching.join()
    # A run that holds on to the interpreter lets nobody look until it is over.
    assert longest < 0.7 * spent, (longest, spent)


@pytest.mark.parametrize("path", RECORDINGS, ids=lambda path: path.stem)
def test_a_pickled_estimate_is_the_same(path, tmp_path):
    estimate = enact_motion.read(path).estimate()
    data = pickle.dumps(estimate)
    again = pickle.loads(data)
    assert again._core is None
    assert again.report == estimate.report and again.events == estimate.events
    assert again._core is None, "it says all without the motion"
    body = again.take.scene.bodies[0]
    assert (again.sample(100, body).position == estimate.sample(100, body).position).all()
    estimate.write(tmp_path / "a.mcap")
    again.write(tmp_path / "b.mcap")
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()
    assert pickle.dumps(again) == data
    # All of it is in the pickle: the file may be gone.
    take = pickle.loads(pickle.dumps(estimate.take))
    assert take.to_bytes() == path.read_bytes()


def test_errors_scenes_and_records_are_pickled(recordings):
    scene = enact_motion.Scene.new("die", lands="+z")
    assert pickle.loads(pickle.dumps(scene)) == scene
    event = enact_motion.read(recordings["pencil_tip"]).estimate().events[0]
    assert pickle.loads(pickle.dumps(event)) == event and event.impulse[2] > 0
    error = enact_motion.SceneError("no", "scene.toml", 3, 4)
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.line) == ("scene.toml:3:4: no", 3)
    error = enact_motion.TakeError("no", ["likely"])
    assert pickle.loads(pickle.dumps(error)).diagnoses == ("likely",)


def test_an_update_is_pickled_with_what_it_began_at(recordings):
    estimate = enact_motion.read(recordings["pencil_tip"]).estimate()
    goals = estimate.take.scene.goals
    goals[0]["position_mm"][1] += 3
    updated = estimate.update(goals=goals)
    again = pickle.loads(pickle.dumps(updated))
    assert again.report == updated.report
    assert (again.sample(100).position == updated.sample(100).position).all()


def test_a_deadline_ends_a_run_and_says_so(recordings):
    take = enact_motion.read(recordings["hat_box_bent"])
    whole = take.estimate(deadline=60)
    assert not whole.is_late and whole.report == take.estimate().report
    begun = time.perf_counter()
    late = take.estimate(deadline=0)
    assert time.perf_counter() - begun < 1.0
    assert late.is_late and late.verdict != "physical", late
    assert "stopped" in late.report["termination"]["kind"] or late.verdict in ("failed", "plausible")
    again = pickle.loads(pickle.dumps(late))
    assert again.verdict == late.verdict
    with pytest.raises(ValueError, match="deadline"):
        again.sample(60, "hat")
    for wrong in [-1, float("nan")]:
        with pytest.raises(ValueError, match="^deadline: "):
            take.estimate(deadline=wrong)


SCRIPT = """
import signal, sys, threading, time
import enact_motion
# A shell that runs it in the background has it ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
take = enact_motion.read(sys.argv[1])
print("ready", flush=True)
begun = time.monotonic()
try:
    while time.monotonic() - begun < 60:
        take.estimate(free="auto")
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT from another process")
def test_ctrl_c_ends_a_run(recordings):
    command = [sys.executable, "-c", SCRIPT, str(recordings["hat_box_bent"])]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as run:
        assert run.stdout.readline() == "ready\n"
        time.sleep(0.4)
        begun = time.monotonic()
        run.send_signal(signal.SIGINT)
        assert run.stdout.readline() == "interrupted\n"
        assert time.monotonic() - begun < 1.0
        assert run.wait(10) == 0


def test_importing_is_quick_and_loads_no_numpy():
    script = "import sys, time; a = time.perf_counter(); import enact_motion; print(time.perf_counter() - a, 'numpy' in sys.modules)"
    runs = [subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True) for _ in range(3)]
    spent = [run.stdout.split() for run in runs]
    assert min(float(seconds) for seconds, _ in spent) < 0.05, spent
    assert {numpy for _, numpy in spent} == {"False"}
