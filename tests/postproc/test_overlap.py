"""The time line of a step: its table and its figure."""

from bedload_post import overlap

LINE = """program,part,start,end
bedload-fluid,pressure,0.0,3.0
bedload-fluid,waiting for LIGGGHTS,3.0,4.0
bedload-dem,grain motion,1.0,3.5
bedload-fluid,pressure,5.0,9.0
bedload-fluid,waiting for LIGGGHTS,9.0,9.1
bedload-dem,grain motion,6.0,7.5
"""


def test_table_and_figure(tmp_path):
    (tmp_path / "timeline.csv").write_text(LINE)
    rows = overlap.read(tmp_path)
    assert rows[2] == ("bedload-dem", "grain motion", 1.0, 3.5)
    overlap.draw(tmp_path, tmp_path / "overlap.png")
    assert (tmp_path / "overlap.png").stat().st_size > 5000


def test_a_run_that_was_broken_off_has_no_time_line(tmp_path):
    assert overlap.read(tmp_path) == []
