"""The notebooks run from the first cell to the last on smaller inputs, and their results have pictures."""

import ast
import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any, Final

import matplotlib.pyplot as plt
import pytest

FOLDER: Final = Path(__file__).parents[1] / "docs/examples"
NOTEBOOKS: Final = sorted(FOLDER.glob("*.ipynb"))
LESS: Final = {
    "first_map": {"SECONDS": 2},
    "own_ranges": {"SCANS": 60},
    "own_extractor": {"SECONDS": 2},
    "paper_method": {"SECONDS": 4},
    "train_policy": {"EPISODE": 1, "GENERATIONS": 1, "POPULATION": 2},
}
"""Values that make the notebooks short, by the names of their variables."""


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """The module that the cells run in, in an empty folder; what they define can be imported, as from a notebook."""
    plt.switch_backend("agg")
    monkeypatch.chdir(tmp_path)
    made = ModuleType("the_notebook")
    monkeypatch.setitem(sys.modules, made.__name__, made)
    yield made
    plt.close("all")


@pytest.mark.usefixtures("no_pictures")
@pytest.mark.parametrize("path", NOTEBOOKS, ids=[path.stem for path in NOTEBOOKS])
def test_a_notebook_runs_from_its_first_cell(path: Path, module: ModuleType) -> None:
    left = dict(LESS[path.stem])
    for cell in code_cells(path):
        text = "".join(cell["source"])
        for name in [name for name in left if re.search(rf"^{name} = ", text, re.MULTILINE)]:
            text = re.sub(rf"^{name} = \d+$", f"{name} = {left.pop(name)}", text, flags=re.MULTILINE)
        shown = run_cell(text, f"{path.name}: {cell['id']}", vars(module))
        if hasattr(shown, "_repr_html_"):
            assert shown._repr_html_().startswith("<")
        if hasattr(shown, "_repr_png_"):
            assert shown._repr_png_().startswith(b"\x89PNG")
    assert not left


@pytest.mark.parametrize("path", NOTEBOOKS, ids=[path.stem for path in NOTEBOOKS])
def test_a_notebook_has_no_output_and_runs_alone(path: Path) -> None:
    document = json.loads(path.read_text())
    assert (document["nbformat"], document["nbformat_minor"]) == (4, 5)
    ids = [cell["id"] for cell in document["cells"]]
    assert len(set(ids)) == len(ids)
    assert all(re.fullmatch(r"[A-Za-z0-9_-]{1,64}", one) for one in ids)
    first, *others = code_cells(path)
    assert '"pip", "install"' in "".join(first["source"])
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in (first, *others))
    assert not any(re.search(r"^[%!]", "".join(cell["source"]), re.MULTILINE) for cell in (first, *others))


def code_cells(path: Path) -> list[dict[str, Any]]:
    return [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == "code"]


def run_cell(text: str, name: str, namespace: dict[str, Any]) -> Any:
    """Run a cell; the value of the expression that it ends with, which a notebook shows."""
    tree = ast.parse(text, name)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, name, "exec"), namespace)
    if not isinstance(last, ast.Expr):
        return None
    return eval(compile(ast.Expression(last.value), name, "eval"), namespace)
