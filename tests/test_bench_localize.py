"""The benchmark of localisation searches in the whole map of a run."""

import numpy as np

from slam.bench.localize_report import map_world
from slam.scenario.file import load_scenario


def test_the_map_has_the_walls_of_the_whole_route() -> None:
    world = map_world(load_scenario("office_loop", ["physics.engine=plan", "duration=50"]))
    path = np.hypot(*np.diff(world.truth[:, :2], axis=0).T).sum()
    assert path > 20.0  # metres: more than a submap
    near = [(np.hypot(*(world.map.points - place).T) < 2.0).sum() for place in world.truth[::50, :2]]
    assert min(near) > 5
    np.testing.assert_allclose(world.estimate[:, :2], world.truth[:, :2], atol=0.1)
