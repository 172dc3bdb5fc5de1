"""Checkpoints spoilt at random, with a fixed seed: each one is refused with one sentence that offers the
one before; none is accepted, none makes the reader crash or hang. The reader is the one of `--restart`."""

import os
import random
import selectors
import shutil
import subprocess

import pytest

from programs import BIN, ENVIRONMENT
from pocket import checkpoint, job, spoken, two_checkpoints

PARTS = ["fluid.h5", "grains.h5"]
HEADER = 512  # bytes of the file header in front of each part: kind and version, size, check sum
READER = os.environ.get("BEDLOAD_READER", str(BIN / "open_checkpoints"))  # the sanitizers bring theirs
MOMENT = 20.0  # seconds; a checkpoint of this size is read in milliseconds


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return two_checkpoints(tmp_path_factory.mktemp("whole") / "out")


@pytest.fixture(scope="module")
def twin(tmp_path_factory):
    """A run of the same scene."""
    return two_checkpoints(tmp_path_factory.mktemp("twin") / "out")


class Reader:
    """open_checkpoints, asked by lines; an answer that does not come is a hang."""

    def __init__(self):
        self.process = subprocess.Popen([READER], env=ENVIRONMENT, stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, text=True)  # fmt: skip
        self.answers = selectors.DefaultSelector()
        self.answers.register(self.process.stdout, selectors.EVENT_READ)

    def open(self, folder):
        self.process.stdin.write(f"{folder}\n")
        self.process.stdin.flush()
        assert self.answers.select(MOMENT), "the reader hangs"
        answer = self.process.stdout.readline()
        assert answer, f"the reader died with status {self.process.wait(MOMENT)}"
        return answer.rstrip("\n")


@pytest.fixture(scope="module")
def reader():
    reader = Reader()
    yield reader
    reader.process.stdin.close()
    assert reader.process.wait(MOMENT) == 0


def flipped(content, chance):
    """One to eight bits, anywhere."""
    for _ in range(chance.choice([1, 1, 2, 8])):
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    return content


def flipped_in_front(content, chance):
    content[chance.randrange(HEADER)] ^= 1 << chance.randrange(8)
    return content


def truncated(content, chance):
    return content[: chance.choice([0, 1, HEADER - 1, HEADER, chance.randrange(len(content))])]


def longer(content, chance):
    return content + chance.randbytes(chance.choice([1, 8, 4096]))


def zeroed(content, chance):
    """A block of what a disk writes at once, or all behind the file header."""
    begin, size = chance.randrange(HEADER, len(content)), chance.choice([8, 512, 4096, len(content)])
    block = slice(HEADER if size == len(content) else begin, begin + size)
    content[block] = bytes(len(content[block]))
    return content


