"""The wheel and the program are one: their files are the same, byte for byte."""

import subprocess

import numpy as np
import pytest
from conftest import RECORDINGS

import enact_motion


def replayed(program, recording, output, *more):
    command = [program, "replay", str(recording), "-o", str(output), *more]
    ran = subprocess.run(command, capture_output=True, timeout=120)
    # 3: it is done, and something speaks against the motion.
    assert ran.returncode in (0, 3), ran.stderr
    return output.read_bytes()


@pytest.mark.parametrize("free", [None, "auto"])
@pytest.mark.parametrize("path", RECORDINGS, ids=lambda path: path.stem)
def test_a_recording_is_estimated_as_by_the_program(program, path, free, tmp_path):
    more = [] if free is None else ["--free", free]
    expected = replayed(program, path, tmp_path / "program.mcap", *more)
    estimate = enact_motion.read(path).estimate(free=free)
    estimate.write(tmp_path / "wheel.mcap")
    assert (tmp_path / "wheel.mcap").read_bytes() == expected
    # Of bytes too, under the same name: the name is in what is written.
    of_bytes = enact_motion.read(path.read_bytes()).estimate(free=free)
    assert of_bytes.events == estimate.events
    assert of_bytes.parameters == estimate.parameters


def test_a_scene_of_its_own_and_no_diagnoses_are_as_by_the_program(program, recordings, tmp_path):
    path = recordings["pencil_tip"]
    scene = tmp_path / "scene.toml"
    scene.write_text(enact_motion.read(path).scene.toml.replace("restitution = 0.75", "restitution = 0.7"))
    more = ["--scene", str(scene), "--no-diagnose"]
    expected = replayed(program, path, tmp_path / "program.mcap", *more)
    take = enact_motion.read(path, scene=enact_motion.Scene.from_file(scene))
    take.estimate(diagnose=False).write(tmp_path / "wheel.mcap")
    assert (tmp_path / "wheel.mcap").read_bytes() == expected


def test_a_take_of_arrays_is_the_recording_that_it_makes(program, recordings, tmp_path):
    scene = enact_motion.Scene.new("die", mass_g=500, size_mm=[80, 80, 80], stamps="physical")
    t = np.arange(0, 0.7, 0.005)
    falling = np.minimum(t, 0.35), np.maximum(t - 0.35, 0)
    height = 1.0 - 4.9 * falling[0] ** 2 + 1.6 * falling[1] - 4.9 * falling[1] ** 2
    position = np.stack([0.1 * t, 0 * t, height], axis=1)
    turn = 0.5 * 1.5 * t
    quaternion = np.stack([np.cos(turn), 0 * t, np.sin(turn), 0 * t], axis=1)
    take = enact_motion.Take(scene).poses("die", t, position, quaternion, order="wxyz")
    take.mark("bounce", 0.35).mark("landing", 0.69)
    (tmp_path / "take.mcap").write_bytes(take.to_bytes())
    expected = replayed(program, tmp_path / "take.mcap", tmp_path / "program.mcap")
    take.estimate().write(tmp_path / "wheel.mcap")
    assert (tmp_path / "wheel.mcap").read_bytes() == expected


def test_new_scenes_are_those_of_the_program(program, tmp_path):
    for name, size in [("die", None), ("book", [200, 150, 30]), ("pencil", None)]:
        path = tmp_path / f"{name}.toml"
        more = [] if size is None else ["--size-mm", ",".join(map(str, size)), "--mass-g", "400"]
        subprocess.run([program, "scene", "new", name, *more, "-o", str(path)], check=True, capture_output=True)
        mass = None if size is None else 400
        scene = enact_motion.Scene.new(name, size_mm=size, mass_g=mass)
        # Its first line says what command made it.
        assert path.read_text().split("\n", 1)[1] == scene.toml


def test_what_is_written_is_not_what_was_read(recordings, tmp_path):
    path = tmp_path / "take.mcap"
    path.write_bytes(recordings["pencil_tip"].read_bytes())
    estimate = enact_motion.read(path).estimate()
    with pytest.raises(enact_motion.TakeError, match="take.mcap"):
        estimate.write(path)
    with pytest.raises(OSError):
        estimate.write(tmp_path / "no such folder" / "out.mcap")
    assert path.read_bytes() == recordings["pencil_tip"].read_bytes()
