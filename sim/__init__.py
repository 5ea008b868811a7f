"""The simulated robot: a PyBullet world, a Pioneer P3-DX and a URG-04LX. Importing this registers the gym ids."""