def blocks_exchanged(content, chance):
    size = chance.choice([8, 512, (len(content) - HEADER) // 2])
    a = HEADER + chance.randrange((len(content) - HEADER) // 2 - size + 1)
    b = chance.randrange(a + size, len(content) - size + 1)
    content[a : a + size], content[b : b + size] = content[b : b + size], content[a : a + size]
    return content


def shifted(content, chance):
    at = chance.randrange(HEADER, len(content))
    return content[:at] + chance.randbytes(8) + content[at:-8]


def another_version(content, chance):
    line, rest = bytes(content).split(b"\n", 1)
    version = chance.choice([b"0", b"7", b"99999999999999999999", b"-1", b"x", b""])
    return bytearray(line.rsplit(b" ", 1)[0] + b" " + version + b"\n" + rest)


def random_bytes(content, chance):
    return bytearray(chance.randbytes(chance.randrange(len(content))))


WAYS = [flipped, flipped_in_front, truncated, longer, zeroed, blocks_exchanged, shifted, another_version,
        random_bytes]  # fmt: skip
BY_NAME = {way.__name__: way for way in WAYS}


def check_refusal(said, folder, before):
    assert said.startswith(f"{folder}/"), said
    assert said.endswith(f"The one before it is whole: --restart {before}"), said


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("way", BY_NAME)
def test_refused(whole, reader, tmp_path, part, way):
    """Thirty of each of nine kinds and each part, 540 in all. Every byte of a part counts, zeros included."""
    chance = random.Random(f"{part} {way}")
    out = tmp_path / "out"
    shutil.copytree(whole, out)
    last, before = checkpoint(out, 4), checkpoint(out, 2)
    assert reader.open(out) == "step 4"
    content = (last / part).read_bytes()
    for _ in range(30):
        spoilt = bytes(BY_NAME[way](bytearray(content), chance))
        if spoilt == content:  # zeros written over zeros
            continue
        (last / part).write_bytes(spoilt)
        check_refusal(reader.open(out), last, before)
    (last / part).write_bytes(content)
    assert reader.open(out) == "step 4"


def halves_exchanged(last, before):
    (last / "fluid.h5").rename(last / "third")
    (last / "grains.h5").rename(last / "fluid.h5")
    (last / "third").rename(last / "grains.h5")


def one_part_of_the_other_step(part):
    return lambda last, before: shutil.copy(before / part, last / part)


def half_of_another_run(part):
    """The same step of a run that is the same but for its number."""
    return lambda last, before: shutil.copy(last.parents[1] / "twin" / last.name / part, last / part)


def missing(part):
    return lambda last, before: (last / part).unlink()


def a_folder(last, before):
    (last / "fluid.h5").unlink()
    (last / "fluid.h5").mkdir()


def endless(last, before):
    """A file that never ends; the check of a size must come first."""
    (last / "grains.h5").unlink()
    (last / "grains.h5").symlink_to("/dev/zero")


def silent(last, before):
    """A pipe in which nobody writes."""
    (last / "fluid.h5").unlink()
    os.mkfifo(last / "fluid.h5")


FOLDERS = {
    "halves exchanged": halves_exchanged,
    "fluid of the other step": one_part_of_the_other_step("fluid.h5"),
    "grains of the other step": one_part_of_the_other_step("grains.h5"),
    "fluid of another run": half_of_another_run("fluid.h5"),
    "grains of another run": half_of_another_run("grains.h5"),
    "no fluid": missing("fluid.h5"),
    "no grains": missing("grains.h5"),
    "a folder for a file": a_folder,
    "an endless file": endless,
    "a pipe": silent,
}


@pytest.mark.parametrize("way", FOLDERS)
def test_a_spoilt_folder_is_refused(whole, twin, reader, tmp_path, way):
    out = tmp_path / "out"
    shutil.copytree(whole, out)
    (tmp_path / "twin").symlink_to(twin)
    last, before = checkpoint(out, 4), checkpoint(out, 2)
    FOLDERS[way](last, before)
    check_refusal(reader.open(out), last, before)


def test_both_spoilt(whole, reader, tmp_path):
    """No checkpoint is offered then, but the last flow where that is whole."""
    out = tmp_path / "out"
    shutil.copytree(whole, out)
    for step in (2, 4):
        (checkpoint(out, step) / "fluid.h5").write_bytes(b"")
    said = reader.open(out)
    assert said.startswith(str(checkpoint(out, 4))) and "--restart" not in said
    assert said.endswith(f"begin with its last flow: --set start.from=state --set start.file={out}/state.h5")
    with (out / "state.h5").open("r+b") as file:
        file.truncate(1000)
    assert reader.open(out).endswith("The run has no other one that can be read; begin a new run.")


def test_the_one_behind_is_offered(whole, reader, tmp_path):
    """Where there is none before."""
    out = tmp_path / "out"
    shutil.copytree(whole, out)
    (checkpoint(out, 2) / "fluid.h5").write_bytes(b"")
    said = reader.open(checkpoint(out, 2))
    assert said.endswith(f"The one behind it is whole: --restart {checkpoint(out, 4)}")


def test_a_run_without_liggghts_is_no_damage(whole, reader, tmp_path):
    """Its sentence offers nothing: no other checkpoint of that run is better."""
    out = tmp_path / "out"
    shutil.copytree(whole, out)
    for step in (2, 4):
        (checkpoint(out, step) / "grains.h5").unlink()
    assert reader.open(out) == f"{checkpoint(out, 4)}: is of a run without LIGGGHTS; go on with bedload-fluid alone."


@pytest.mark.parametrize(
    "part, way",
    [("fluid.h5", "flipped"), ("grains.h5", "truncated"), ("grains.h5", "another_version"),
     ("fluid.h5", "random_bytes"), (None, "halves exchanged"), (None, "grains of the other step"),
     (None, "an endless file")],
)  # fmt: skip
def test_through_both_programs(whole, tmp_path, part, way):
    """The job ends with the sentence, and goes on from what it offers."""
    out = tmp_path / "out"
    shutil.copytree(whole, out)
    last, before = checkpoint(out, 4), checkpoint(out, 2)
    if part is None:
        FOLDERS[way](last, before)
    else:
        content = bytearray((last / part).read_bytes())
        (last / part).write_bytes(bytes(BY_NAME[way](content, random.Random(5))))
    result = job(out, "--steps", "1", ranks=(2, 1), restart=out)
    assert result.status != 0
    said = spoken(result.output)
    assert len(said) == 1, result.output
    check_refusal(said[0].removeprefix("bedload-fluid: "), last, before)
    assert job(out, "--steps", "1", restart=before).status == 0
