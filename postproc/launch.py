"""Entry of the launcher: puts this folder on the path and runs bedload_launcher."""

import sys
from pathlib import Path

if sys.version_info < (3, 11):  # noqa: UP036  (that is what it says)
    sys.exit(f"bedload: needs Python 3.11 or later, but {sys.executable} is {sys.version.split()[0]}")

sys.path.insert(0, str(Path(__file__).resolve().parent))

from bedload_launcher.cli import main  # noqa: E402  (needs the path above)

try:
    sys.exit(main())
except ModuleNotFoundError as error:
    sys.exit(f"bedload: Python's package {error.name} is missing; README.md names what to install")
