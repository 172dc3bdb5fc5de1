"""The exchange between the two programs, with a stand-in for the fluid: what arrives, on any numbers of
ranks, and how a job ends when something is wrong."""

import json
import os
import re
import signal
import subprocess
import time

import numpy as np
import pytest

from programs import BIN, ENVIRONMENT, LAYOUTS, LIMIT, SCENES, command, liggghts, run, stand_in, wait_for

COLLISIONS_BOX = ("--length", "2", "1.5", "1")


def trajectories(path):
    """Columns: step, tag, position, velocity, spin, overlap; rows in ascending step and tag."""
    return np.loadtxt(path, delimiter=",")


def job(tmp_path, script, *fluid_options, ranks=(1, 1), dem_options=()):
    result = run(command(stand_in(*fluid_options), liggghts(script, *dem_options), ranks), tmp_path)
    assert result.status == 0, result.output
    return result


@pytest.mark.parametrize("ranks, z_parts", [*((ranks, 1) for ranks in LAYOUTS), ((4, 2), 2), ((4, 3), 4)],
                         ids=lambda value: "{0[0]}+{0[1]}".format(value) if isinstance(value, tuple)
                         else f"z{value}")
def test_spheres_follow_their_loads(tmp_path, ranks, z_parts):
    """Each load acts for exactly its stage: the spheres follow the stand-in's parabolas. They cross
    ranks and periodic faces; with two LIGGGHTS ranks one is without mobile spheres at first; every
    second time step is longer. The loads differ by sphere, stage and step, so that a load that is
    left out, doubled, held too long or given to a wrong sphere shows as 1e-4 and more. Each fluid
    rank hears of the spheres near its block and of no others; with both programs divided along z they
    need not all speak to each other."""
    script = SCENES / "free_flight.liggghts"
    if z_parts == 4:
        script = edited(tmp_path, script, "processors      * 1 1", "processors      1 1 *")
    result = job(tmp_path, script, "--steps", "300", "--alternate", "1.3",
                 "--z-parts", str(z_parts), "--out", "path.csv", ranks=ranks)
    assert result.number("misrouted") == 0
    everything = 300 * 3 * 4 * ranks[0]
    assert result.number("received") == everything if ranks[0] == 1 else \
        everything / ranks[0] <= result.number("received") <= everything * (0.8 if z_parts > 1 else 1)
    # 13500 additions of numbers of size 1 and below round to some 1e-14 at most.
    assert result.number("difference") < 1e-12
    assert result.number("residual") < 1e-13
    assert result.number("changes") == 0
    path = trajectories(tmp_path / "path.csv").reshape(300, 4, 14)
    assert np.ptp(path[:, :, 2], axis=0).min() > 3.9, "each sphere should pass through the x face"


RAIN = """timestep 1e-3
region drop block 0.5 3.5 0.6 1.4 1.6 2.6 units box
fix one all particletemplate/sphere 15485863 atom_type 1 density constant 2000 radius constant 0.35
fix mix all particledistribution/discrete 32452867 1 one 1.0
fix rain grains insert/pack seed 32452843 distributiontemplate mix insert_every once overlapcheck yes all_in no &
    vel constant 0 0 -2.0 region drop ntry_mc 100000 particles_in_region 4
fix             fluid"""


def test_spheres_that_are_inserted_may_be_near_any_block(tmp_path):
    """None at the start. Blocks end at z = 1.2, 2.4 and 3.6, LIGGGHTS' parts at 1.6 and 3.2: spheres of radius 0.35
    that come down to 1.67 concern the first block, from which their rank's part is 0.4 away and the skin 0.1 wide."""
    text = (SCENES / "free_flight.liggghts").read_text()
    for old, new in {"processors      * 1 1": "processors      1 1 *", "block 0 4 0 2 0 2 ": "block 0 4 0 2 0 4.8 ",
                     "fix             fluid": RAIN}.items():  # fmt: skip
        assert old in text
        text = text.replace(old, new)
    kept = [line for line in text.splitlines() if not line.startswith(("create_atoms", "set ", "velocity"))]
    (tmp_path / "rain.liggghts").write_text("\n".join(kept) + "\n")
    result = job(tmp_path, tmp_path / "rain.liggghts", "--length", "4", "2", "4.8", "--z-parts", "4",
                 "--steps", "60", "--out", "path.csv", ranks=(4, 3))  # fmt: skip
    assert result.number("misrouted") == 0 and result.number("residual") < 1e-13
    assert trajectories(tmp_path / "path.csv")[:, 4].min() < 1.6


