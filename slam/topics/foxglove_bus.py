"""Topics for the Foxglove app, over WebSockets: https://docs.foxglove.dev, subprotocol ``foxglove.sdk.v1``."""

import logging
from collections.abc import Callable
from threading import Lock
from typing import Any, Final, Self

from slam.errors import InputError
from slam.files.fields import BadLine
from slam.files.ros.encoder import Encoder, nanoseconds
from slam.files.ros.from_json import cdr_of_json
from slam.files.ros.messages import ros2_type
from slam.named_code import import_optional
from slam.topics.names import PUBLISHED
from slam.topics.topic import Bus, Topic

EXTRA: Final = "live"
"""The extra of this project that installs foxglove-sdk."""
PORT: Final = 8765
"""Default port of the app."""
_BACKLOG: Final = 256
"""Messages that may wait for a slow client; then the oldest is dropped."""


class FoxgloveBus:
    """Serves the topics to every Foxglove app that connects, with the types of ROS 2 and in CDR.

    Messages from an app may be CDR or JSON. No client can delay the publisher. When a client subscribes to a latched
    topic, the last message of the topic is sent again, to all clients.
    """

    def __init__(self, host: str = "127.0.0.1", port: int = PORT) -> None:
        """Make a server that is not started yet; port 0 means any. InputError without foxglove-sdk."""
        self._sdk, self._host, self._port = import_optional("foxglove", EXTRA), host, port
        self._server: Any = None
        self._context, self._encoder = self._sdk.Context(), Encoder()
        self._channels: dict[str, Any] = {}
        self._latched, self._heard = Latched(), ClientMessages()

    def __enter__(self) -> Self:
        """Start the server; InputError if the port is taken.

        The channels are opened first, as a server refuses subscriptions to a channel that is still being opened.
        """
        for topic in PUBLISHED:
            self._open(topic)
        logging.getLogger("foxglove").setLevel(logging.CRITICAL)  # else it logs each wrong message
        try:
            self._server = self._sdk.start_server(
                name="hopslam", host=self._host, port=self._port, context=self._context,
                capabilities=[self._sdk.Capability.ClientPublish], supported_encodings=["cdr", "json"],
                server_listener=_Listener(self._latched, self._heard), message_backlog_size=_BACKLOG,
            )  # fmt: skip
        except RuntimeError as error:
            raise InputError(
                f"{self._host}:{self._port} cannot serve Foxglove: {error}; choose another port"
            ) from error
        return self

    def __exit__(self, *_: object) -> None:
        """Close all connections."""
        self._server.stop()

    @property
    def address(self) -> str:
        """Address for the app."""
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"ws://{host}:{self._server.port}"

    def publish(self, topic: Topic, stamp: float, message: bytes) -> None:
        """Send a message to every client that has subscribed to the topic."""
        channel = self._channels.get(topic.name) or self._open(topic)
        time = nanoseconds(stamp)
        if topic.latched:
            self._latched.keep(topic.name, lambda: channel.log(message, log_time=time))
        channel.log(message, log_time=time)

    def subscribe(self, topic: Topic, heard: Callable[[bytes], None]) -> None:
        """Call ``heard``, in a thread of the server, with each message of a client, in CDR."""
        self._heard.add(topic, heard)

    def _open(self, topic: Topic) -> Any:
        definition = self._encoder.definition(topic.type).encode()
        schema = self._sdk.Schema(name=topic.type, encoding="ros2msg", data=definition)
        channel = self._sdk.Channel(topic.name, message_encoding="cdr", schema=schema, context=self._context)
        self._channels[topic.name] = channel
        return channel


class Latched:
    """Sends the last message of a latched topic again."""

    def __init__(self) -> None:
        self._send: dict[str, Callable[[], None]] = {}

    def keep(self, topic: str, send: Callable[[], None]) -> None:
        """Keep the function that sends the latest message."""
        self._send[topic] = send

    def repeat(self, topic: str) -> None:
        """Send the last message of this topic again, if it is latched and has one."""
        if (send := self._send.get(topic)) is not None:
            send()


class ClientMessages:
    """Passes messages of clients to the listeners of their topics."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._topics: list[tuple[Topic, Callable[[bytes], None]]] = []
        self._channels: dict[tuple[int, int], tuple[str, str, str]] = {}

    def add(self, topic: Topic, heard: Callable[[bytes], None]) -> None:
        """Add a listener for the topic; one name may have listeners with several types."""
        self._topics.append((topic, heard))

    def open(self, client: int, channel: int, advertised: tuple[str, str, str]) -> None:
        """Record the topic, encoding and type of a client's channel."""
        with self._lock:
            self._channels[client, channel] = advertised

    def close(self, client: int, channel: int) -> None:
        """Forget a client's channel."""
        with self._lock:
            self._channels.pop((client, channel), None)

    def take(self, client: int, channel: int, data: bytes) -> None:
        """Pass on a message in CDR, an empty one for garbled JSON; a message without a listener is ignored."""
        with self._lock:
            name, encoding, kind = self._channels.get((client, channel), ("", "", ""))
        for topic, heard in self._topics:
            if topic.name == name and topic.type == ros2_type(kind):
                heard(_in_cdr(data, encoding, topic.type))


def _in_cdr(data: bytes, encoding: str, kind: str) -> bytes:
    if encoding != "json":
        return data
    try:
        return cdr_of_json(data, kind)
    except BadLine:
        return b""


class _Listener:
    """Called by the server, in its own threads."""

    def __init__(self, latched: Latched, heard: ClientMessages) -> None:
        self._latched, self._heard = latched, heard

    def on_subscribe(self, client: Any, channel: Any) -> None:
        self._latched.repeat(channel.topic)

    def on_unsubscribe(self, client: Any, channel: Any) -> None:
        pass

    def on_client_advertise(self, client: Any, channel: Any) -> None:
        self._heard.open(client.id, channel.id, (channel.topic, channel.encoding, channel.schema_name))

    def on_client_unadvertise(self, client: Any, client_channel_id: int) -> None:
        self._heard.close(client.id, client_channel_id)

    def on_message_data(self, client: Any, client_channel_id: int, data: bytes) -> None:
        self._heard.take(client.id, client_channel_id, data)


_: type[Bus] = FoxgloveBus
