"""One byte in a hundred is damaged: nothing wrong is believed, and what was not hit comes through."""

from collections.abc import Callable

import pytest

from tests.noisy_line import Score, hear_commands, hear_scans, hear_sips


@pytest.mark.parametrize("burst", [1, 64])
@pytest.mark.parametrize("hear", [hear_sips, hear_commands])
def test_packets(hear: Callable[[int, int], Score], burst: int) -> None:
    score = hear(1000, burst)
    assert score.wrong == 0
    assert score.right >= 0.95 * score.good


@pytest.mark.parametrize("burst", [1, 64])
def test_scans(burst: int) -> None:
    score = hear_scans(150, burst)
    assert score.wrong == 0
    assert score.right >= 0.9 * score.good
