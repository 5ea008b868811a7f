"""``hopslam calibrate``: what the wheels really are, found by driving.

``square`` drives UMBmark's squares, ``wheel_fit`` fits the wheels to them, ``report`` says and draws what came out, and
``file`` writes it where a scenario finds it.
"""
