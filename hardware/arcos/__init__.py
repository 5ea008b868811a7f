"""ARCOS, the serial protocol of Pioneer robots: bytes to values in SI units and radians, and back. No input or output.

Source: AriaCoda (ArRobotPacket, ArRobot, ArRobotConfigPacketReader), AMRISim, Player's p2os driver.
"""
