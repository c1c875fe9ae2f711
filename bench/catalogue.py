"""Time to import and filter a large catalogue, in every format.

    python bench/catalogue.py [OBJECTS]

Prints a Markdown table: seconds to read, and to propagate, filter, place the station and make the
instance, for a synthetic catalogue (24,000 objects by default) held in a file; and the whole
command, in a process of its own.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from machine import heading

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/fields"))

from catalogue_files import SPELLINGS, field

from adr_opt.sources import catalogue

MAX_TARGETS = 100


def main() -> None:
    """Measure and print."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 24_000
    records = field(count)
    filters = catalogue.Filters(altitude_km=(700.0, 900.0), inclination_deg=(80.0, 100.0))
    catalogue.to_instance(records[:10])  # what is imported once is not measured
    print(f"{heading()}\n{count} objects\n")
    print("| spelling | file MB | read s | propagate, filter, make s | whole command s |")
    print("|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for spelling, write in SPELLINGS.items():
            path, out = Path(folder, f"all.{spelling}"), Path(folder, "out.json")
            path.write_text(write(records), encoding="utf-8")
            begin = time.perf_counter()
            found = catalogue.read(path)
            middle = time.perf_counter()
            catalogue.to_instance(found, filters=filters, max_targets=MAX_TARGETS)
            end = time.perf_counter()
            subprocess.run(
                [
                    sys.executable,
                    "-m",
                    "adr_opt",
                    "import",
                    path,
                    "--out",
                    out,
                    "--altitude",
                    "700:900",
                    "--inclination",
                    "80:100",
                    "--max-targets",
                    str(MAX_TARGETS),
                    "--quiet",
                ],
                check=True,
            )
            whole = time.perf_counter() - end
            size = path.stat().st_size / 1e6
            print(
                f"| {spelling} | {size:.1f} | {middle - begin:.2f} | {end - middle:.2f} "
                f"| {whole:.2f} |"
            )


if __name__ == "__main__":
    main()
