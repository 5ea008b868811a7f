"""Settings of the whole test run."""

from hypothesis import settings

settings.register_profile("hopslam", deadline=None, derandomize=True)  # time belongs in benchmarks
settings.load_profile("hopslam")
