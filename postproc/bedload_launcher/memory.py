"""Peak memory of the programs that run under a process."""

import os
import threading
from collections import Counter
from pathlib import Path

POLL = 0.02  # s between looks
LOOKS_PER_SHARE = 25  # the kernel counts the shares page by page, which takes a millisecond


class MemoryWatch:
    """Notes, while it is entered, the peak resident memory of every bedload program under `parent`.

    proportional_bytes: largest sum over the programs at one time, each page that several processes have
    (the code of libraries, messages between ranks) divided among them; peaks of less than
    POLL LOOKS_PER_SHARE seconds may be missed.
    """

    def __init__(self, parent: int) -> None:
        self._parent = parent
        self._peaks: dict[str, int] = {}
        self.proportional_bytes = 0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> "MemoryWatch":
        self._thread.start()
        return self

    def __exit__(self, *_) -> None:
        self._over.set()
        self._thread.join()

    def bytes_of(self, program: str = "bedload-") -> int:
        """Summed over all processes whose name begins so (the kernel keeps 15 letters of a name) and which ran at one
        time: runs that follow each other do not add up."""
        return sum(peak for name, peak in self._peaks.items() if name.startswith(program[:15]))

    def _watch(self) -> None:
        look = 0
        while not self._over.wait(POLL):
            share_too, shares, at_once = look % LOOKS_PER_SHARE == 0, 0, Counter[str]()
            look += 1
            for process in _descendants(self._parent):
                status = _table(process, "status")
                if "VmHWM" not in status:
                    continue
                name = status["Name"].strip()
                at_once[name] += _bytes(status["VmHWM"])
                if share_too and name.startswith("bedload-"):
                    shares += _bytes(_table(process, "smaps_rollup").get("Pss", "0 kB"))
            for name, peak in at_once.items():
                self._peaks[name] = max(self._peaks.get(name, 0), peak)
            self.proportional_bytes = max(self.proportional_bytes, shares)


def _table(process: int, file: str) -> dict[str, str]:
    """The lines 'key: value' of a file in /proc/PID."""
    try:
        text = Path(f"/proc/{process}/{file}").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return {}
    return dict(line.split(":", 1) for line in text.splitlines() if ":" in line)


def _bytes(entry: str) -> int:
    """'87172 kB'"""
    return int(entry.split()[0]) * 1024


def _descendants(parent: int) -> list[int]:
    found, todo = [], [parent]
    while todo:
        children: list[int] = []
        process = todo.pop()
        try:
            threads = os.listdir(f"/proc/{process}/task")
        except OSError:  # it has ended since its parent named it
            continue
        for thread in threads:
            try:
                text = Path(f"/proc/{process}/task/{thread}/children").read_text(encoding="ascii")
            except OSError:
                continue
            children += map(int, text.split())
        found += children
        todo += children
    return found
