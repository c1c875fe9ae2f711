"""Print made-up rocket bodies as three-line elements; ``bodies.tle`` is what it prints."""

from random import Random

from adr_opt.sources.catalogue.tle import checksum

OBJECTS = 18


def main() -> None:
    """Print one object after the other; the catalogue numbers are not in use."""
    uniform = Random(16).uniform
    for number in range(1, OBJECTS + 1):
        object_number = f"{91000 + number}"
        first = (
            f"1 {object_number}U 26002{chr(64 + number):<3} "
            f"26001.{uniform(0, 99999999):08.0f}  .00000{uniform(10, 90):03.0f}  00000+0 "
            f" {uniform(10000, 99999):05.0f}-4 0  999"
        )
        second = (
            f"2 {object_number} {uniform(70.9, 71.1):8.4f} {uniform(0, 359.99):8.4f} "
            f"{uniform(1000, 40000):07.0f} {uniform(0, 359.99):8.4f} {uniform(0, 359.99):8.4f} "
            f"{uniform(14.13, 14.18):11.8f}{number:5d}"
        )
        print(f"SYNTHETIC R/B {number}")
        print(f"{first}{checksum(first)}")
        print(f"{second}{checksum(second)}")


if __name__ == "__main__":
    main()
