"""The page about the environment: what it shows runs, and what it lists is all there is."""

import re
from pathlib import Path

import pytest

from sim.ids import GENERAL_ID, SCENARIO_IDS

PAGE = Path(__file__).parents[1] / "docs/env.md"
BLOCKS = [
    block for block in re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL) if "# not run" not in block
]


@pytest.mark.parametrize("block", BLOCKS, ids=["start", "views", "vector"])
def test_what_the_page_shows_runs(block: str) -> None:
    exec(compile(block, str(PAGE), "exec"), {"__name__": "__main__"})


def test_the_page_lists_every_id() -> None:
    assert set(re.findall(r"^\| `(hopslam/\S+)`", PAGE.read_text(), re.MULTILINE)) == {GENERAL_ID, *SCENARIO_IDS}
