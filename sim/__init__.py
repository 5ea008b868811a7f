"""The simulated robot: a PyBullet world, a Pioneer P3-DX and a URG-04LX. Importing this registers the gym ids.

It costs no PyBullet: the engine is loaded when an environment is made.
"""

import gymnasium

from sim.ids import GENERAL_ID, SCENARIO_IDS

gymnasium.register(id=GENERAL_ID, entry_point="slam.run.env.p3dx_env:P3DXEnv")
for _id, _scenario in SCENARIO_IDS.items():
    gymnasium.register(id=_id, entry_point="slam.run.env.p3dx_env:P3DXEnv", kwargs={"scenario": _scenario})
