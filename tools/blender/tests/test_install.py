# SPDX-License-Identifier: GPL-3.0-or-later
"""The zip is installed, enabled, disabled and enabled again; nothing is fetched."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import bpy
import pytest
import stage
from conftest import HOME, MODULE, ZIP


def test_the_wheel_inside_is_what_is_imported():
    import enact_motion

    assert Path(enact_motion.__file__).is_relative_to(Path(HOME)), enact_motion.__file__
    assert enact_motion.Scene.new("die").bodies == ("die",)


def test_zip_says_what_it_is():
    with zipfile.ZipFile(ZIP) as file:
        names = file.namelist()
        manifest = file.read(next(of for of in names if of.endswith("blender_manifest.toml"))).decode()
    assert sum(of.endswith(".whl") for of in names) == 1
    assert any(of.endswith("LICENSE") for of in names)
    assert not any("__pycache__" in of or "tests" in of for of in names)
    assert 'license = ["SPDX:GPL-3.0-or-later"]' in manifest and "[permissions]" in manifest and "platforms" in manifest
    assert "blender" not in manifest.split('name = "')[1].split('"')[0].lower(), "its name has not the program's in it"
    assert "network" not in manifest


def test_disabling_leaves_nothing_and_enabling_brings_all_back():
    handlers = len(bpy.app.handlers.depsgraph_update_post)
    bpy.ops.preferences.addon_disable(module=MODULE)
    assert not hasattr(bpy.types.Scene, "motion_sketch") and not hasattr(bpy.types.Object, "motion_sketch")
    assert len(bpy.app.handlers.depsgraph_update_post) == handlers - 1
    with pytest.raises(AttributeError):
        bpy.ops.motion_sketch.make_physical()
    bpy.ops.preferences.addon_enable(module=MODULE)
    assert len(bpy.app.handlers.depsgraph_update_post) == handlers
    thing, *_ = stage.tossed_ball()
    stage.select(thing)
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}


def test_another_process_finds_it_installed():
    done = subprocess.run(
        [sys.executable, "-c", f"import bpy, addon_utils\nbpy.ops.preferences.addon_enable(module={MODULE!r})\n"
         "import enact_motion\nprint(bpy.ops.motion_sketch.make_physical.idname(), enact_motion.__name__)"],
        capture_output=True, text=True, env=os.environ | {"BLENDER_USER_RESOURCES": HOME},
    )
    assert "MOTION_SKETCH_OT_make_physical enact_motion" in done.stdout, done.stdout + done.stderr


def test_every_panel_draws():
    """A panel is drawn only in a window: its layout is stood in for, and every operator and property that it asks for is there."""
    from importlib import import_module

    panel = import_module(f"{MODULE}.panel")

    class Row:
        def __init__(self):
            self.seen = []

        def label(self, text="", icon=""):
            self.seen.append(text)

        def prop(self, of, name, **_):
            assert name in of.bl_rna.properties, name
            self.seen.append(name)

        def operator(self, name, **_):
            group, verb = name.split(".")
            kind = getattr(getattr(bpy.ops, group), verb).get_rna_type()
            self.seen.append(name)
            from types import SimpleNamespace

            made = SimpleNamespace()
            made.allowed = set(kind.properties.keys())
            return made

        def operator_menu_enum(self, name, prop, **_):
            return self.operator(name)

        def row(self, **_):
            return self

        def column(self, **_):
            return self

    thing, *_ = stage.tossed_ball(strays=0.01)
    stage.select(thing)
    bpy.ops.motion_sketch.make_physical()
    bpy.ops.motion_sketch.add_goal(goal="POSE")
    goal = bpy.data.objects["Ball pose"]
    context = bpy.context
    seen = []
    for active in (thing, goal):
        stage.select(active)
        for of in panel.CLASSES:
            from types import SimpleNamespace

            row = Row()
            of.draw(SimpleNamespace(layout=row), context)
            seen += row.seen
    assert any(of.startswith("bounce") for of in seen) or "motion_sketch.jump" in seen
    assert "motion_sketch.make_physical" in seen and "motion_sketch.restore" in seen and "event" in seen
    assert any("next:" in of for of in seen)


@pytest.mark.parametrize(("tag", "platform"), [
    ("manylinux_2_35_x86_64", "linux-x64"), ("musllinux_1_2_aarch64", "linux-arm64"), ("macosx_11_0_arm64", "macos-arm64"),
    ("macosx_10_12_x86_64", "macos-x64"), ("win_amd64", "windows-x64"), ("win_arm64", "windows-arm64"),
])
def test_every_platform_has_a_zip_of_its_own(tag, platform, monkeypatch):
    """Wheels of other platforms are not built here: their names alone are read."""
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1]))
    import build

    assert build.platform_of(Path(f"enact_motion-0.1.0-cp311-abi3-{tag}.whl")) == platform
    with pytest.raises(SystemExit, match="expected the name of a wheel"):
        build.platform_of(Path("enact_motion-0.1.0-cp311-abi3-any.whl"))
