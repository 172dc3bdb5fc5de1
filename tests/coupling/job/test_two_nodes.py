"""A job over two nodes, tried on one machine: each node is a network namespace with a host name and a
folder for MPI's sessions of its own, joined by a virtual cable, so that all between them goes over TCP;
mpirun starts the other node's part through an agent that enters its namespace, as ssh would."""

import os
import shutil
import signal
import subprocess

import numpy as np
import pytest

from programs import BIN, ENVIRONMENT, wait_for
from pocket import SCENE, checkpoints, job, numbers, spoken

STEPS = 12
NODES = {f"10.77.13.{n}": f"bedload-{os.getpid()}-{n}" for n in (1, 2)}


def ip(*words):
    return subprocess.run(["ip", *words], capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def agent(tmp_path_factory):
    """The program that starts a command on a node: agent ADDRESS COMMAND..."""
    folder = tmp_path_factory.mktemp("nodes")
    if os.geteuid() != 0 or shutil.which("ip") is None or shutil.which("unshare") is None:
        pytest.skip("network namespaces take root, ip (iproute2) and unshare")
    first, second = NODES.values()
    for node in NODES.values():
        made = ip("netns", "add", node)
        if made.returncode != 0:
            ip("netns", "del", first)
            pytest.skip(f"network namespaces cannot be had here: {made.stderr.strip()}")
    try:
        cable = ip("-n", first, "link", "add", "cable", "type", "veth", "peer", "name", "cable",
                   "netns", second)  # fmt: skip
        if cable.returncode != 0:
            pytest.skip(f"virtual cables cannot be had here: {cable.stderr.strip()}")
        for address, node in NODES.items():
            ip("-n", node, "address", "add", f"{address}/24", "dev", "cable")
            for device in ("lo", "cable"):
                ip("-n", node, "link", "set", device, "up")
            (folder / node).mkdir()
        cases = "".join(f"{address}) node={node} ;;\n" for address, node in NODES.items())
        script = folder / "agent"
        script.write_text(
            f"#!/bin/sh\ncase $1 in\n{cases}esac\nshift\n"
            f"export OMPI_MCA_orte_tmpdir_base={folder}/$node TMPDIR={folder}/$node\n"
            'exec ip netns exec $node unshare --uts sh -c "hostname $node; exec $*"\n')
        script.chmod(0o755)
        yield script
    finally:
        for node in NODES.values():
            ip("netns", "del", node)


def words(agent, out, *options):
    """A fluid rank on each node, LIGGGHTS on the second."""
    first, second = NODES
    rest = ["--mca", "plm_rsh_agent", str(agent), "--mca", "btl_tcp_if_include", "cable",
            "--mca", "oob_tcp_if_include", "cable", "--mca", "btl", "self,vader,tcp"]  # fmt: skip
    fluid = [str(BIN / "bedload-fluid"), str(SCENE / "fluid.toml"), "--out", str(out), *options]
    dem = [str(BIN / "bedload-dem"), "-in", str(SCENE / "in.liggghts"), "-var", "out", str(out)]
    line = ["mpirun", "--quiet", *rest, "--host", f"{first}:1,{second}:2", "-np", "2", *fluid, ":",
            "-np", "1", *dem, "-log", "none"]  # fmt: skip
    return [str(agent), first, *line]


def test_the_same_numbers_as_on_one_node(agent, tmp_path):
    out = tmp_path / "out"
    done = subprocess.run(words(agent, out, "--steps", str(STEPS)), env=ENVIRONMENT, text=True,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, timeout=300, check=False)  # fmt: skip
    assert done.returncode == 0, done.stdout
    here = tmp_path / "here"
    result = job(here, "--steps", str(STEPS), ranks=(2, 1))
    assert result.status == 0, result.output
    a, b = numbers(out / "spheres.h5"), numbers(here / "spheres.h5")
    for name in ("position", "velocity", "angular_velocity", "force"):
        # Two fresh runs: FFTW may have chosen other algorithms, round-off of 1e-16 over 12 steps.
        assert np.abs(a[f"mobile/{name}"] - b[f"mobile/{name}"]).max() < 1e-10, name


def test_a_death_on_one_node_ends_both(agent, tmp_path):
    out = tmp_path / "out"
    options = ["--set", "time.end=1e3", "--set", "checkpoint.every=0.1"]
    running = subprocess.Popen(words(agent, out, *options), env=ENVIRONMENT, text=True,
                               stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT)  # fmt: skip
    try:
        wait_for(lambda: checkpoints(out), running)
        pids = [int(pid) for node in NODES.values()
                for pid in ip("netns", "pids", node).stdout.split()]
        mine = {pid: name for pid in pids if (name := command_name(pid)).startswith("bedload-")}
        assert len(mine) == 3
        os.kill(next(pid for pid, name in mine.items() if name == "bedload-dem"), signal.SIGKILL)
        said, _ = running.communicate(timeout=120)
    finally:
        running.kill()
    assert running.returncode != 0
    # The node of the dead names it; the other one knows only that it is asked to end.
    cause = [sentence for sentence in spoken(said) if "asked to end" not in sentence]
    assert len(cause) == 1 and "bedload-dem, rank 0" in cause[0] and "died" in cause[0], said
    assert not [pid for node in NODES.values() for pid in ip("netns", "pids", node).stdout.split()
                if command_name(int(pid)).startswith("bedload-")]


def command_name(pid):
    try:
        with open(f"/proc/{pid}/comm", encoding="ascii", errors="replace") as comm:
            return comm.read().strip()
    except OSError:
        return ""
