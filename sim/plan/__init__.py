"""The robot as a kinematic model in the plane, compiled: no forces, and so fast that thousands share a core."""
