"""The report of a mission: text, tables and interactive charts in a single HTML file.

:func:`page` gives the text of the page and :func:`write_report` writes it. The page holds all that
it shows, the charting library included (plotly.js, extra ``[viz]``), and asks the network for
nothing. The plan is checked (:func:`adr_opt.check`) and the page says what came of it.
"""

from __future__ import annotations

from .page import Report, page, write_report

__all__ = ["Report", "page", "write_report"]
