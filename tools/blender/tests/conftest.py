# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender as a module, with the extension installed from its zip and enabled, in a home of its own."""

import os
import shutil
import sys
import tempfile
from pathlib import Path

import pytest

ZIP = os.environ.get("MOTION_SKETCH_ZIP")
HOME = tempfile.mkdtemp(prefix="motion_sketch_home")
os.environ["BLENDER_USER_RESOURCES"] = HOME

import bpy  # noqa: E402

STATUS = pytest.StashKey[int]()
MODULE = "bl_ext.user_default.motion_sketch"


def install():
    if ZIP is None:
        pytest.exit("MOTION_SKETCH_ZIP: unset, expected the zip that tools/blender/build.py makes: run tools/blender/check.sh", 2)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    # The module comes without its own add-on for extensions until that is enabled.
    import addon_utils

    addon_utils.enable("bl_pkg", default_set=True)
    done = bpy.ops.extensions.package_install_files(filepath=ZIP, repo="user_default", enable_on_install=True, overwrite=True)
    assert done == {"FINISHED"}, done
    assert MODULE in bpy.context.preferences.addons, "it is installed and enabled"


install()


@pytest.fixture(autouse=True)
def empty():
    """An empty scene before each test; the extension stays enabled."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    if MODULE not in bpy.context.preferences.addons:
        bpy.ops.preferences.addon_enable(module=MODULE)
    yield


@pytest.fixture
def parts():
    """The modules of the extension as installed, by name."""
    from importlib import import_module
    from types import SimpleNamespace

    names = ["account", "acted", "baking", "channels", "goals", "handlers", "happening", "live", "markers", "motion", "operators",
             "poses", "proposing", "reading", "refusal", "shapes", "solving", "things", "units", "worker", "working"]
    return SimpleNamespace(**{name: import_module(f"{MODULE}.{name}") for name in names})


def pytest_sessionfinish(session, exitstatus):
    session.config.stash[STATUS] = int(exitstatus)
    shutil.rmtree(HOME, ignore_errors=True)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config):
    leave(config.stash.get(STATUS, 1))


def leave(status):
    """Ends the process at once: the module itself crashes at exit (4.2, once a panel was registered) or hangs (4.5, in its movies)."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


@pytest.fixture
def program():
    """The path of `enact`, of the same revision: ENACT says it."""
    path = os.environ.get("ENACT")
    if path is None:
        pytest.fail("no ENACT: expected the path of the program")
    return path


sys.path.insert(0, str(Path(__file__).parent))
