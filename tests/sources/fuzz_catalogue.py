"""Coverage-guided fuzzing of the catalogue readers, for a few minutes.

    python -m pip install atheris
    python tests/sources/fuzz_catalogue.py [SECONDS]

Not a test that pytest collects: it runs until a time is over (180 s by default). It begins with a
small file of every spelling and looks for inputs that take new branches. A finding is any exception
but an `InputError`, a sentence that is not one printable line, and anything that takes 10 s. It is
printed as a traceback, and the input is left in a file `crash-…` or `timeout-…` for a test.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import atheris

sys.path.insert(0, str(Path(__file__).parents[1] / "fields"))

with atheris.instrument_imports(include=["adr_opt.sources.catalogue"]):
    from adr_opt.sources.catalogue import reading, to_instance

from catalogue_files import field
from spoilt_catalogues import PIECES, SEEDS, outcome, with_checksums

MEMORY_MIB = 4096
SLOWEST_S = 10
LONGEST_BYTES = 8192


def one_input(data: bytes) -> None:
    """Read and import: bits of the first byte say how."""
    if data:
        content = with_checksums(data[1:]) if data[0] & 2 else data[1:]
        outcome(content, skip_bad=bool(data[0] & 1))


def main() -> None:
    """Fuzz for as long as the first argument says."""
    seconds = int(sys.argv[1]) if len(sys.argv) > 1 else 180
    to_instance(field(2))  # what is imported or compiled once is no hang
    assert reading.read_bytes(SEEDS[0], "seed").records
    with tempfile.TemporaryDirectory() as folder:
        corpus = Path(folder, "corpus")
        corpus.mkdir()
        for number, seed in enumerate(SEEDS):
            for flag in (b"0", b"1", b"2", b"3"):
                Path(corpus, f"seed-{number}-{flag.decode()}").write_bytes(flag + seed)
        words = Path(folder, "words")
        words.write_text(
            "".join(
                '"' + "".join(f"\\x{byte:02x}" for byte in piece) + '"\n'
                for piece in PIECES
                if piece
            )
        )
        atheris.Setup(
            [
                sys.argv[0],
                str(corpus),
                f"-dict={words}",
                f"-max_total_time={seconds}",
                f"-timeout={SLOWEST_S}",
                f"-rss_limit_mb={MEMORY_MIB}",
                f"-max_len={LONGEST_BYTES}",
                "-print_final_stats=1",
            ],
            one_input,
        )
        atheris.Fuzz()


if __name__ == "__main__":
    main()
