"""The emulated devices in simulated time: bytes in, bytes out, without waiting."""

from dataclasses import replace
from random import Random

import numpy as np
import pytest

from hardware.arcos.commands import Command, CommandId, encode_vel2
from hardware.arcos.config_packet import CONFIG_PACKET, ArcosConfig
from hardware.arcos.encoder_packet import WheelTravel
from hardware.arcos.model import P3DX_SH, Identity
from hardware.arcos.packet import PacketDecoder, encode_packet
from hardware.arcos.sip import Sip
from hardware.emulator.p3dx import FACTORY_CONFIG, EmulatedP3dx
from hardware.emulator.serial_line import ConnectedDevice, Device, LineNoise, SerialLine
from hardware.emulator.urg04lx import TABLE1_PARAMETERS, EmulatedUrg04lx
from hardware.scip.frames import FrameDecoder
from hardware.scip.reply import Reply, decode_old_reply, find_reply
from hardware.scip.scan_data import ScanData, decode_scan
from hardware.wire.session import WireSession
from sim.plant import SimPlant
from slam.odometry import Twist2D
from tests.rooms import room_plant


def plant() -> SimPlant:
    return room_plant((-2.0, 3.0), (-2.0, 2.0))


def run(device: Device, seconds: float) -> bytes:
    """Return the bytes that the device sends in the next ``seconds``, from the end of the last call on."""
    said, until = b"", device.due + seconds - 1e-9
    while device.due < until:
        said += device.step()
    return said


def say(robot: EmulatedP3dx, *commands: Command) -> list[bytes]:
    wire = b"".join(encode_packet(command.encode()) for command in commands)
    return PacketDecoder().feed(robot.receive(wire, robot.due))


def opened(config: ArcosConfig = FACTORY_CONFIG) -> EmulatedP3dx:
    robot = EmulatedP3dx(plant(), config=config)
    for number in (0, 1, 2):
        assert say(robot, Command(number))[0][0] == number
    assert say(robot, Command(CommandId.OPEN)) == []  # without an argument, as Player sends it
    return robot


def sips(robot: EmulatedP3dx, seconds: float) -> list[Sip]:
    packets = PacketDecoder().feed(run(robot, seconds))
    return [Sip.decode(packet, P3DX_SH) for packet in packets if packet[0] in (0x32, 0x33)]


def test_before_open_only_the_handshake_is_answered() -> None:
    robot = EmulatedP3dx(plant())
    assert run(robot, 1.0) == b""
    assert robot.receive(b"WMS2\r", robot.due) == b""
    assert say(robot, Command(0)) == [b"\x00"]
    assert say(robot, Command(1)) == [b"\x01"]
    (answer,) = say(robot, Command(2))
    assert Identity.decode(answer).subclass == "p3dx-sh"
    assert run(robot, 1.0) == b""


def test_a_robot_left_open_takes_sync_for_other_commands() -> None:
    robot = opened()
    assert len(sips(robot, 1.0)) == 10
    assert say(robot, Command(0)) == []
    assert robot.open
    say(robot, Command(2))
    assert not robot.open
    assert say(robot, Command(0)) == [b"\x00"]


def test_motors_obey_within_limits_and_ramps_once_enabled() -> None:
    robot = opened()
    say(robot, Command.of(CommandId.VEL, 0.3))
    assert not sips(robot, 0.5)[-1].moving
    say(robot, Command(CommandId.ENABLE, 1), Command.of(CommandId.VEL, 0.3), Command.of(CommandId.RVEL, 0.5))
    assert sips(robot, 0.5)[-1].left < 0.16
    (last,) = sips(robot, 1.0)[-1:]
    assert (last.left + last.right) / 2.0 == pytest.approx(0.3, abs=1e-3)
    assert (last.right - last.left) / 2.0 / P3DX_SH.half_track == pytest.approx(0.5, abs=0.02)
    assert last.motors_enabled
    say(robot, Command.of(CommandId.SETV, 0.1), Command.of(CommandId.VEL, 0.3))
    assert sips(robot, 1.5)[-1].left + sips(robot, 0.1)[-1].right == pytest.approx(0.2, abs=0.1)


