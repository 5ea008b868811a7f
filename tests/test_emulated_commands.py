"""The emulated P3-DX against the Pioneer 3 Operations Manual: bytes in, bytes out, decoded by hand."""

import pytest

from hardware.emulator.p3dx import EmulatedP3dx
from hardware.emulator.p3dx_commands import COMMANDS
from sim.plant import SimPlant
from tests.rooms import room_scenario
from tests.scripted_devices import packet

SONAR, IOREQUEST, ENCODER, DIGOUT, ADSEL, TTY2, GETAUX = 28, 40, 19, 30, 35, 42, 43
BATTEST, RESET = 250, 253


class RingedPlant(SimPlant):
    """A plant with a front ring that measures a metre everywhere."""

    def sonar(self) -> tuple[float, ...]:
        return (1.0,) * 8


def command(number: int, argument: int | None = None) -> bytes:
    data = bytes([number])
    return packet(data if argument is None else data + b"\x3b" + argument.to_bytes(2, "little"))


def closed() -> EmulatedP3dx:
    return EmulatedP3dx(RingedPlant(room_scenario((-2.0, 3.0), (-2.0, 2.0))))


def opened() -> EmulatedP3dx:
    robot = closed()
    for number in (0, 1, 2, 1):
        robot.receive(command(number), robot.due)
    return robot


def cycle(robot: EmulatedP3dx, sent: bytes = b"", count: int = 1) -> dict[int, list[bytes]]:
    """Return the data of the packets of ``count`` cycles, by their types."""
    said = robot.receive(sent, robot.due) if sent else b""
    for _ in range(10 * count):
        said += robot.step()
    found: dict[int, list[bytes]] = {}
    while said:
        assert said[:2] == b"\xfa\xfb"
        size = said[2] + 3
        assert said[:size] == packet(said[3 : size - 2])
        found.setdefault(said[3], []).append(said[4 : size - 2])
        said = said[size:]
    return found


def test_a_closed_robot_answers_the_handshake_in_its_order() -> None:
    robot = closed()
    for number in (2, 1, 4, 18):  # a CLOSE sent just in case, and what else may come too early
        assert robot.receive(command(number), robot.due) == b""
    for number in (0, 0, 1, 1):  # an echo that was lost is asked for again
        assert robot.receive(command(number), robot.due) == command(number)
    assert robot.receive(command(2), robot.due)[3:4] == b"\x02"
    assert not robot.open
    assert robot.receive(command(1), robot.due) == b""
    assert robot.open


def sip_flags(found: dict[int, list[bytes]]) -> tuple[int, int]:
    """Flags, and the number of sonar readings, of the last report (Table 8)."""
    data = found[0x32][-1]
    return int.from_bytes(data[15:17], "little"), data[18]


@pytest.mark.parametrize(
    ("argument", "array", "readings"),
    [(0, 0, 0), (1, 1, 8), (2, 0, 0), (3, 1, 8), (5, 1, 8)],  # all off, all on, array 1 off, on, array 2 is not there
)
def test_the_flags_report_the_sonar(argument: int, array: int, readings: int) -> None:
    robot = opened()
    flags, count = sip_flags(cycle(robot, command(SONAR, argument)))
    assert (flags >> 1 & 0xF, count) == (array, readings)
    flags, count = sip_flags(cycle(robot, command(SONAR, 1)))
    assert (flags >> 1 & 0xF, count) == (1, 8)


def test_an_empty_polling_sequence_switches_the_sonar_off() -> None:
    assert sip_flags(cycle(opened(), packet(b"\x03\x2b\x00")))[0] & 0x1E == 0
    assert sip_flags(cycle(opened(), packet(b"\x03\x2b\x02\x01\x02")))[0] & 0x1E == 2


@pytest.mark.parametrize(("number", "kind"), [(IOREQUEST, 0xF0), (ENCODER, 0x90)])
def test_packets_on_request_come_once_or_in_every_cycle(number: int, kind: int) -> None:
    robot = opened()
    assert kind not in cycle(robot)
    assert len(cycle(robot, command(number, 1), 3)[kind]) == 1
    assert len(cycle(robot, command(number, 2), 3)[kind]) == 3
    assert kind not in cycle(robot, command(number, 0), 2)


def test_inputs_and_outputs_are_reported() -> None:
    robot = opened()
    robot.receive(command(DIGOUT, 0x0F05), robot.due)
    found = cycle(robot, command(IOREQUEST, 1) + command(DIGOUT, 0x0102) + command(ADSEL, 4))
    (io,) = found[0xF0]
    assert io[0] == 4  # bytes of inputs: user port, front and rear bumpers, infrared, which are high when free
    assert io[2:5] == b"\xff\xff\xff"
    assert io[5:7] == bytes([1, 0x04])
    assert io[7] == 9
    readings = [int.from_bytes(io[8 + 2 * k : 10 + 2 * k], "little") for k in range(9)]
    assert len(io) == 8 + 18
    assert readings[:8] == [0] * 8
    assert 0 < readings[8] <= 1023
    sip = found[0x32][-1]
    behind_sonar = sip[19 + 3 * sip[18] :]
    assert (behind_sonar[1], behind_sonar[4]) == (4, 0x04)


def test_an_auxiliary_port_waits_for_all_bytes_asked_for() -> None:
    robot = opened()
    robot.receive(packet(bytes([TTY2]) + b"\x2b\x02hi\x00"), robot.due)
    assert robot.reports.aux[0].sent == b"hi"
    assert 0xB0 not in cycle(robot, command(GETAUX, 3))
    robot.reports.aux[0].put(b"ab")
    assert 0xB0 not in cycle(robot)
    robot.reports.aux[0].put(b"cd")
    assert cycle(robot)[0xB0] == [b"abc"]
    assert 0xB0 not in cycle(robot, command(GETAUX, 0) + command(GETAUX, 1))


def test_a_battery_can_be_tested_and_the_robot_reset() -> None:
    robot = opened()
    assert cycle(robot, command(BATTEST, 105))[0x32][-1][10] == 105
    assert cycle(robot, command(BATTEST, 0))[0x32][-1][10] == 126
    assert cycle(robot, command(RESET), 2) == {}
    assert robot.receive(command(0), robot.due) == command(0)  # closed: it echoes SYNC0


@pytest.mark.parametrize("form", [None, 0, 1, 0x0305])
def test_every_command_is_accepted_and_config_answered(form: int | None) -> None:
    for number in range(256):
        robot = opened()
        answer = robot.receive(command(number, form), robot.due)
        assert bool(answer) == (number == 18), number


def test_every_row_of_the_table_has_its_evidence() -> None:
    assert all(row.evidence for row in COMMANDS.values())
    aria = {
        0,
        1,
        2,
        4,
        5,
        6,
        7,
        8,
        9,
        10,
        11,
        12,
        13,
        15,
        18,
        19,
        21,
        23,
        28,
        29,
        30,
        32,
        40,
        44,
        47,
        50,
        55,
        57,
        58,
        62,
    }
    assert aria | set(range(82, 88)) | {250} <= set(COMMANDS)
