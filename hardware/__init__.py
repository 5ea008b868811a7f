"""The real robot: a Pioneer P3-DX over ARCOS, a Hokuyo URG-04LX over SCIP, and both devices emulated.

Bytes, millimetres, degrees and ticks end in ``arcos`` and ``scip``, which open nothing; ``serial_port`` opens ports;
``p3dx`` and ``urg04lx`` are the devices, ``robot`` joins them. ``emulator`` plays the other end of the wire.
"""