@pytest.mark.parametrize("argument", [encode_vel2(-0.2, 0.2).argument, 0xF60A])
def test_both_encodings_of_wheel_speeds_are_understood(argument: int) -> None:
    robot = opened()
    say(robot, Command(CommandId.ENABLE, 1), Command(CommandId.VEL2, argument))
    (last,) = sips(robot, 1.5)[-1:]
    assert (last.left, last.right) == (pytest.approx(-0.2, abs=0.002), pytest.approx(0.2, abs=0.002))


def test_a_move_and_a_turn_end_at_their_targets() -> None:
    robot = opened()
    say(robot, Command(CommandId.ENABLE, 1), Command.of(CommandId.MOVE, 0.4), Command.of(CommandId.DHEAD, -0.5))
    for _ in range(4):
        assert len(sips(robot, 1.0)) == 10
        say(robot, Command(CommandId.PULSE))
    assert robot.motors.setpoint == Twist2D()
    (last,) = sips(robot, 0.1)[-1:]
    assert (last.left, last.right) == (0.0, 0.0)
    assert robot._plant.travel[0] + robot._plant.travel[1] == pytest.approx(0.8, abs=2e-3)
    assert last.theta == pytest.approx(-Command.of(CommandId.DHEAD, 0.5).quantity, abs=4e-3)
    say(robot, Command(CommandId.HEAD, 90), Command.of(CommandId.MOVE, 5.0))
    run(robot, 1.0)
    say(robot, Command.of(CommandId.VEL, 0.0))
    assert sips(robot, 1.5)[-1].theta == pytest.approx(np.pi / 2, abs=4e-3)
    assert not robot.motors.moving


def test_sonar_and_outputs_are_switched() -> None:
    robot = opened()
    say(robot, Command(CommandId.DIGOUT, 0x0F05), Command(CommandId.SONAR, 0))
    assert sips(robot, 0.1)[-1].digital_out == 0x05
    say(robot, Command(CommandId.DIGOUT, 0x0102))
    assert sips(robot, 0.1)[-1].digital_out == 0x04
    for ignored in (CommandId.SAY, CommandId.IOREQUEST, CommandId.BUMPSTALL, CommandId.BATTERYINFO, 58, 82, 250):
        assert say(robot, Command(ignored, 1)) == []


def test_the_watchdog_stops_a_robot_without_commands() -> None:
    robot = opened()
    say(robot, Command(CommandId.ENABLE, 1), Command.of(CommandId.VEL, 0.3))
    assert sips(robot, 1.9)[-1].moving
    say(robot, Command(CommandId.PULSE))
    assert sips(robot, 1.9)[-1].moving
    assert not sips(robot, 1.0)[-1].moving


def test_an_emergency_stop_stops_the_robot_at_once() -> None:
    robot = opened()
    say(robot, Command(CommandId.ENABLE, 1), Command.of(CommandId.VEL, 1.0))
    run(robot, 4.0)
    say(robot, Command.of(CommandId.VEL, 1.0))
    run(robot, 2.0)
    robot.motors.press_e_stop(True)
    (last,) = sips(robot, 0.3)[-1:]
    assert (last.moving, last.e_stop, last.motors_enabled) == (False, True, False)
    say(robot, Command(CommandId.ENABLE, 1))
    assert not sips(robot, 0.2)[-1].motors_enabled
    robot.motors.press_e_stop(False)
    say(robot, Command(CommandId.ENABLE, 1))
    assert sips(robot, 0.2)[-1].motors_enabled


def test_settings_encoders_origin_and_bit_rate_are_emulated() -> None:
    robot = opened(replace(FACTORY_CONFIG, watchdog=1.5))
    (answer,) = say(robot, Command(CommandId.CONFIG, 1))
    assert answer[0] == CONFIG_PACKET
    assert ArcosConfig.decode(answer).watchdog == 1.5
    commands = Command(CommandId.ENCODER, 2), Command(CommandId.ENABLE, 1), Command.of(CommandId.VEL, 0.3)
    say(robot, *commands)
    packets = PacketDecoder().feed(run(robot, 1.0))
    travel = [WheelTravel.decode(p, FACTORY_CONFIG.ticks_per_metre) for p in packets if p[0] == 0x90]
    assert len(travel) == 10
    assert travel[-1].left == pytest.approx(0.15, abs=0.01)
    assert sips(robot, 0.1)[-1].x > 0.1
    say(robot, Command(CommandId.SETO), Command(CommandId.STOP))
    assert sips(robot, 0.1)[-1].x < 0.05
    say(robot, Command(CommandId.HOSTBAUD, 2))
    assert robot.baud == 38400
    say(robot, Command(CommandId.CLOSE, 1))
    assert robot.baud == 9600


