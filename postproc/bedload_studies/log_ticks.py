"""Numbers at the ticks of a logarithmic axis."""

from matplotlib.axis import Axis
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

WIDE, NARROW = 300.0, 4.0  # an axis that spans more shows powers of ten, one that spans less many numbers


def plain_ticks(axis: Axis) -> None:
    """Numbers as one writes them in place of 2 x 10^1, and so many that none meets another."""
    low, high = axis.get_view_interval()
    span = high / low
    subs = (1.0,) if span > WIDE else (1.0, 2.0, 5.0) if span > 30.0 else (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)
    axis.set_major_locator(LogLocator(subs=(*subs, 1.2, 2.5, 4.0, 6.0, 8.0) if span < NARROW else subs, numticks=20))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())
