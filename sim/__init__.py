"""The simulated robot: a PyBullet world, a Pioneer P3-DX and a URG-04LX. Importing this registers the gym ids.

It does not load PyBullet: that is loaded when an environment is made.
"""

from slam.env.ids import register_ids

register_ids()
