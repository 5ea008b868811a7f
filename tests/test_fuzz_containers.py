"""For damaged files of each kind readers raise only the errors of slam.errors.

HOPSLAM_FUZZ=100000 sets the total number of inputs; ``python -m tests.fuzz_containers`` reports each reader.
"""

import os
import random
from pathlib import Path

import pytest

from tests.fuzz_containers import damaged, feed_all
from tests.fuzz_seeds import READERS

INPUTS = int(os.environ.get("HOPSLAM_FUZZ", "2000"))
SEED = int(os.environ.get("HOPSLAM_FUZZ_SEED", "1"))


@pytest.mark.parametrize("name", READERS)
def test_damaged_files_are_read_or_refused(name: str, tmp_path: Path) -> None:
    reader = READERS[name]
    seeds = reader.make(tmp_path / "seeds")
    for file in reader.files(seeds):  # intact files are read
        reader.read(reader.copy(seeds, tmp_path / file.replace("/", "-")), file)
    share = max(INPUTS * reader.weight // sum(other.weight for other in READERS.values()), 1)
    found = feed_all(name, reader, seeds, share, SEED, most_cuts=share)
    assert found.inputs > share
    assert not found.unexpected, f"seed {SEED}: {found.unexpected[0]}"


def test_an_input_is_reproduced_from_its_number() -> None:
    assert damaged(b"whole" * 9, random.Random("a 1 2")) == damaged(b"whole" * 9, random.Random("a 1 2"))
