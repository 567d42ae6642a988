# SPDX-License-Identifier: GPL-3.0-or-later
"""The baked action is what the program makes of the saved recording, and exports of Blender carry it."""

import csv
import subprocess

import bpy
import numpy as np
import pytest
import stage
from test_goals import goal, thrown_die, tossed_box


def table_of(program, path):
    """Rows of `enact export --to csv` of a recording: times, places, quaternions, and what kind of motion."""
    estimate, out = path.with_suffix(".estimate.mcap"), path.with_suffix(".csv")
    subprocess.run([program, "replay", path, "-o", estimate], check=False, capture_output=True)
    subprocess.run([program, "export", estimate, "--to", "csv", "--fps", "240", "-o", out], check=False, capture_output=True)
    rows = list(csv.DictReader(line for line in out.read_text().splitlines() if not line.startswith("#")))
    assert rows
    return rows


@pytest.mark.parametrize("case", ["ball", "box", "die"])
def test_the_same_as_the_command_line(program, tmp_path, case):
    if case == "ball":
        thing, *_ = stage.tossed_ball(fps=24, strays=0.02)
    elif case == "box":
        thing, last = tossed_box(fps=30)
        of = goal("POSE", thing)
        of.location = (0.5, 0.15, 0.9)
    else:
        thing, *_ = thrown_die(fps=60)
        goal("FACES", thing)
    stage.select(thing)
    path = tmp_path / "take.mcap"
    assert bpy.ops.motion_sketch.save_take(filepath=str(path)) == {"FINISHED"}
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
    frames, keys = stage.keys(thing)
    fps = bpy.context.scene.render.fps
    seconds = (frames - 1) / fps
    rows = [of for of in table_of(program, path) if of["motion"] in ("estimate", "simulated")]
    t = np.array([float(of["t_s"]) for of in rows])
    compared = 0
    for second, key in zip(seconds, keys):
        near = np.argmin(abs(t - second))
        # Frames are keys at single precision: those of both at the same instant are compared.
        if abs(t[near] - second) > 2e-7:
            continue
        place = np.array([float(rows[near][of]) for of in ("x_m", "y_m", "z_m")])
        turn = np.array([float(rows[near][of]) for of in ("qw", "qx", "qy", "qz")])
        assert np.abs(place - key[:3]).max() < 1e-6, (second, place, key[:3])
        assert min(np.abs(turn - key[3:]).max(), np.abs(turn + key[3:]).max()) < 1e-6
        compared += 1
    assert compared > 5, "keys of both at the same instants"


@pytest.mark.parametrize("kind", ["glb", "usd", "abc", "fbx"])
def test_exports_carry_it(tmp_path, kind):
    thing, table, hit, last = stage.tossed_ball(fps=24, strays=0.02)
    stage.select(thing)
    bpy.ops.motion_sketch.make_physical()
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, int(last)
    wanted = {frame: stage.world(thing, frame).translation.copy() for frame in range(2, int(last))}
    path = str(tmp_path / f"x.{kind}")
    stage.select(thing)
    if kind == "glb":
        bpy.ops.export_scene.gltf(filepath=path, use_selection=True)
    elif kind == "usd":
        bpy.ops.wm.usd_export(filepath=path, selected_objects_only=True, export_animation=True)
    elif kind == "abc":
        bpy.ops.wm.alembic_export(filepath=path, selected=True, start=1, end=int(last), as_background_job=False)
    else:
        bpy.ops.export_scene.fbx(filepath=path, use_selection=True, bake_anim=True)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.fps = 24
    {"glb": lambda: bpy.ops.import_scene.gltf(filepath=path), "usd": lambda: bpy.ops.wm.usd_import(filepath=path),
     "abc": lambda: bpy.ops.wm.alembic_import(filepath=path, as_background_job=False),
     "fbx": lambda: bpy.ops.import_scene.fbx(filepath=path)}[kind]()
    found = next(of for of in scene.objects if of.type == "MESH")
    # Importers begin at the frame that the file says, or at another one of their own.
    for shift in (0, 1, -1):
        away = [(stage.world(found, frame + shift).translation - of).length for frame, of in wanted.items()]
        if max(away) < 2e-4:
            return
    pytest.fail(f"{max(away)} m away")


def test_an_action_as_a_table_is_imported_by_the_program(program, tmp_path):
    thing, *_ = stage.tossed_ball(fps=24)
    table = tmp_path / "acted.csv"
    rows = ["t,x,y,z,qw,qx,qy,qz"]
    for frame in range(1, 20):
        world = stage.world(thing, frame)
        rows.append(",".join(map(repr, [(frame - 1) / 24, *world.translation, *world.to_quaternion()])))
    table.write_text("\n".join(rows))
    out = tmp_path / "acted.mcap"
    done = subprocess.run([program, "import", table, "-o", out], capture_output=True, text=True)
    assert out.exists() and "19" in done.stdout + done.stderr, done.stderr
