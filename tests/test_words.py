"""Docstrings, and the notes below constants and fields, are phrases of their own and no parts of a sentence."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("hopslam", "slam", "sim", "hardware", "docs", "tests")
FRAGMENT = re.compile(r"(What|Where|Whether|Which|Who|Whose|How|Why|Of)\b|.*\b(what|where|whether|of|which|how)\.?$")


def notes(package: str) -> Iterator[tuple[str, str]]:
    """Place and first paragraph of each docstring and note in the files of a package."""
    for file in sorted((ROOT / package).rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            body = getattr(node, "body", [])
            for statement in body if isinstance(body, list) else []:  # a lambda's is an expression
                match statement:
                    case ast.Expr(ast.Constant(str() as text)):
                        yield (
                            f"{file.relative_to(ROOT)}:{statement.lineno}",
                            " ".join(text.partition("\n\n")[0].split()),
                        )


@pytest.mark.parametrize("package", PACKAGES)
def test_no_docstring_is_a_fragment(package: str) -> None:
    found = dict(notes(package))
    assert found
    assert [f"{place}: {line}" for place, line in found.items() if FRAGMENT.match(line)] == []
