"""Makes the configured mapper: a matcher with its map, with or without loop closing."""

from slam.config import ForceFieldConfig, LeastSquaresConfig, OwnMethod, PointMapConfig, SlamConfig, SurfelMapConfig
from slam.graph.submap_mapper import SubmapMapper
from slam.matching.mapper import Mapper
from slam.matching.own_mapper import OwnMapper
from slam.matching.paper_mapper import PaperMapper
from slam.matching.surfel_mapper import SurfelMapper
from slam.matching.surfel_mapper_state import SurfelMapperState
from slam.pose import Pose2D


def make_mapper(config: SlamConfig, T_base_laser: Pose2D, seed: int) -> Mapper:
    """Make the mapper of these settings; SlamConfig has checked that its parts fit together."""
    if isinstance(config.matching, OwnMethod):
        return OwnMapper(config.matching, T_base_laser, seed)
    if isinstance(config.matching, ForceFieldConfig) and isinstance(config.map, PointMapConfig):
        return PaperMapper(config.map, config.matching, T_base_laser, seed)
    assert isinstance(config.map, SurfelMapConfig)
    return surfel_mapper(config, T_base_laser, SurfelMapperState.empty(config.map))


def surfel_mapper(config: SlamConfig, T_base_laser: Pose2D, state: SurfelMapperState, submap: int = 0) -> SurfelMapper:
    """Make this project's own mapper from a state.

    With loop closing, it uses submaps, numbered from ``submap`` on.
    """
    assert isinstance(config.matching, LeastSquaresConfig)
    if config.loops == "never":
        return SurfelMapper(state, config.matching, T_base_laser, config.odometry)
    return SubmapMapper(state, config.matching, T_base_laser, config.odometry, submap)
