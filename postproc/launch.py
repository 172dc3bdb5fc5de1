"""Entry of the launcher: puts this folder on the path and runs bedload_launcher."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from bedload_launcher.cli import main  # noqa: E402  (needs the path above)

sys.exit(main())
