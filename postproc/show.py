"""Shows the result of a run: `/usr/bin/python3 postproc/show.py OUT`. Runs bedload_post.show."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from bedload_post.show import main  # noqa: E402  (needs the path above)

sys.exit(main())
