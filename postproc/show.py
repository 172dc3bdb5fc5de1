"""Shows the result of a run: `/usr/bin/python3 postproc/show.py OUT`. Runs bedload_post.show."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

try:
    from bedload_post.show import main
except KeyboardInterrupt:
    sys.exit(130)
except ModuleNotFoundError as error:
    sys.exit(f"bedload: Python's package {error.name} is missing; README.md names what to install")

sys.exit(main())
