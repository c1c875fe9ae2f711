"""Charts as pictures in files, for ``--plot``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...common.errors import InputError, MissingExtra

if TYPE_CHECKING:
    from ..plot.chart import Chart


def check_picture(path: str) -> None:
    """Refuse a picture that cannot be drawn before long work begins.

    Raises
    ------
    InputError
        Its name ends neither in .svg nor in .png nor in .pdf.
    MissingExtra
        matplotlib is not installed.
    """
    if not path.lower().endswith((".svg", ".png", ".pdf")):
        raise InputError(f"{path}: the picture is SVG, PNG or PDF; give a file that ends so")
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise MissingExtra("a picture", "matplotlib", "viz") from None


def write_picture(chart: Chart, path: str) -> None:
    """Draw a chart with its legend, completely or not at all.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    from ...common.files import write_whole
    from ..plot.draw import draw

    figure, ax = pyplot.subplots(figsize=(7.0, 4.2), layout="constrained")
    draw(ax, chart).legend()
    write_whole(path, figure.savefig)
    pyplot.close(figure)
