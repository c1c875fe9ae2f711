"""Print made-up upper stages of two kinds as three-line elements; ``bodies.tle`` is the output."""

from random import Random

from adr_opt.sources.catalogue.tle import checksum

KINDS = (("SL-16", 9, (70.97, 71.03), (14.13, 14.18)), ("SL-8", 6, (82.92, 82.96), (13.72, 13.78)))
"""Name, how many, inclinations [degrees], revolutions a day."""


def main() -> None:
    """Print one object after the other; the catalogue numbers are not in use."""
    uniform, number = Random(8).uniform, 0
    for kind, count, inclinations, motions in KINDS:
        for _ in range(count):
            number += 1
            object_number = f"{92000 + number}"
            first = (
                f"1 {object_number}U 26003{chr(64 + number):<3} "
                f"26001.{uniform(0, 99999999):08.0f}  .00000{uniform(10, 90):03.0f}  00000+0 "
                f" {uniform(10000, 99999):05.0f}-4 0  999"
            )
            second = (
                f"2 {object_number} {uniform(*inclinations):8.4f} {uniform(0, 359.99):8.4f} "
                f"{uniform(1000, 30000):07.0f} {uniform(0, 359.99):8.4f} "
                f"{uniform(0, 359.99):8.4f} {uniform(*motions):11.8f}{number:5d}"
            )
            print(f"SYNTHETIC {kind} R/B")
            print(f"{first}{checksum(first)}")
            print(f"{second}{checksum(second)}")


if __name__ == "__main__":
    main()
