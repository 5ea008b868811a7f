"""The real robot: a Pioneer P3-DX over ARCOS, a Hokuyo URG-04LX over SCIP, and both devices emulated.

Bytes, millimetres, degrees and ticks end in ``arcos`` and ``scip``, which open nothing; ``serial_port`` opens ports;
``p3dx`` and ``urg04lx`` are the devices, ``robot`` joins them. ``emulator`` plays the other end of the wire.

A byte of the robot passes serial_port, arcos_line (arcos.packet), p3dx (arcos.sip), base_odometry, odometry_history,
robot; one of the lidar passes serial_port, scip_line (scip.frames), urg04lx (scip.partial_scans, scip.time_stamp),
robot.
"""


class DecodeError(ValueError):
    """Bytes that break the rules of their format; whoever reads the line drops them and goes on."""