def test_collisions_are_the_same_on_all_ranks(tmp_path):
    paths = {}
    for ranks in LAYOUTS:
        out = f"path{ranks[0]}{ranks[1]}.csv"
        result = job(tmp_path, "collisions.liggghts", *COLLISIONS_BOX, "--steps", "400",
                     "--out", out, ranks=ranks)
        assert result.number("difference") > 0.1, "the spheres should have collided"
        assert result.number("residual") < 1e-13
        paths[ranks] = trajectories(tmp_path / out)
    for ranks in LAYOUTS[1:]:
        # Sums over contacts in another order: 1e-16 that each of some ten collisions multiplies by
        # about the distance between collisions over the radius.
        np.testing.assert_allclose(paths[ranks], paths[(1, 1)], rtol=0, atol=1e-9)


def test_the_fluid_hears_how_far_spheres_overlap(tmp_path):
    """The sum over a sphere's contacts of its share of each, as the reduced mass has it, towards the other: with
    the fixed bed, both walls, and grains of which one is three times as dense."""
    script = edited(tmp_path, "collisions.liggghts", "group           bed",
                    "set atom 6 density 6000\ngroup           bed")
    job(tmp_path, script, *COLLISIONS_BOX, "--steps", "400", "--out", "path.csv", ranks=(2, 2))
    path = trajectories(tmp_path / "path.csv").reshape(400, 4, 14)
    length, bed = np.array([2.0, 1.5, 1.0]), [(x, 0.2, 0.5) for x in (0.3, 0.8, 1.3, 1.8)]
    radius, inverse_mass = [0.2] * 4 + [0.15] * 4, [0.0] * 4 + [1.0, 1 / 3, 1.0, 1.0]
    met = {"bed": 0, "grain": 0, "floor": 0, "roof": 0}
    for step in path:
        places = np.vstack([bed, step[:, 2:5]])
        for i in range(4, 8):
            above, below = places[i][1] + radius[i] - length[1], radius[i] - places[i][1]
            expected = np.array([0.0, max(above, 0.0) - max(below, 0.0), 0.0])
            met["roof"] += above > 0.0
            met["floor"] += below > 0.0
            for j in range(8):
                way = places[j] - places[i]
                way -= length * (1, 0, 1) * np.round(way / length)
                depth = radius[i] + radius[j] - np.linalg.norm(way)
                if j == i or depth <= 0.0:
                    continue
                share = inverse_mass[i] / (inverse_mass[i] + inverse_mass[j])
                expected += share * depth * way / np.linalg.norm(way)
                met["bed" if j < 4 else "grain"] += 1
            np.testing.assert_allclose(step[i - 4, 11:], expected, rtol=0, atol=1e-13)
    assert min(met.values()) > 0, met


