"""A P3-DX and a URG-04LX that are not there: the far end of two serial lines, for any ARCOS or SCIP software.

``p3dx`` and ``urg04lx`` are the devices, pure machines of bytes and time; ``serial_line`` lies between them and a
port; ``emulator`` lets them run in real time, moved by a ``Plant``.
"""
