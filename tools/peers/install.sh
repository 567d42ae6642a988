#!/usr/bin/env bash
# Installs the peers: a virtual environment with pinned solvers from PyPI, and their formulas
# compiled. Needs Python 3.11 or later with venv, gcc, and the net.
set -euo pipefail
cd "$(dirname "$0")"

python3 -m venv .venv
.venv/bin/pip install --quiet --disable-pip-version-check \
    casadi==3.8.2 drake==1.51.1 mujoco==4.0.0 numpy==2.4.6 pin==4.1.0 scipy==1.17.1
.venv/bin/python compiled.py
