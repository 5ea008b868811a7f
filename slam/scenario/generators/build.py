"""From a scenario that names a generator to one that has what the generator makes."""

from __future__ import annotations

from typing import Any

from slam.scenario.schema import Scenario


def built(scenario: Scenario) -> Scenario:
    """The scenario with its generator's world and people beside those that it has itself.

    Way-points and a start pose of its own stay. The generator is gone from the result, which is therefore complete by
    itself: written out, it stays the same even where a later version generates something else.
    """
    if scenario.generate is None:
        return scenario
    site, robot, route = scenario.generate.site(), scenario.robot, scenario.route
    changed: dict[str, Any] = {
        "generate": None, "world": scenario.world.joined(site.world), "people": scenario.people + site.people,
    }  # fmt: skip
    if "start" not in robot.model_fields_set:
        changed["robot"] = robot.model_copy(update={"start": site.start})
    if "waypoints" not in route.model_fields_set:
        changed["route"] = route.model_copy(update={"waypoints": site.waypoints})
    return scenario.model_copy(update=changed)
