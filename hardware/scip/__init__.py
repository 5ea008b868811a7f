"""SCIP 1.1 and 2.0, the protocols of Hokuyo's URG lidars: bytes to values in SI units, and back. No input or output.

Source: Hokuyo C-42-03320B; for details beyond it, real sensors and urg_library, hokuyoaist and AriaCoda.
"""