def answers(lidar: EmulatedUrg04lx, command: str, seconds: float = 0.1) -> list[Reply]:
    said = lidar.receive(command.encode() + b"\n", lidar.due) + run(lidar, seconds)
    return [reply for lines in FrameDecoder().feed(said) if (reply := find_reply(lines))]


def awake() -> EmulatedUrg04lx:
    lidar = EmulatedUrg04lx(plant())
    assert answers(lidar, "SCIP2.0") == [Reply("SCIP2.0", "0")]
    return lidar


def test_the_lidar_starts_in_scip_1_1_with_its_laser_off() -> None:
    lidar = EmulatedUrg04lx(plant())
    assert lidar.receive(b"QT\n", 0.0) == b""
    (lines,) = FrameDecoder().feed(run(lidar, 0.1))
    assert decode_old_reply(lines).status == "E"
    lidar.receive(b"V\n", 0.0)
    (lines,) = FrameDecoder().feed(run(lidar, 0.1))
    assert decode_old_reply(lines).status == "0"
    lidar.receive(b"G04472501\n", 0.0)
    (lines,) = FrameDecoder().feed(run(lidar, 0.4))
    assert len(decode_scan(decode_old_reply(lines)).ranges) == 682
    assert awake().laser is False


def statuses(lidar: EmulatedUrg04lx, *commands: str) -> list[str]:
    return [answers(lidar, command)[0].status for command in commands]


def test_status_commands_report_the_state() -> None:
    lidar = awake()
    assert statuses(lidar, "GD0044072501", "BM", "BM", "XX", "SCIP2.0") == ["10", "00", "02", "0E", "0E"]
    assert statuses(lidar, "MD0044080001000", "MD0100004401000", "MDxx") == ["04", "05", "0C"]
    wrong = "MDxx44072501000", "GD00440x2501", "MS004407250x000", "MD004407250100x", "MD00440725010x0"
    assert statuses(lidar, *wrong) == ["01", "02", "03", "07", "07"]
    assert statuses(lidar, "SS115200", "SS115200", "SS000001", "SSx15200") == ["00", "03", "02", "01"]
    assert statuses(lidar, "SS038400") == ["04"]  # p. 4: not with a URG-04LX
    assert lidar.baud == 115200
    assert statuses(lidar, "CR00", "CR05", "CR50", "CRxx", "CR99") == ["03", "04", "02", "01", "00"]
    assert statuses(lidar, "HS0", "HS1", "HS2") == ["03", "03", "01"]  # p. 18: from firmware 3.2.00 on
    assert statuses(lidar, "GE0044072501", "ME0044072501000", "RB", "DB10", "QTx", "SS1152") == ["0E"] * 5 + ["0C"]
    assert statuses(lidar, f"VV;{'x' * 16}", f"VV;{'x' * 17}", "VV;a-b", "VV;") == ["00", "0G", "0H", "00"]
    assert statuses(lidar, "TM5", "TMx") == ["01", "01"]
    assert statuses(lidar, "TM1", "TM0", "QT", "TM1", "TM2", "TM2") == ["04", "00", "0E", "00", "00", "03"]
    assert statuses(lidar, "RS", "VV", "PP", "II") == ["00"] * 4
    assert lidar.baud == 19200


def test_a_reboot_resets_the_lidar_and_takes_time() -> None:
    lidar = awake()
    answers(lidar, "TM0")
    lidar.reboot(lidar.due)
    assert lidar.receive(b"QT\n", lidar.due) + run(lidar, 0.5) == b""
    run(lidar, 0.6)
    lidar.receive(b"QT\n", lidar.due)
    (lines,) = FrameDecoder().feed(run(lidar, 0.1))
    assert decode_old_reply(lines).status == "E"  # SCIP 1.1 again
    assert not lidar.laser


