"""Docstrings, the guide and the example run as they are printed."""

import doctest
import inspect
import json
import re
import sys

import pytest
from conftest import ROOT

import enact_motion

FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
MODULES = [name for name in sys.modules if name.split(".")[0] == "enact_motion" and not name.endswith("_core")]


@pytest.mark.parametrize("name", MODULES)
def test_docstrings_run(name, monkeypatch):
    monkeypatch.chdir(ROOT)
    failed, _ = doctest.testmod(sys.modules[name], optionflags=FLAGS)
    assert failed == 0


def test_everything_public_has_a_docstring_and_some_run():
    assert sum(len(of.examples) for of in doctest.DocTestFinder().find(enact_motion)) > 15
    for name in enact_motion.__all__:
        of = getattr(enact_motion, name)
        assert inspect.getdoc(of), name
        members = vars(of).items() if inspect.isclass(of) else []
        fields = getattr(of, "_fields", ())
        for key, member in members:
            if not key.startswith("_") and key not in fields:
                assert inspect.getdoc(member), f"{name}.{key}"


def test_the_guide_runs(monkeypatch, tmp_path):
    text = (ROOT / "docs/python.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(blocks) > 4
    monkeypatch.chdir(ROOT)
    source = "\n".join(blocks).replace('"out.mcap"', repr(str(tmp_path / "out.mcap")))
    exec(compile(source, "docs/python.md", "exec"), {"__name__": "guide"})


def test_the_example_runs(monkeypatch, tmp_path):
    notebook = json.loads((ROOT / "tools/python/examples/toss.ipynb").read_text())
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert len(cells) > 4
    assert all(not cell.get("outputs") for cell in notebook["cells"]), "outputs are not kept"
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    names = {"__name__": "__main__"}
    for cell in cells:
        exec(compile(cell, "toss.ipynb", "exec"), names)
    estimate, made = names["estimate"], names["RESTITUTION"]
    assert estimate.verdict == "physical" and estimate.fit == "yes"
    found = estimate.parameters["ball.restitution"]
    assert abs(found.value - made) < 4 * found.sd < 0.02
    assert "<svg" in (tmp_path / "toss.svg").read_text()
    assert enact_motion.read(tmp_path / "toss.estimate.mcap").scene == names["scene"]
