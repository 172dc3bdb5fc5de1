"""Peak memory of the programs that run under a process."""

import threading
from pathlib import Path

POLL = 0.02  # s between looks


class MemoryWatch:
    """Notes, while it is entered, the peak resident memory of every bedload program under `parent`."""

    def __init__(self, parent: int) -> None:
        self._parent = parent
        self._peaks: dict[int, tuple[str, int]] = {}
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> "MemoryWatch":
        self._thread.start()
        return self

    def __exit__(self, *_) -> None:
        self._over.set()
        self._thread.join()

    def bytes_of(self, program: str = "bedload-") -> int:
        """Summed over all processes whose name begins so (the kernel keeps 15 letters of a name)."""
        return sum(peak for name, peak in self._peaks.values() if name.startswith(program[:15]))

    def _watch(self) -> None:
        while not self._over.wait(POLL):
            for process in _descendants(self._parent):
                status = _status(process)
                if "VmHWM" in status:
                    peak = int(status["VmHWM"].split()[0]) * 1024
                    self._peaks[process] = (status["Name"].strip(), peak)


def _status(process: int) -> dict[str, str]:
    try:
        text = Path(f"/proc/{process}/status").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return {}
    return dict(line.split(":", 1) for line in text.splitlines() if ":" in line)


def _descendants(parent: int) -> list[int]:
    found, todo = [], [parent]
    while todo:
        children = []
        for tasks in Path(f"/proc/{todo.pop()}/task").glob("*/children"):
            try:
                children += map(int, tasks.read_text(encoding="ascii").split())
            except OSError:
                continue
        found += children
        todo += children
    return found
