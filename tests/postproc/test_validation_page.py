"""The page of the validation says first what misses its bound, and every number has its place."""

from bedload_studies.validation import page_of
from bedload_studies.validation_runs import Result, Row

DRAG = Result("Drag, D/h = 8", rows=[
    Row("K", 2.02, 2.0, 0.02, source="theory"), Row("order", 1.3),
])  # fmt: skip
SPIN = Result("Spin", rows=[Row("torque", 1.2, 1.0, 0.1, source="exact"), Row("moment", 0.95, 1.0, 0.1)])


def test_missed_bounds_come_first():
    lines = page_of({"drag": DRAG, "spin": SPIN}).splitlines()
    head = lines[: lines.index("## drag: Drag, D/h = 8")]
    assert "**1 of 3 numbers miss their bounds:**" in head
    assert [line for line in head if line.startswith("- ")] == [
        "- `spin`: torque: 1.2, should be 1 (exact), +20.00 %, bound 10 %"
    ]
    assert "| [drag](#drag-drag-dh--8) | Drag, D/h = 8 | 1 of 1 |" in head
    assert "| [spin](#spin-spin) | Spin | **1 of 2** |" in head


def test_all_numbers_stand_there():
    page = page_of({"drag": DRAG})
    assert "**0 of 1 numbers miss their bounds.**" in page
    assert "| K | 2.02 | 2 (theory) | +1.00 % | 2 % | kept |" in page
    assert "| order | 1.3 |  |  |  |  |" in page
