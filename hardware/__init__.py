"""The real robot: a Pioneer P3-DX over ARCOS, a lidar over SCIP or LDROBOT's protocol, and these devices emulated.

Bytes, millimetres, degrees and ticks occur only in ``arcos``, ``scip`` and ``ldrobot``, which open no ports;
``serial_port`` opens ports, and ``wire`` records their traffic; ``p3dx`` and a lidar of ``lidars.models`` are the
devices, and ``robot`` joins them. ``emulator`` plays the other end of the wire.

A byte of the robot passes serial_port, arcos_line (arcos.packet), p3dx (arcos.sip), base_odometry, odometry_history,
robot; one of the lidar passes serial_port, scip_line (scip.frames), urg04lx (scip.partial_scans, scip.time_stamp),
robot.
"""


class DecodeError(ValueError):
    """Bytes that break the rules of their format; the reader of the line drops them and continues."""
