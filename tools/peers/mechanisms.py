"""Accelerations of trees of rigid bodies, their derivatives, energies and flights, by Pinocchio and by MuJoCo.

    mechanisms.py FOLDER ANSWERS

reads every `*.json` of a folder in the order of names (README.md: a mechanism file) and answers with
raw numbers in the file's coordinates. What agrees is judged by who asks.
"""

import json
import sys
from pathlib import Path

import mujoco
import numpy as np
import pinocchio
import scipy

import with_mujoco
import with_pinocchio

PEERS = {
    "Pinocchio": with_pinocchio.Peer,
    "Pinocchio, articulated": with_pinocchio.Articulated,
    "MuJoCo": with_mujoco.Peer,
}


def answer(name, peer, given):
    by_coordinates, by_rates = peer.derivatives()
    flight_s = given["flight_s"]
    end = peer.flight(flight_s) if flight_s else None
    return {
        "peer": name,
        "accelerations": peer.accelerations().tolist(),
        "by_coordinates": by_coordinates.tolist(),
        "by_rates": by_rates.tolist(),
        "energy_j": float(peer.energy()),
        "end": end and {key: value.tolist() for key, value in end.items()},
    }


def main():
    folder, answers = map(Path, sys.argv[1:3])
    result = []
    for path in sorted(folder.glob("*.json")):
        given = json.loads(path.read_text())
        assert given["format"] == "enact mechanism 1", given["format"]
        result.append([answer(name, make(given), given) for name, make in PEERS.items()])
    versions = {
        "pinocchio": pinocchio.__version__,
        "mujoco": mujoco.__version__,
        "scipy": scipy.__version__,
        "numpy": np.__version__,
    }
    answers.write_text(json.dumps({"versions": versions, "answers": result}))


if __name__ == "__main__":
    main()
