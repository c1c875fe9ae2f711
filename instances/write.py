"""Write the instances of the library as files, each checked against its SHA-256.

    python instances/write.py --out DIR                    # all of them
    python instances/write.py --out DIR cloud large        # some families
    python instances/write.py                              # only check, write nothing

An instance goes to DIR/FAMILY/NAME.json; a file that is there already is written anew, with the
same bytes. Exit status 0: all of them are what the library lists; 1: some are not; 2: wrong input.

For maintainers: `--renew VERSION` lists what the generator gives now in `library.json`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from adr_opt.common.errors import InputError
from adr_opt.common.files import write_text
from adr_opt.sources.generator import family, generate
from adr_opt.sources.library import Entry, Library, load_library

LIBRARY = Path(__file__).with_name("library.json")
SIZES = {
    "tiny": 10,
    "nominal": 100,
    "reduced-time": 100,
    "reduced-fuel": 100,
    "cloud": 20,
    "large": 20,
    "rocket-bodies": 20,
    "sso": 20,
    "campaign": 20,
    "removal": 20,
    "electric": 20,
    "fragment-cloud": 5,
}
"""Instances of each family: the seeds from 0."""

CROWDS = 5
"""Seeds of the family `large` with more targets than it has."""

CROWD_SIZES = (500, 1000, 2000)


def renewed(version: str) -> Library:
    """The library that the generator gives now."""
    made = [generate(name, seed) for name, size in SIZES.items() for seed in range(size)]
    made += [
        generate("large", seed, targets=count) for count in CROWD_SIZES for seed in range(CROWDS)
    ]
    entries = tuple(Entry(name=instance.name, sha256=instance.sha256) for instance in made)
    return Library(version="0.0", instances=entries).replace(version=version)


def chosen(library: Library, families: Sequence[str]) -> list[Entry]:
    """The entries of some families, or all.

    Raises
    ------
    InputError
        A family is unknown or not in the library.
    """
    if not families:
        return list(library.instances)
    entries: list[Entry] = []
    for name in families:
        found = library.of_family(family(name).name)
        if not found:
            raise InputError(f"family {name!r} is not in the library; leave it out")
        entries += found
    return entries


def write(entries: Sequence[Entry], out: Path | None) -> int:
    """Generate, check and write; returns how many are not what the library lists."""
    wrong = 0
    for entry in entries:
        try:
            instance = entry.generate()
        except InputError as error:
            print(f"wrong: {error}", file=sys.stderr)
            wrong += 1
            continue
        if out is not None:
            folder = out / entry.family
            try:
                folder.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise InputError(
                    f"{folder}: cannot be created ({error.strerror}); choose another --out"
                ) from None
            write_text(folder / f"{entry.name}.json", instance.to_json())
    return wrong


def main(argv: Sequence[str] | None = None) -> int:
    """Do what the arguments say and return the exit status."""
    parser = argparse.ArgumentParser(description="Write and check the library of instances.")
    parser.add_argument("families", nargs="*", metavar="FAMILY", help="all, if none is named")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder to write to")
    parser.add_argument("--library", type=Path, default=LIBRARY, metavar="FILE")
    parser.add_argument("--renew", metavar="VERSION", help="list what the generator gives now")
    arguments = parser.parse_args(argv)
    try:
        if arguments.renew:
            write_text(arguments.library, renewed(arguments.renew).to_json())
        library = load_library(arguments.library)
        entries = chosen(library, arguments.families)
        wrong = write(entries, arguments.out)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    where = "checked" if arguments.out is None else f"written to {arguments.out}"
    print(f"library {library.version}: {len(entries) - wrong} of {len(entries)} instances {where}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
