"""The studies: series of runs that answer one question each, behind `./bedload study NAME`.

One module a study. The first sentence of its docstring is what `./bedload study` lists;
`add_options(parser)` declares its options with argparse, `run(options) -> int` does the work.
"""
