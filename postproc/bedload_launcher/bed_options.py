"""Options of `./bedload settle`; bedload_studies/bed_settling.py does the work, with packages that may be missing."""

import argparse
from pathlib import Path

from .numbers import finite

REACHABLE = (0.53, 0.62)  # packing of spheres of one size, by falls with most and with no friction
TOLERANCE = 0.005  # of the packing that is asked for, unless told


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "where", metavar="SCENE|LXxLZ",
        help="a scene, whose box is taken, or the box along x and z, as 26x13",
    )  # fmt: skip
    parser.add_argument("--grains", type=int, required=True, metavar="N", help="how many fall")
    parser.add_argument("--seed", type=int, default=1, metavar="S", help="of their places in the air (default: 1)")
    parser.add_argument(
        "--packing", type=finite, metavar="PHI",
        help=f"share of the volume in the bed's inside, about {REACHABLE[0]} to {REACHABLE[1]} for one size (default: "
        "as they fall with friction 0.3)",
    )  # fmt: skip
    parser.add_argument("--tolerance", type=finite, help=f"of --packing (default: {TOLERANCE:g})")
    parser.add_argument(
        "--sizes", default=["1:1"], nargs="+", metavar="D:SHARE",
        help="diameters and their shares of the number, as 1:0.8 0.7:0.2",
    )  # fmt: skip
    parser.add_argument(
        "--base", default="floor", choices=["floor", "hexagonal"],
        help="what they fall on: the floor, or the hexagonal layer of inputs/beds (diameter 1)",
    )  # fmt: skip
    parser.add_argument(
        "--fixed", type=finite, default=0.0, metavar="Y",
        help="grains whose centres come to rest below this height are fixed ones, type 1 (default: none)",
    )  # fmt: skip
    parser.add_argument(
        "--wet", type=finite, default=0.0, metavar="T",
        help="then run the scene for this time without a flow; its script reads ${bed_file} (default: dry only)",
    )  # fmt: skip
    parser.add_argument("--digits", type=int, default=6, help="behind the point, in the file (default: 6)")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="the bed, for LIGGGHTS' read_data; "
                        "an earlier file there is kept as FILE.previous, .previous2, ...")  # fmt: skip
