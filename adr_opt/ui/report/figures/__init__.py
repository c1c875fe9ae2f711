"""The charts of the page, each as plain data in plotly's form: ``{"data": […], "layout": {…}}``.

A trace belongs to a phase by its ``meta.phase``, and its points belong to legs by ``customdata``:
the page switches phases off and shows single legs by them. Where ``meta.titled`` is true, the page
gives every point the title of its leg as its text, and ``meta.names`` are the texts of
``meta.each`` points each, so that names are not repeated in the file.
Colours of text and grids are left to
the page, which knows whether it is light or dark.
"""

from .over_time import altitude, budget, costs, gantt, lanes, mass, nodes
from .planes import planes

__all__ = ["altitude", "budget", "costs", "gantt", "lanes", "mass", "nodes", "planes"]
