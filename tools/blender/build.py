# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes one zip per wheel: the extension for the platform of that, with the wheel inside.

    python tools/blender/build.py --out DIR WHEEL...

Runs where the module bpy is installed: its own extension tool builds each zip and validates it.
"""

import argparse
import importlib.util
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

PACKAGE = Path(__file__).parent / "motion_sketch"
LICENCE = Path(__file__).parent / "LICENSE"
#: What the end of a wheel's name says, and what the platform is called.
PLATFORMS = {
    r"(many|musl)?linux.*_x86_64": "linux-x64",
    r"(many|musl)?linux.*_aarch64": "linux-arm64",
    r"macosx_.*_arm64": "macos-arm64",
    r"macosx_.*_x86_64": "macos-x64",
    r"win_amd64": "windows-x64",
    r"win_arm64": "windows-arm64",
}


def platform_of(wheel):
    """The platform of a wheel; fails where its name says none."""
    tag = wheel.stem.split("-")[-1]
    for pattern, platform in PLATFORMS.items():
        if re.match(pattern, tag):
            return platform
    sys.exit(f"{wheel}: platform {tag!r}, expected the name of a wheel as maturin gives it")


def tool():
    """The extension tool that comes with bpy."""
    spec = importlib.util.find_spec("bpy")
    found = list(Path(spec.origin).parent.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py")) if spec else []
    return found[0] if found else sys.exit("no extension tool, expected the module bpy: pip install bpy")


def staged(folder, wheel, platform):
    """The sources of the extension for a platform."""
    source = folder / "motion_sketch"
    shutil.copytree(PACKAGE, source, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(LICENCE, source / "LICENSE")
    (source / "wheels").mkdir()
    shutil.copy(wheel, source / "wheels")
    manifest = source / "blender_manifest.toml"
    has = f'platforms = ["{platform}"]\nwheels = ["./wheels/{wheel.name}"]\n\n[permissions]'
    manifest.write_text(manifest.read_text().replace("[permissions]", has, 1))
    return source


def run(*arguments):
    """The tool with arguments; ends where that fails."""
    done = subprocess.run([sys.executable, tool(), *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, arguments))}: {done.stdout}{done.stderr}")


def build(wheel, out):
    """The zip of a wheel."""
    platform = platform_of(wheel)
    with tempfile.TemporaryDirectory() as folder:
        source = staged(Path(folder), wheel, platform)
        version = re.search(r'^version = "(.*)"', (source / "blender_manifest.toml").read_text(), re.M)[1]
        made = out / f"motion_sketch-{version}-{platform}.zip"
        run("build", "--source-dir", source, "--output-filepath", made)
        run("validate", made)
    return made


def main():
    parser = argparse.ArgumentParser(description="Makes one zip per wheel.")
    parser.add_argument("wheels", nargs="+", type=Path, metavar="WHEEL")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    for wheel in arguments.wheels:
        print(build(wheel, arguments.out))


if __name__ == "__main__":
    main()