@pytest.mark.parametrize("ranks", [(1, 1), (3, 2)], ids="{0[0]}+{0[1]}".format)
def test_script_around_and_between_coupled_runs(tmp_path, ranks):
    """Spheres come and go between coupled runs, and what the script puts there works as ever."""
    result = job(tmp_path, "staged.liggghts", "--steps", "40", "--out", "path.csv", ranks=ranks,
                 dem_options=("-screen", "/dev/stdout"))
    assert result.number("misrouted") == 0
    assert result.number("changes") == 2, "one sphere came, one went"
    path = trajectories(tmp_path / "path.csv")
    tags = {int(step): sorted(path[path[:, 0] == step][:, 1]) for step in (0, 9, 10, 19, 20, 39)}
    assert tags == {0: [1, 2], 9: [1, 2], 10: [1, 2, 3], 19: [1, 2, 3], 20: [2, 3], 39: [2, 3]}
    # Thermo: a line where a coupled run begins, each 75 steps, and where it ends.
    steps = [int(s) for s in re.findall(r"^ +(\d+) +[23] +0\.\d+ ", result.output, re.MULTILINE)]
    assert steps == [100, 150, 225, 250, 250, 300, 375, 400, 400, 450, 525, 600, 675, 700]
    # 100 dry steps of 1e-3, then 40 fluid steps of 0.01.
    assert re.search(r"^ +700 +2 +0\.5 ", result.output, re.MULTILINE)
    # The load along y from an averaging fix, every 15 steps: 14 - 5 v per sphere plus a little. The
    # new sphere bears its first load from the second stage on: the fluid hears of it in the first.
    mean = np.loadtxt(tmp_path / "mean.txt")
    assert len(mean) == 40
    assert np.all(np.abs(mean[:, 2] - np.repeat([28.5, 42.5, 28.26], [11, 9, 20])) < 0.05)
    assert (tmp_path / "motion.txt").read_text().count("TIMESTEP") == 8


def test_a_table_that_a_restart_would_begin_anew(tmp_path):
    """A dry run is done again by --restart, and a table that was there before it would lose its rows."""
    table = "fix table all collision/table file table.csv\n"
    before = edited(tmp_path, "staged.liggghts", "timestep ", table + "timestep ")
    result = run(command(stand_in(), liggghts(before)), tmp_path, timeout=LIMIT)
    assert result.status != 0
    assert "put it behind the dry run" in result.output
    behind = edited(tmp_path, "staged.liggghts", "group           first", table + "group first")
    job(tmp_path, behind, "--steps", "1")


@pytest.mark.parametrize("steps", [5, 10, 15])
def test_the_fluid_may_end_within_any_coupled_run(tmp_path, steps):
    """In the first, where it ends, or in the second: what is left of the script passes, and the job
    ends. A coupled_run that waited for loads would wait for ever."""
    line = command(stand_in("--steps", str(steps)), liggghts("staged.liggghts"))
    result = run(line, tmp_path, timeout=LIMIT)
    assert result.status == 0, result.output
    assert result.number("changes") == (steps > 10)


def test_a_fix_behind_can_hold_a_sphere_in_its_plane(tmp_path):
    job(tmp_path, "plane.liggghts", "--steps", "50", "--out", "path.csv")
    path = trajectories(tmp_path / "path.csv")
    assert np.all(path[:, 4] == 0.5) and np.all(path[:, 7] == 0.0)
    assert np.ptp(path[:, 2]) > 1e-4, "it should still be pushed along x"


def test_what_pushes_behind_a_held_direction_pushes_all_the_time(tmp_path):
    """A force along the direction that setforce takes from the fluid's loads: v = F t/m, and along x as without it."""
    free = job(tmp_path, "plane.liggghts", "--steps", "20", "--out", "free.csv")
    held = "setforce NULL NULL 0.0"
    script = edited(tmp_path, "plane.liggghts", held, f"{held}\nfix push all addforce 0.0 0.0 3.0")
    pushed = job(tmp_path, script, "--steps", "20", "--out", "pushed.csv")
    assert free.number("received") == pushed.number("received")
    free, pushed = trajectories(tmp_path / "free.csv"), trajectories(tmp_path / "pushed.csv")
    mass, step = 2000 * np.pi / 6 * 0.3**3, 0.01
    assert pushed[:, 7] == pytest.approx(3.0 / mass * step * np.arange(1, 21), rel=1e-12)
    assert np.array_equal(pushed[:, 5:7], free[:, 5:7])