def test_the_lidar_of_table_1_has_its_own_beams() -> None:
    lidar = EmulatedUrg04lx(plant(), parameters=TABLE1_PARAMETERS)
    answers(lidar, "SCIP2.0")
    (reply,) = answers(lidar, "PP")
    assert {b"ARES:192;", b"AMIN:0;", b"AMAX:127;", b"AFRT:64;", b"DMAX:4000;"} <= set(reply.lines)
    assert statuses(lidar, "MD0000020001000") == ["04"]
    (scan, *_) = scans(lidar, "MD0000012701000", 0.5)
    bearings = (np.arange(128) - 64) * 2 * np.pi / 192
    assert scan.ranges == pytest.approx(np.round(plant().ranges(bearings), 3), abs=6e-4)


def test_a_reply_is_never_cut_when_its_reader_stalls() -> None:
    class Narrow:
        """A port with room for a few bytes at a time."""

        address, room, got = "narrow", 0, b""

        def filenos(self) -> list[int]:
            return [0]

        def write(self, data: bytes) -> int:
            taken = data[: self.room]
            self.got += taken
            self.room -= len(taken)
            return len(taken)

    port = Narrow()
    lidar = awake()
    answers(lidar, "MD0044072501000")
    device = ConnectedDevice(lidar, port, False, 0, LineNoise(), WireSession())
    for k in range(600):
        device.step()
        port.room = 0 if k < 300 else 777
        device.flush(lidar.due)
    for _ in range(100):
        port.room = 777
        device.flush(lidar.due)
    replies = [find_reply(lines) for lines in FrameDecoder().feed(port.got)]
    assert len(replies) > 20
    assert all(reply is not None and len(decode_scan(reply).ranges) == 682 for reply in replies)


def scans(lidar: EmulatedUrg04lx, command: str, seconds: float) -> list[ScanData]:
    return [decode_scan(reply) for reply in answers(lidar, command, seconds) if reply.lines]


def test_commands_are_answered_one_by_one() -> None:
    lidar = awake()
    lidar.receive(b"VV\nPP\nII\n", 0.0)
    assert [len(FrameDecoder().feed(run(lidar, 0.1))) for _ in range(4)] == [1, 1, 1, 0]
    lidar.receive(b"QT\nQT\n", 0.0)
    (once, twice) = (find_reply(lines) for lines in FrameDecoder().feed(run(lidar, 0.2)))
    assert (once, twice) == (Reply("QT", "00"), Reply("QT", "0B"))


def test_scans_stream_until_told_to_quit() -> None:
    lidar = awake()
    found = scans(lidar, "MD0044072501000", 1.05)
    assert len(found) >= 8
    assert np.diff([scan.time for scan in found]) == pytest.approx(0.1, abs=0.0011)
    bearings = (np.arange(44, 726) - 384) * 2 * np.pi / 1024
    assert found[0].ranges == pytest.approx(np.round(plant().ranges(bearings), 3), abs=6e-4)
    assert answers(lidar, "QT", 0.3)[-1] == Reply("QT", "00")
    assert not lidar.laser
    assert run(lidar, 0.5) == b""


def test_a_counted_number_of_scans_and_an_interval() -> None:
    lidar = awake()
    assert [scan.request.scans for scan in scans(lidar, "MS0044072501003", 1.0)] == [2, 1, 0]
    assert not lidar.laser
    assert len(scans(lidar, "MD0044072501100", 1.05)) in (4, 5)


def test_clusters_give_the_smallest_range() -> None:
    lidar = awake()
    answers(lidar, "BM", 0.3)
    single, triple = scans(lidar, "GD0044072501", 0.1)[0], scans(lidar, "GD0044072503", 0.1)[0]
    assert len(triple.ranges) == 228  # 682 steps: the last cluster has one step
    assert triple.ranges[:227] == pytest.approx(single.ranges[:681].reshape(-1, 3).min(axis=1))
    assert triple.ranges[227] == single.ranges[681]


