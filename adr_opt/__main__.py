"""``python -m adr_opt``, also installed as ``adr-opt``."""

from __future__ import annotations

import sys

from .ui.cli.entry import main

if __name__ == "__main__":
    sys.exit(main())