@pytest.mark.parametrize(
    "options, found",
    [
        (("--length", "4", "2.5", "2"), ["[0, 2.5]", "[0, 2]", "grid.length"]),
        (("--periodic", "1", "0", "0"), ["z is not periodic", "periodic in the LIGGGHTS script"]),
        (("--gravity", "0", "-0.6", "0"), ["(0, -0.6, 0)", "(0, -0.5, 0)", "fluid.gravity"]),
    ],
    ids=["box", "periodicity", "gravity"],
)
def test_hand_shake_names_both_values(tmp_path, options, found):
    check_hand_shake(tmp_path, options, "free_flight.liggghts", found)


@pytest.mark.parametrize(
    "line, found",
    [
        ("fluidDensity scalar 999", ["density is 1000", "999", "fluidDensity"]),
        ("fluidViscosity scalar 2.0", ["viscosity is 1 ", "2 in", "fluidViscosity"]),
    ],
    ids=["density", "viscosity"],
)
def test_fluid_values_of_the_script_have_to_be_the_fluids(tmp_path, line, found):
    """The stand-in's fluid has the density 1000 and the kinematic viscosity 1e-3."""
    script = edited(tmp_path, "free_flight.liggghts", FIX, f"fix liquid all property/global {line}\n{FIX}")
    check_hand_shake(tmp_path, (), script, found)


@pytest.mark.parametrize(
    "lines, found",
    [
        ("fix width all property/global fluidCellSize scalar 0.2", ["fluidCellSize is 0.2", "0.025 wide"]),
        ("fix film all lubrication viscosity 2.0", ["viscosity is 2,", "the fluid's is 1 "]),
        ("neighbor 0.1 multi", ["fix couple/fluid: 'neighbor ... multi' finds no contacts"]),
    ],
    ids=["cell", "film", "multi"],
)
def test_what_the_script_says_of_its_fluid_is_the_fluids(tmp_path, lines, found):
    """Cells of the stand-in's fluid are 0.025 wide, its dynamic viscosity is 1; each is met by LIGGGHTS' side."""
    script = edited(tmp_path, "free_flight.liggghts", "coupled_run", f"{lines}\ncoupled_run")
    result = run(command(stand_in(), liggghts(script)), tmp_path, timeout=LIMIT)
    assert result.status != 0
    for text in found:
        assert text in result.output


def test_a_time_step_of_the_script_is_said_not_to_count(tmp_path):
    line = "fix step all property/global fluidTimeStep scalar 0.5"
    script = edited(tmp_path, "free_flight.liggghts", "coupled_run", f"{line}\ncoupled_run")
    result = run(command(stand_in("--steps", "2"), liggghts(script)), tmp_path, timeout=LIMIT)
    assert result.status == 0, result.output
    assert "fluidTimeStep is 0.5, which does not count" in result.output


def check_hand_shake(tmp_path, options, script, found):
    result = run(command(stand_in(*options), liggghts(script), (2, 2)), tmp_path)
    assert result.status != 0
    sentences = [line for line in result.output.splitlines() if line.startswith("bedload-fluid: ")]
    assert len(sentences) == 1, result.output
    for text in found:
        assert text in sentences[0]
    assert result.seconds < LIMIT


def edited(tmp_path, script, old, new):
    text = (SCENES / script).read_text()
    assert old in text
    (tmp_path / "edited.liggghts").write_text(text.replace(old, new))
    return tmp_path / "edited.liggghts"


def messages(folder, ranks):
    """Messages of the busiest rank of each program in a whole job of four steps, as many ranks in both, along z
    in a box as long as they are many, so that each has three partners."""
    text = (SCENES / "free_flight.liggghts").read_text()
    for old, new in {"processors      * 1 1": "processors      1 1 *",
                     "block 0 4 0 2 0 2 ": f"block 0 4 0 2 0 {3 * ranks} "}.items():  # fmt: skip
        assert old in text
        text = text.replace(old, new)
    (folder / "long.liggghts").write_text(text)
    counts = folder / f"counts{ranks}"
    counts.mkdir()
    counted = ["env", f"BEDLOAD_COUNTS={counts}", f"LD_PRELOAD={BIN / 'count_use.so'}"]
    fluid = stand_in("--length", "4", "2", str(3 * ranks), "--z-parts", str(ranks), "--steps", "4")
    result = run(command(counted + fluid, counted + liggghts(folder / "long.liggghts"), (ranks, ranks)), folder)
    assert result.status == 0 and result.number("misrouted") == 0, result.output
    found = {"stand_in_fluid": [], "bedload-dem": []}
    for file in counts.glob("*.json"):
        told = json.loads(file.read_text(encoding="utf-8"))
        if told["program"] in found:
            found[told["program"]].append(told["messages"])
    assert [len(each) for each in found.values()] == [ranks, ranks]
    return {program: max(each) for program, each in found.items()}