def test_beams_see_the_world_at_the_time_they_fire() -> None:
    moving = room_plant((-1.0, 1.5), (-4.0, 4.0))
    lidar = EmulatedUrg04lx(moving)
    answers(lidar, "SCIP2.0")
    said = lidar.receive(b"MD0044072501000\n", 0.0)
    for _ in range(60):
        before = lidar.due
        said += lidar.step()
        moving.advance(lidar.due - before, Twist2D(0.5, 0.0))
    last = [decode_scan(r) for lines in FrameDecoder().feed(said) if (r := find_reply(lines)) and r.lines][-1]
    bearings = (np.array([46, 723]) - 384) * 2 * np.pi / 1024
    left_behind = last.ranges[[2, 679]] * np.cos(bearings)  # the wall behind, at the first and the last beam
    assert left_behind[0] - left_behind[1] == pytest.approx(0.5 * (723 - 46) * 0.1 / 1024, abs=1.1e-3)


def test_a_line_delivers_bytes_at_its_bit_rate() -> None:
    line = SerialLine()
    line.send(bytes(96), 0.0, 9600)
    arrived = [b"".join(chunk for chunk, _ in line.take_arrived(now)) for now in (0.05, 0.1001)]
    assert [len(data) for data in arrived] == [48, 48]
    line.send(bytes(96), 1.0, None)
    assert list(line.take_arrived(1.0)) == [(bytes(96), None)]
    for _ in range(1000):
        line.send(bytes(1000), 2.0, 9600)
    assert sum(len(chunk) for chunk, _ in line.take_arrived(1e9)) <= 16_384


def test_noise_damages_the_given_share_of_bytes() -> None:
    clean = bytes(10_000)
    damaged = LineNoise(bit_errors=0.01).damage(clean, Random(1))
    assert 50 < sum(map(bool, damaged)) < 200
    assert 9800 < len(LineNoise(dropped=0.01).damage(clean, Random(1))) < 9950
    assert 10_050 < len(LineNoise(duplicated=0.01).damage(clean, Random(1))) < 10_200
    assert LineNoise().damage(clean, Random(1)) is clean


@pytest.mark.parametrize(
    "commands",
    [
        ["", "QT", "SCIP2.0", "QT", "PP", "SS115200", "MD0044072501000"],  # urg_library, which reads E as SCIP 1.1
        ["QT", "QT", "SS115200", "SCIP2.0", "SCIP2.0", "BM", "CR00", "HS0", "PP", "VV", "MD0044072501000"],  # MRPT
        ["RS", "SCIP2.0", "VV", "PP", "MD0044072503000"],  # AriaCoda
        ["SCIP2.0", "VV", "VV", "PP", "II", "TM0", "TM1", "TM1", "TM2", "BM", "CR00", "VV", "MS0044072501000"],
        ["SCIP2.0", "TM2", "RS", "RS", "VV", "MD0044072501000"],  # hokuyo_node
        ["SCIP2.0", "QT", "QT", "VV", "PP", "QT", "BM", "QT", "MD0044072501000"],  # BreezyLidar
        ["SCIP2.0", "TM0", "QT", "TM2", "QT", "PP", "MD0044072501000"],  # urg_library, after a client left in time mode
    ],
)
def test_handshakes_of_other_software_are_answered(commands: list[str]) -> None:
    lidar = EmulatedUrg04lx(plant())
    for command in commands:
        said = lidar.receive(command.encode() + b"\n", lidar.due) + run(lidar, 0.1)
        assert bool(said) == bool(command), "every command is answered within a turn"
        if command:
            assert said.startswith(command.encode() + b"\n")
    frames = FrameDecoder().feed(run(lidar, 1.0))
    found = [decode_scan(reply) for lines in frames if (reply := find_reply(lines))]
    assert len(found) >= 8
    assert {scan.request.encode() for scan in found} == {commands[-1]}


def test_the_handshake_of_aria_is_answered() -> None:
    robot = EmulatedP3dx(plant())
    robot.receive(b"WMS2\r", robot.due)
    for wire in ("FAFB03000000", "FAFB03010001"):
        assert robot.receive(bytes.fromhex(wire), robot.due) == bytes.fromhex(wire)
    assert b"Pioneer" in robot.receive(bytes.fromhex("FAFB03020002"), robot.due)
    robot.receive(bytes.fromhex("FAFB06013B0100023B"), robot.due)
    assert say(robot, Command(CommandId.CONFIG, 1))[0][0] == CONFIG_PACKET
    say(robot, Command(CommandId.BATTERYINFO, 1), Command(CommandId.HOSTBAUD, 2), Command(CommandId.PULSE))
    assert robot.baud == 38400
    assert len(sips(robot, 0.9)) == 9
