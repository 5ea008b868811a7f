"""Control steps of one robot and of the people around it."""

from typing import Any

from sim.crowd import Crowd
from sim.firmware import control
from sim.gait import walk_all
from sim.plan.base import move
from sim.wall_plan import WallPlan
from slam.compiled import compiled_on_views
from slam.pose import FloatArray


@compiled_on_views
def advance(
    base: Any, model: Any, ramps: bool, obstacles: WallPlan, crowd: Crowd, world: int,
    walked: FloatArray, positions: FloatArray, legs: FloatArray, path: FloatArray, legs_path: FloatArray,
) -> None:  # fmt: skip
    """Run S - 1 control steps in this world, and write the poses of robot and legs before and after each.

    ``path`` (S, 3) gets x, y, theta of the base, ``legs_path`` (S, 2 P, 2) the legs. For P people, ``walked`` (P, 2)
    are the metres walked and the remaining rest, ``positions`` (P, 2) and ``legs`` (P, 2, 2) their positions. Without
    ``ramps`` the setpoint does not change.
    """
    seconds = model.substeps * model.substep
    standing = legs.reshape((2 * len(legs), 2))
    for k in range(len(path)):
        if k > 0:
            if ramps:
                control(base, model)
            move(base, model, obstacles, world, standing, crowd.leg_radii[world])
            walk(base, crowd, world, seconds, walked, positions, legs)
        path[k, 0], path[k, 1], path[k, 2] = base.x, base.y, base.theta
        for leg in range(len(standing)):
            legs_path[k, leg, 0], legs_path[k, leg, 1] = standing[leg, 0], standing[leg, 1]


@compiled_on_views
def walk(
    base: Any, crowd: Crowd, world: int, seconds: float, walked: FloatArray, positions: FloatArray, legs: FloatArray
) -> None:
    """Let the people of this world walk; they watch out for the robot."""
    if len(walked) == 0:
        return
    walk_all(
        crowd.nodes[world], crowd.distances[world], crowd.node_counts[world], crowd.habits[world], walked,
        (base.x, base.y), seconds, positions, legs,
    )  # fmt: skip