def test_messages_do_not_grow_with_the_ranks(tmp_path):
    """Hand-shake, partners, steps and farewell. One message from each rank to each rank of the other program
    would make two more on six ranks than on four."""
    assert messages(tmp_path, 4) == messages(tmp_path, 6)


FIX = "fix             fluid all couple/fluid fixed bed"
NO_MORE = "are no more those of the coupled_run before"


def between(change):
    """Two coupled runs with a change between them."""
    return f"\ncoupled_run steps 2\n{change}\ncoupled_run"


@pytest.mark.parametrize(
    "old, new, found",
    [
        ("pair_style      gran", "pair_style      grann", "ERROR: "),
        ("pair_style      gran", "pair_style      ${grann}", "The script's line is 'pair_style      ${grann} model"),
        ("\ncoupled_run", "\nrun 100", "use coupled_run"),
        ("\ncoupled_run", "\ncoupled_run step 5", "unknown keyword 'step', the nearest is 'steps'"),
        ("\ncoupled_run", "\nquit", "before the fluid did"),
        ("\ncoupled_run", "\n", "before the fluid did"),
        ("\ncoupled_run", "\ncoupled_run steps 5", "before the fluid did"),
        (FIX, "", "needs a fix couple/fluid"),
        (FIX, FIX + "s", "'beds'"),
        (FIX, FIX.replace("fixed", "fixt"), "'fixt'"),
        ("hold bed freeze", "hold bed nve/sphere", "is moved by an integrating fix"),
        (FIX, f"fix still grains freeze\n{FIX}", "stands before it and would not hold atom 5"),
        ("\ncoupled_run", between("unfix hold\nfix more bed nve/sphere"), "is moved by an integrating fix"),
        ("\ncoupled_run", between("group one id 1\ndelete_atoms group one compress no"), NO_MORE),
        ("\ncoupled_run", between("group bed id 5"), NO_MORE),
        ("\ncoupled_run", between("displace_atoms bed move 0.01 0 0 units box"), NO_MORE),
        ("\ncoupled_run", between("set group bed diameter 0.41"), NO_MORE),
        ("atom_modify     map array", "", "atom_modify map array"),
    ],
)
def test_a_mistake_in_the_script_ends_the_job_with_its_sentence(tmp_path, old, new, found):
    script = edited(tmp_path, "collisions.liggghts", old, new)
    result = run(command(stand_in(*COLLISIONS_BOX), liggghts(script), (2, 2)), tmp_path)
    assert result.status != 0
    assert result.output.count(found) == 1, result.output
    assert result.seconds < LIMIT


def test_couple_fluid_without_a_fluid_says_so(tmp_path):
    result = run(command(None, liggghts("free_flight.liggghts")), tmp_path)
    assert result.status != 0 and "this job has no fluid" in result.output


def test_plain_liggghts_without_a_fluid(tmp_path):
    script = edited(tmp_path, "free_flight.liggghts", "\ncoupled_run", "\nrun 10")
    script.write_text(script.read_text().replace(FIX, "").replace("f_fluid[1] f_fluid[4]", ""))
    result = run(command(None, liggghts(script), (0, 2)), tmp_path)
    assert result.status == 0 and "Loop time" in result.output


