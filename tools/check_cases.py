#!/usr/bin/env python3
"""Inputs that went wrong once, and what is said of each now: a page by kind.

    cargo build --release
    tools/check_cases.py ../shared/cases > tools/results/cases.md

The folder has `tables` (what other programs write), `scenes` (a scene with poses) and `takes` (recordings with their
scenes); it is no part of the repository. Nothing in it is changed. Flights with one thing wrong and true scenes
that are made up are in `tests/judge/adequacy`.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

BUILDS = [Path(__file__).parent.parent / "target" / build / "enact" for build in ("release", "debug")]
ENACT = next((build for build in BUILDS if build.exists()), BUILDS[0])
MARKS = ["--mark", "0.973813:bounce", "--mark", "1.881604:landing"]
# Of a scene of a folder: the middle of the first contact of each file, and an end before the second.
HITS = {
    "poses_5": (0.3722, 0.88),
    "poses_20": (0.3799, 0.90),
    "poses_60": (0.4011, 0.93),
    "poses_150": (0.4528, 1.00),
}
LIMIT_S = 60


def said(*arguments):
    """Exit code and what is said, on one line each."""
    try:
        done = subprocess.run(
            [ENACT, *map(str, arguments)], capture_output=True, text=True, errors="replace", timeout=LIMIT_S
        )
    except subprocess.TimeoutExpired:
        return "none", [f"no end in {LIMIT_S} s"]
    return str(done.returncode), (done.stdout + done.stderr).splitlines()


def telling(lines, words):
    """The lines that begin with one of the words, without folders."""
    kept = [line.strip() for line in lines if line.strip().startswith(words)]
    return " / ".join(" ".join(Path(word).name if word.startswith(("/", "..")) else word for word in line.split()) for line in kept)[:400]


def row(*cells):
    print("| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |")


def heading(title, *columns):
    print(f"\n## {title}\n")
    row(*columns)
    row(*["---"] * len(columns))


def tables(folder, scratch):
    heading("Tables that other programs write", "case", "file", "import", "says", "replay", "says")
    for case in sorted(folder.iterdir()):
        scene = case / "scene.toml"
        for file in sorted(case.iterdir()):
            if file.name in ("README.md", "scene.toml", "scene_tf.toml"):
                continue
            out = scratch / "o.mcap"
            out.unlink(missing_ok=True)
            if file.suffix == ".mcap":
                code, words, source = "", "", file
            else:
                with_scene = ["--scene", scene, *MARKS] if scene.exists() else []
                code, lines = said("import", file, *with_scene, "-o", out)
                words, source = telling(lines, ("against", "error", "note")), out
            again, lines = "", []
            if source.exists() and scene.exists():
                own = case / "scene_tf.toml"
                used = own if own.exists() and "chain" in file.name else scene
                again, lines = said("replay", source, "--scene", used, "-o", scratch / "e.mcap")
            first = next((line.split(".mcap: ", 1)[-1] for line in lines if ".mcap: " in line), "")
            residual = telling(lines, ("residual  ",))
            row(case.name, file.name, code, words, again, f"{first[:160]} {residual}".strip())


def replays(title, files, scratch):
    heading(title, "case", "exit code", "says", "suspects, mistakes, doubts")
    for name, arguments in files:
        code, lines = said("replay", *arguments, "-o", scratch / "e.mcap", "--deadline", "30s")
        first = next((line.split(".mcap: ", 1)[-1] for line in lines if ".mcap: " in line), telling(lines, ("error",)))
        more = telling(lines, ("suspect", "or:", "likely", "doubt", "note: the goal"))
        row(name, code, first[:200], more)


def scenes(folder, scratch):
    for case in sorted(folder.iterdir()):
        for scene in sorted(case.glob("*.toml")):
            for poses in sorted(case.glob("*.csv")):
                if poses.stem == "truth":
                    continue
                out = scratch / f"{case.name}_{scene.stem}_{poses.stem}.mcap"
                marks = []
                if case.name == "13-soft-impact":
                    hit_s, end_s = HITS[poses.stem]
                    marks = ["--mark", "0:go", "--mark", f"{hit_s}:hit", "--mark", f"{end_s}:end"]
                code, _ = said("import", poses, "--scene", scene, *marks, "-o", out)
                if out.exists():
                    yield f"{case.name}, {scene.stem}, {poses.stem}", [out, "--scene", scene]


def main():
    folder = Path(sys.argv[1])
    print("# Inputs that went wrong once\n")
    root = Path(__file__).parent
    revision = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=root, capture_output=True, text=True)
    print(f"What is said of each by `tools/check_cases.py` at revision {revision.stdout.strip()}; the files are no part of the")
    print("repository. A row is what a user sees: exit code 0 is a motion against which nothing speaks, 3 one against which something")
    print("does, 1 no motion.")
    with tempfile.TemporaryDirectory() as scratch:
        scratch = Path(scratch)
        tables(folder / "tables", scratch)
        replays("Scenes that people asked for", scenes(folder / "scenes", scratch), scratch)
        takes = sorted((folder / "takes").glob("*.mcap"))
        replays("Right scenes with known truth", ((take.stem, [take]) for take in takes), scratch)


main()
