"""Examines serial ports: which device answers, its description, and reasons why it cannot be used."""

from hardware.doctor.finding import Finding
from hardware.doctor.ld_lidar import examine_ld_lidar
from hardware.doctor.robot import examine_robot
from hardware.doctor.scip_lidar import examine_scip_lidar
from hardware.serial_port import NoDevice, PortLost
from hardware.wire.session import WireSession
from slam.errors import RobotError


def examine(port: str, lidar_baud: int, wire: WireSession | None = None) -> Finding:
    """Find out which device answers at this port, and describe it.

    Nothing moves: the robot is opened, read and closed, its motors without power. A lidar's laser is off afterwards.
    Before it writes, the doctor listens for a device that sends without being asked.
    """
    tried = []
    for look in (examine_ld_lidar, examine_scip_lidar, examine_robot):
        try:
            return look(port, lidar_baud, wire)
        except NoDevice as silence:
            tried.append(str(silence).removeprefix(f"{port}: ").partition(";")[0])
        except PortLost as lost:
            return Finding(port, str(lost).removeprefix(f"{port}: "), answered=False)
        except RobotError as refusal:
            return Finding(port, "a device answers", faults=(str(refusal).removeprefix(f"{port}: "),))
    return Finding(port, f"{', '.join(tried)}; is the device switched on, and its cable right?", answered=False)