def test_a_mistake_found_by_the_fluid_ends_the_job_with_its_sentence(tmp_path):
    result = run(command(stand_in("--mistake-at", "5"), liggghts("free_flight.liggghts"), (2, 2)),
                 tmp_path)
    assert result.status != 0
    assert result.output.count("bedload-fluid: the stand-in was told to find a mistake.") == 1
    assert result.seconds < LIMIT


def test_sudden_death_of_the_fluid_ends_the_job(tmp_path):
    result = run(command(stand_in("--die-at", "5"), liggghts("free_flight.liggghts"), (2, 2)),
                 tmp_path)
    assert result.status != 0
    assert result.seconds < LIMIT


def process(pid):
    """Name, state letter and parent of a process; None when it is gone."""
    try:
        with open(f"/proc/{pid}/stat", encoding="ascii", errors="replace") as stat:
            name, rest = stat.read().split("(", 1)[1].rsplit(")", 1)
    except OSError:
        return None
    return name, rest.split()[0], int(rest.split()[1])


def alive(pid):
    """False also for a process that is dead and that nobody has asked for yet."""
    found = process(pid)
    return found is not None and found[1] not in "ZX"


def children(pid):
    """Processes whose parent is `pid`, by name."""
    found = {}
    for entry in filter(str.isdigit, os.listdir("/proc")):
        known = process(entry)
        if known is not None and known[2] == pid:
            found.setdefault(known[0], []).append(int(entry))
    return found


def test_sudden_death_of_liggghts_ends_the_job(tmp_path):
    # Slow steps: at full speed the spheres would reach a wall within the second that is waited here.
    fluid = stand_in("--steps", "1000000000", "--pressure-seconds", "0.02")
    line = command(fluid, liggghts("free_flight.liggghts"), (2, 2))
    mpirun = subprocess.Popen(line, cwd=tmp_path, env=ENVIRONMENT, stdin=subprocess.DEVNULL,
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        wait_for(lambda: len(children(mpirun.pid).get("bedload-dem", [])) == 2, mpirun)
        time.sleep(1.0)
        ranks = children(mpirun.pid)
        everybody = sum(ranks.values(), [])
        assert len(everybody) >= 4
        os.kill(ranks["bedload-dem"][0], signal.SIGKILL)
        assert mpirun.wait(timeout=LIMIT) != 0
        wait_for(lambda: not any(alive(pid) for pid in everybody), seconds=LIMIT)
    finally:
        if mpirun.poll() is None:
            mpirun.kill()


def waits_cheaply(job_that_waits, job_that_does_not, wait, bound):
    """Whether a wait of `wait` seconds costs less than `bound` processor seconds: what the same job takes
    without it, start and end included (1 to 2 s, more on a slow or loaded machine), is taken off. What the
    machine adds differs from job to job; a rank that burns its core does so every time: three trials."""
    def cost():
        waiting = job_that_waits()
        assert waiting.seconds > wait
        return waiting.cpu_seconds - job_that_does_not().cpu_seconds

    return any(cost() < bound for _ in range(3))


def test_liggghts_burns_no_core_while_the_fluid_computes(tmp_path):
    """The fluid sleeps 3.6 s in its "pressure solve"; each of the two LIGGGHTS ranks would burn 3.6 s if
    it looked for news without a pause. Bound: half of what one such rank would burn."""
    def run_with(seconds):
        return job(tmp_path, "free_flight.liggghts", "--steps", "24", "--pressure-seconds", seconds,
                   ranks=(1, 2))

    assert waits_cheaply(lambda: run_with("0.05"), lambda: run_with("0"), 3.6, 1.8)


def test_the_fluid_burns_no_core_while_liggghts_computes(tmp_path):
    """The same with the script asleep for 4 s before the hand-shake, and two fluid ranks waiting."""
    def run_with(script):
        return job(tmp_path, script, "--steps", "2", ranks=(2, 1))

    sleeping = edited(tmp_path, "free_flight.liggghts", "\ncoupled_run", "\nshell sleep 4\ncoupled_run")
    assert waits_cheaply(lambda: run_with(sleeping), lambda: run_with("free_flight.liggghts"), 4.0, 2.0)
