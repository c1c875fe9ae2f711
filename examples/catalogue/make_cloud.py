"""Print a made-up debris cloud as three-line elements; ``cloud.tle`` is what it prints."""

from random import Random

from adr_opt.sources.catalogue.tle import checksum

OBJECTS = 60


def main() -> None:
    """Print one object after the other; the catalogue numbers are not in use."""
    uniform = Random(7).uniform
    for number in range(1, OBJECTS + 1):
        object_number = f"{90000 + number}"
        first = (
            f"1 {object_number}U 26001{chr(64 + (number - 1) % 24 + 1):<3} "
            f"26001.{uniform(0, 99999999):08.0f}  .{uniform(200, 900):08.0f}  00000+0 "
            f" {uniform(10000, 99999):05.0f}-3 0  999"
        )
        second = (
            f"2 {object_number} {uniform(97.9, 98.5):8.4f} {uniform(43.5, 46.5):8.4f} "
            f"{uniform(2000, 40000):07.0f} {uniform(0, 359.99):8.4f} {uniform(0, 359.99):8.4f} "
            f"{uniform(14.25, 14.55):11.8f}{number:5d}"
        )
        print(f"SYNTHETIC DEB {number}")
        print(f"{first}{checksum(first)}")
        print(f"{second}{checksum(second)}")


if __name__ == "__main__":
    main()
