"""The settings of the method: immutable, checked, in SI units and radians.

The defaults of the paper's parts are those of its section 5.1.
"""

from slam.config.lines import ChiSquareConfig, HoppingConfig, LineConfig
from slam.config.localization import LocalizationConfig
from slam.config.mapping import MapConfig, PointMapConfig, SurfelMapConfig
from slam.config.matching import ForceFieldConfig, LeastSquaresConfig, MatchConfig, MotionConfig, SearchConfig
from slam.config.section import OwnMethod, Section
from slam.config.slam_config import SlamConfig

__all__ = [
    "ChiSquareConfig",
    "ForceFieldConfig",
    "HoppingConfig",
    "LeastSquaresConfig",
    "LineConfig",
    "LocalizationConfig",
    "MapConfig",
    "MatchConfig",
    "MotionConfig",
    "OwnMethod",
    "PointMapConfig",
    "SearchConfig",
    "Section",
    "SlamConfig",
    "SurfelMapConfig",
]
