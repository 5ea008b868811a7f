"""The wire of one session: the recorder, and the recordings that replace devices, each played once."""

from pathlib import Path

from hardware.wire.events import Kind
from hardware.wire.recorder import WireRecorder
from hardware.wire.tape import WireTape
from slam.closing import Closing


class WireSession(Closing):
    """Recorder and recordings that the ports of a session share; bytes are written to the file ``record``."""

    def __init__(self, record: Path | None = None) -> None:
        self._recorder = None if record is None else WireRecorder(record)
        self._tapes: dict[str, WireTape] = {}

    def note(self, port: str, kind: Kind, content: bytes | str) -> None:
        """Record an event, if the wire is recorded."""
        if self._recorder is not None:
            self._recorder.add(port, kind, content)

    def tape(self, url: str) -> WireTape:
        """Return the recording that this URL names, at its present position; InputError if there is none."""
        if url not in self._tapes:
            self._tapes[url] = WireTape(url)
        return self._tapes[url]

    def close(self) -> None:
        """Write what is not written yet; closing twice is allowed."""
        if self._recorder is not None:
            self._recorder.close()
