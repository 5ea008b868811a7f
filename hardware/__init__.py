"""The real robot: a Pioneer P3-DX over ARCOS, a Hokuyo URG-04LX over SCIP, and both devices emulated.

Bytes, millimetres, degrees and ticks end in ``arcos`` and ``scip``, which open nothing; ``serial_port`` opens ports;
``p3dx`` and ``urg04lx`` are the devices, ``robot`` joins them. ``emulator`` plays the other end of the wire.
"""

from slam.old_names import find_old_names

find_old_names()


class DecodeError(ValueError):
    """Bytes that break the rules of their format; whoever reads the line drops them and goes on."""
