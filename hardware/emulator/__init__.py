"""Emulated P3-DX and lidars: the far end of two serial lines, for any ARCOS or SCIP software.

``p3dx`` and ``urg04lx`` are the devices, which depend on bytes and time only; ``serial_line`` connects them to a port;
``emulator`` runs them in real time, moved by a ``Plant``.
"""
