"""Waiting for what other processes do."""

import time


def wait_for(condition, seconds=30.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def ended(process):
    """Of a folder in /proc: whether its process is gone, or dead and nobody has asked for it yet."""
    try:
        return "\tZ" in (process / "status").read_text()
    except OSError:
        return True
