"""The network of a ROS 2 node: its domain, and the machines on which it searches for other nodes."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Self
from xml.sax.saxutils import quoteattr

from slam.errors import InputError, did_you_mean

_MAX_DOMAIN: Final = 232
"""Largest domain: above it DDS has no ports left."""
_RANGES: Final = ("LOCALHOST", "SUBNET", "SYSTEM_DEFAULT")
_THIS_MACHINE: Final = "<Interfaces><NetworkInterface address='127.0.0.1' multicast='true'/></Interfaces>"
_MAX_PARTICIPANTS: Final = 32
"""Participants of this machine that are searched one by one without multicast, as in ROS."""


@dataclass(frozen=True, slots=True)
class RosNetwork:
    """Domain and reach of a node; by default it finds the programs of this machine only."""

    domain: int = 0
    this_machine: bool = True
    peers: tuple[str, ...] = ()
    """Addresses of other machines to search."""
    own_config: str = ""
    """Configuration of Cyclone DDS that replaces all other fields except the domain; "" for none."""

    @classmethod
    def from_environment(cls, environment: Mapping[str, str] = os.environ) -> Self:
        """Read the environment variables of ROS 2; InputError for an invalid value.

        They are ``ROS_DOMAIN_ID``, ``ROS_LOCALHOST_ONLY``, ``ROS_AUTOMATIC_DISCOVERY_RANGE`` and ``ROS_STATIC_PEERS``,
        and ``CYCLONEDDS_URI`` of Cyclone DDS. Unlike in ROS, the default range is LOCALHOST.
        """
        domain, reach = environment.get("ROS_DOMAIN_ID") or "0", environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE") or ""
        if not (domain.isdecimal() and int(domain) <= _MAX_DOMAIN):
            raise InputError(f"ROS_DOMAIN_ID={domain}: give a whole number from 0 to {_MAX_DOMAIN}")
        if reach and reach not in _RANGES:
            raise InputError(f"ROS_AUTOMATIC_DISCOVERY_RANGE={reach}: {did_you_mean(reach, _RANGES)}")
        return cls(
            int(domain),
            environment.get("ROS_LOCALHOST_ONLY") == "1" or reach in ("", "LOCALHOST"),
            tuple(peer for peer in environment.get("ROS_STATIC_PEERS", "").split(";") if peer),
            environment.get("CYCLONEDDS_URI", ""),
        )

    @property
    def cyclone_config(self) -> str:
        """Configuration of Cyclone DDS: https://cyclonedds.io/docs/cyclonedds/latest/config."""
        if self.own_config:
            return self.own_config
        peers = ("127.0.0.1", *self.peers) if self.this_machine else self.peers
        addresses = "".join(f"<Peer address={quoteattr(peer)}/>" for peer in peers)
        return (
            f"<CycloneDDS><Domain><General>{_THIS_MACHINE if self.this_machine else ''}</General><Discovery>"
            f"<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>{_MAX_PARTICIPANTS}</MaxAutoParticipantIndex>"
            f"<Peers>{addresses}</Peers></Discovery></Domain></CycloneDDS>"
        )
