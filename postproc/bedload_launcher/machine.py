"""What this machine offers: cores and memory, a container's limits included."""

import os
from pathlib import Path

GIGABYTE = 2**30
MEMORY_PER_COMPILER = 1.5 * GIGABYTE  # the LIGGGHTS styles' templates need about this much


def _first_line(path: str) -> str:
    try:
        return Path(path).read_text(encoding="ascii").splitlines()[0]
    except (OSError, IndexError):
        return ""


def processors() -> int:
    """Hardware threads that this process may use: affinity mask and cgroup quota."""
    count = len(os.sched_getaffinity(0))
    quota = _first_line("/sys/fs/cgroup/cpu.max").split()
    if len(quota) == 2 and quota[0] != "max":
        count = min(count, max(1, int(quota[0]) // int(quota[1])))
    return count


def cores() -> int:
    """Physical cores among them: a second thread of a core brings the fluid solver nothing."""
    siblings = {
        _first_line(f"/sys/devices/system/cpu/cpu{cpu}/topology/thread_siblings_list") or str(cpu)
        for cpu in os.sched_getaffinity(0)
    }
    return max(1, min(len(siblings), processors()))


def available_memory() -> float:
    """Bytes that can still be taken."""
    available = float("inf")
    for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
        if line.startswith("MemAvailable:"):
            available = float(line.split()[1]) * 1024
    limit = _first_line("/sys/fs/cgroup/memory.max")
    if limit.isdigit():
        used = _first_line("/sys/fs/cgroup/memory.current")
        available = min(available, float(limit) - (float(used) if used.isdigit() else 0.0))
    return available


# Beginnings of the names of instruction sets that compilers use; the kernel's list names much else.
COMPILED_FOR = ("sse", "ssse", "avx", "fma", "f16c", "bmi", "abm", "popcnt", "movbe", "adx", "aes", "vaes", "sha",
                "gfni", "pclmul", "vpclmul", "amx", "asimd", "sve", "atomics", "crc32", "i8mm", "bf16")  # fmt: skip


def instruction_sets() -> frozenset[str]:
    """Those of the processor that a compiler uses for it alone, by the kernel's names; none where it does not say."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        return frozenset()
    names = next((line.partition(":")[2] for line in lines if line.startswith(("flags", "Features"))), "")
    return frozenset(name for name in names.split() if name.startswith(COMPILED_FOR))


def compile_jobs() -> int:
    """Compilers at a time: one per processor, no more than the memory holds."""
    return max(1, min(processors(), int(available_memory() / MEMORY_PER_COMPILER)))
