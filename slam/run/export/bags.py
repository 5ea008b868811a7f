"""The log of a run as a bag: an MCAP file, or the folder of a ROS 2 bag."""

from pathlib import Path
from typing import Final

from rosbags.interfaces import Connection, Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import Writer

from slam.files.atomic_files import atomic_file, atomic_folder
from slam.files.logs.read import RUN_LOG
from slam.files.ros.encoder import Encoder
from slam.files.ros.mcap_files import McapWriter
from slam.files.ros.messages import TF_STATIC, ros2_types
from slam.run.results.run_log import logged_messages
from slam.run.results.run_record import RunRecord

_CHUNK_SIZE: Final = 1 << 20
"""Size of a chunk, bytes, as usual for recorders."""
_VERSION: Final = 8
_NEVER: Final = QosTime(2147483647, 4294967295)
_LATCHED: Final = Qos(
    QosHistory.KEEP_LAST, 1, QosReliability.RELIABLE, QosDurability.TRANSIENT_LOCAL, _NEVER, _NEVER,
    QosLiveliness.AUTOMATIC, _NEVER, False,
)  # fmt: skip
"""Quality of service with which late listeners get the static transforms too."""


def write_mcap(record: RunRecord, out: Path) -> None:
    """Write the topics of ``log.mcap``, message by message."""
    with atomic_file(out) as draft:
        writer = McapWriter(draft, Encoder(), _CHUNK_SIZE)
        for message in logged_messages(record.folder / RUN_LOG):
            writer.write(message.topic, message.time, message.data)
        writer.close()


def write_rosbag2(record: RunRecord, out: Path) -> None:
    """Write the topics of ``log.mcap``, message by message."""
    connections: dict[str, Connection] = {}
    with atomic_folder(out) as draft, Writer(draft, version=_VERSION) as writer:
        for message in logged_messages(record.folder / RUN_LOG):
            if message.topic not in connections:
                profiles = [_LATCHED] if message.topic == TF_STATIC else []
                connections[message.topic] = writer.add_connection(
                    message.topic, message.type, typestore=ros2_types(), offered_qos_profiles=profiles
                )
            writer.write(connections[message.topic], message.time, message.data)
