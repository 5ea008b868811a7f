"""The commands of an open, emulated P3-DX: the action of each, and the source for it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Protocol

from hardware.arcos.commands import BAUDS, Command, CommandId, decode_vel2
from hardware.arcos.config_packet import ArcosConfig
from hardware.arcos.model import P3DX_SH
from hardware.arcos.packet import encode_packet
from hardware.emulator.motor_controller import MotorController
from hardware.emulator.p3dx_reports import FULL_BATTERY, SONAR_ARRAYS, P3dxReports
from slam.odometry import Twist2D
from slam.pose import wrap_angle


class CommandedRobot(Protocol):
    """Parts of the robot that commands act on."""

    config: ArcosConfig
    motors: MotorController
    reports: P3dxReports
    baud: int

    def close(self) -> None:
        """End the connection."""
        ...


Action = Callable[[Command, CommandedRobot], None]


@dataclass(frozen=True, slots=True)
class CommandRow:
    """A command: its action, None if a robot without the accessory ignores it, and the source for it.

    A page number refers to the Pioneer 3 Operations Manual (Adept MobileRobots). Every command, known or not, restarts
    the watchdog.
    """

    action: Action | None
    evidence: str


def execute(command: Command, robot: CommandedRobot) -> bytes:
    """Carry out a command, and return the packet that answers it at once; unknown commands are ignored.

    DecodeError if the argument is missing.
    """
    if command.id == CommandId.CONFIG:
        return encode_packet(robot.config.encode())
    row = COMMANDS.get(command.id)
    if row is not None and row.action is not None:
        row.action(command, robot)
    return b""


def _set_wheel_speeds(command: Command, robot: CommandedRobot) -> None:
    twist = Twist2D.from_wheels(*decode_vel2(_number(command)), 2.0 * P3DX_SH.half_track)
    robot.motors.set_targets(twist.linear, twist.angular)


def _turn_to(command: Command, robot: CommandedRobot) -> None:
    robot.motors.turn_by(wrap_angle(command.quantity - robot.reports.pose.theta))


def _switch_sonar(command: Command, robot: CommandedRobot) -> None:
    """Switch all arrays by 0 or 1; otherwise bit 0 switches the array whose number is in bits 1 to 3."""
    array, on = divmod(_number(command) & 0xF, 2)
    robot.reports.enable_sonar(bool(on), array if 1 <= array <= SONAR_ARRAYS else None)


def _poll_sonar(command: Command, robot: CommandedRobot) -> None:
    if not command.argument:
        robot.reports.enable_sonar(False)


def _set_outputs(command: Command, robot: CommandedRobot) -> None:
    """Change the outputs that the high byte selects to the bits of the low byte."""
    mask, bits = divmod(_number(command) & 0xFFFF, 0x100)
    robot.reports.outputs = robot.reports.outputs & ~mask | bits & mask


def _set_baud(command: Command, robot: CommandedRobot) -> None:
    if isinstance(command.argument, int) and 0 <= command.argument < len(BAUDS):
        robot.baud = BAUDS[command.argument]


def _set_battery(command: Command, robot: CommandedRobot) -> None:
    robot.reports.battery = _number(command) / 10.0 or FULL_BATTERY


def _select_analog_port(command: Command, robot: CommandedRobot) -> None:
    robot.reports.analog_port = _number(command) & 0xFF


def _reset(_: Command, robot: CommandedRobot) -> None:
    robot.close()
    robot.reports.set_origin()


def _tty(port: int) -> Action:
    def send(command: Command, robot: CommandedRobot) -> None:
        if isinstance(command.argument, bytes):
            robot.reports.aux[port].send(command.argument)

    return send


def _get_aux(port: int) -> Action:
    return lambda command, robot: robot.reports.aux[port].request(_number(command))


def _number(command: Command) -> int:
    return command.argument if isinstance(command.argument, int) else 0


COMMANDS: Final[dict[int, CommandRow]] = {
    CommandId.PULSE: CommandRow(None, "p. 28: resets the watchdog without other effect"),
    CommandId.OPEN: CommandRow(None, "p. 28: no effect on a robot that is already open"),
    CommandId.CLOSE: CommandRow(lambda _, robot: robot.close(), "p. 28; bit rate of the FLASH afterwards: unverified"),
    CommandId.POLLING: CommandRow(_poll_sonar, "p. 34: an empty string is SONAR 0; the order is ignored"),
    CommandId.ENABLE: CommandRow(lambda c, robot: robot.motors.enable(c.argument != 0), "p. 28"),
    CommandId.SETA: CommandRow(lambda c, robot: robot.motors.linear.set_slope(c.quantity), "p. 28"),
    CommandId.SETV: CommandRow(lambda c, robot: robot.motors.linear.set_limit(c.quantity), "p. 28"),
    CommandId.SETO: CommandRow(lambda _, robot: robot.reports.set_origin(), "p. 28; Player's is cut short"),
    CommandId.MOVE: CommandRow(lambda c, robot: robot.motors.move_by(c.quantity), "p. 28"),
    CommandId.ROTATE: CommandRow(
        lambda c, robot: robot.motors.set_targets(angular=c.quantity), "Pioneer LX User's Guide p. 118: as RVEL"
    ),
    CommandId.SETRV: CommandRow(lambda c, robot: robot.motors.angular.set_limit(c.quantity), "p. 28"),
    CommandId.VEL: CommandRow(lambda c, robot: robot.motors.set_targets(linear=c.quantity), "p. 28"),
    CommandId.HEAD: CommandRow(_turn_to, "p. 28"),
    CommandId.DHEAD: CommandRow(lambda c, robot: robot.motors.turn_by(c.quantity), "p. 28"),
    CommandId.SAY: CommandRow(None, "p. 38: beeps, which nobody hears here"),
    CommandId.JOYREQUEST: CommandRow(None, "p. 42: JOYSTICKpac, if a joystick is enabled"),
    CommandId.CONFIG: CommandRow(None, "p. 35: answered at once with CONFIGpac"),
    CommandId.ENCODER: CommandRow(
        lambda c, robot: robot.reports.encoders.ask(_number(c)), "p. 38: one (1), a stream (2 and more), none (0)"
    ),
    CommandId.RVEL: CommandRow(lambda c, robot: robot.motors.set_targets(angular=c.quantity), "p. 28"),
    CommandId.DCHEAD: CommandRow(None, "AriaCoda, ArCommands.h: of Colbert, obsolete"),
    CommandId.SETRA: CommandRow(lambda c, robot: robot.motors.angular.set_slope(c.quantity), "p. 28"),
    CommandId.SONAR: CommandRow(_switch_sonar, "p. 28; flags p. 35, Table 8; each report has all transducers here"),
    CommandId.STOP: CommandRow(lambda _, robot: robot.motors.set_targets(0.0, 0.0), "p. 28"),
    CommandId.DIGOUT: CommandRow(_set_outputs, "p. 29: bits 8 to 15 select, bits 0 to 7 set or reset"),
    CommandId.VEL2: CommandRow(_set_wheel_speeds, "p. 29: bits 0 to 7 right, 8 to 15 left, steps of 20 mm/s"),
    CommandId.GRIPPER: CommandRow(None, "p. 29: no gripper"),
    CommandId.ADSEL: CommandRow(_select_analog_port, "p. 29: the ANPORT of the SIP"),
    CommandId.GRIPPERVAL: CommandRow(None, "p. 29: no gripper"),
    CommandId.GRIPREQUEST: CommandRow(None, "p. 29: no gripper"),
    CommandId.GYROCALCW: CommandRow(None, "p. 29: no gyro"),
    CommandId.GYROCALCCW: CommandRow(None, "p. 29: no gyro"),
    CommandId.IOREQUEST: CommandRow(
        lambda c, robot: robot.reports.io.ask(_number(c)), "p. 29, 41: one IOpac (1), a stream (2 and more), none (0)"
    ),
    CommandId.TTY2: CommandRow(_tty(0), "p. 29: to AUX1"),
    CommandId.GETAUX: CommandRow(_get_aux(0), "p. 29, 38: SERAUXpac once so many bytes came; 0 flushes"),
    CommandId.BUMPSTALL: CommandRow(None, "p. 29: stall by bumpers; here only blocked wheels stall"),
    CommandId.TCM2: CommandRow(None, "p. 29: no compass"),
    CommandId.JOYDRIVE: CommandRow(None, "p. 29: no joystick"),
    CommandId.SONARCYCLE: CommandRow(None, "p. 29, 34: each report has all transducers here"),
    CommandId.HOSTBAUD: CommandRow(_set_baud, "p. 29"),
    CommandId.AUX1BAUD: CommandRow(None, "p. 29: AUX ports carry bytes at once here"),
    CommandId.AUX2BAUD: CommandRow(None, "p. 29: the same"),
    CommandId.AUX3BAUD: CommandRow(None, "p. 29: the same"),
    CommandId.E_STOP: CommandRow(lambda _, robot: robot.motors.stop_hard(), "p. 29: as hard as the motors can"),
    CommandId.E_STALL: CommandRow(None, "p. 35: whether the STOP button stalls; here it always takes the power"),
    CommandId.E_STOP_OLD: CommandRow(lambda _, robot: robot.motors.stop_hard(), "AMRISim, EmulatePioneer.cc: as 55"),
    CommandId.GYROREQUEST: CommandRow(None, "ArCommands.h: no gyro"),
    CommandId.LCDWRITE: CommandRow(None, "p. 29: no display"),
    CommandId.TTY4: CommandRow(_tty(2), "p. 30: to AUX3"),
    CommandId.GETAUX3: CommandRow(_get_aux(2), "p. 30: SERAUX3pac"),
    CommandId.BATTERYINFO: CommandRow(None, "ArCommands.h: of other robots; not in the manual"),
    CommandId.TTY3: CommandRow(_tty(1), "p. 30: to AUX2"),
    CommandId.GETAUX2: CommandRow(_get_aux(1), "p. 30: SERAUX2pac"),
    CommandId.CHARGE: CommandRow(None, "p. 30: no docking station"),
    **{
        number: CommandRow(None, "p. 30: working values of the motor control; its ramps are exact here")
        for number in range(CommandId.ROTKP, CommandId.TRANSKI + 1)
    },
    CommandId.REVCOUNT: CommandRow(None, "p. 30: a working value"),
    CommandId.DRIFTFACTOR: CommandRow(None, "p. 30: a working value"),
    CommandId.SOUNDTOG: CommandRow(None, "p. 30: mutes the buzzer"),
    CommandId.TICKSMM: CommandRow(None, "p. 30: a working value"),
    CommandId.BATTEST: CommandRow(_set_battery, "p. 30: tenths of volts to report; 0 reverts"),
    CommandId.RESET: CommandRow(_reset, "p. 30: as power-on"),
    CommandId.MAINTENANCE: CommandRow(None, "p. 30: never asked for by clients; a real one falls silent"),
}
"""Every command of the manual and of AriaCoda."""
