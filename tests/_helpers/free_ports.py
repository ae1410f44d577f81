"""Ports for servers of tests, which run beside each other."""

from __future__ import annotations

import socket


def free_port() -> int:
    """Return a free port of 127.0.0.1 that no viewer reaches when it counts up from 7000."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])
