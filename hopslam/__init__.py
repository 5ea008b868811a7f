"""Line-based SLAM with a 2-D lidar, in a few lines: ranges and angles in, pose and walls out.

    import hopslam

    slam = hopslam.Slam()
    for ranges in scans:
        estimate = slam.update(ranges, angles)
    print(slam.pose, slam.walls)

Metres, radians and seconds; x points forward, y to the left, angles run counter-clockwise. docs/api.md is the manual.
What ``__all__`` names is stable; the packages ``slam``, ``sim`` and ``hardware``, which it is made of, are not.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from hopslam.line_map import Map, load_map
    from hopslam.localizer import Localizer
    from hopslam.scan import Scan
    from hopslam.segments import Segments
    from hopslam.slam import Estimate, Slam
    from slam.config import OwnMethod, SlamConfig
    from slam.errors import HopslamError, InputError
    from slam.pose import Pose2D
    from slam.run.launch import localize, replay, run
    from slam.run.run import Run
    from slam.run.scoring.evaluate import Evaluation, evaluate
    from slam.sweep.launch import Sweep, sweep

__all__ = [
    "Estimate",
    "Evaluation",
    "HopslamError",
    "InputError",
    "Localizer",
    "Map",
    "OwnMethod",
    "Pose2D",
    "Run",
    "Scan",
    "Segments",
    "Slam",
    "SlamConfig",
    "Sweep",
    "evaluate",
    "load_map",
    "localize",
    "replay",
    "run",
    "sweep",
]

_MODULES: Final = {
    "hopslam.line_map": ("Map", "load_map"),
    "hopslam.localizer": ("Localizer",),
    "hopslam.scan": ("Scan",),
    "hopslam.segments": ("Segments",),
    "hopslam.slam": ("Estimate", "Slam"),
    "slam.config": ("OwnMethod", "SlamConfig"),
    "slam.errors": ("HopslamError", "InputError"),
    "slam.pose": ("Pose2D",),
    "slam.run.launch": ("localize", "replay", "run"),
    "slam.run.run": ("Run",),
    "slam.run.scoring.evaluate": ("Evaluation", "evaluate"),
    "slam.sweep.launch": ("Sweep", "sweep"),
}
"""Public names by the module that defines them; a module is imported when one of its names is first used."""
_PLACES: Final = {name: module for module, names in _MODULES.items() for name in names}


if not TYPE_CHECKING:  # a type checker should know the names above and no others

    def __getattr__(name: str) -> Any:
        if name not in _PLACES:
            raise AttributeError(f"module 'hopslam' has no {name!r}; it has {', '.join(__all__)}")
        value = globals()[name] = getattr(import_module(_PLACES[name]), name)
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
