"""The page: one HTML file that needs nothing else, opens offline and fits a phone."""

from __future__ import annotations

import json
import math
from html import escape
from itertools import count

from . import charts, quality
from .model import Means, Results, Section
from .published import CALIBRATION, HARDWARE, PUBLISHED, Published
from .statistics import fields_needed, least_p, pairs

MOST_FAILURES = 50

STYLE = """
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { font: 16px/1.5 system-ui, sans-serif; color: #1f2937; background: #f3f4f6; margin: 0; }
main { max-width: 72rem; margin: 0 auto; padding: 0 1rem 3rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 1.5rem 0 .5rem; }
h2 { font-size: 1.3rem; margin: 2.5rem 0 .75rem; padding-top: 1rem; border-top: 2px solid #d1d5db; }
h3 { font-size: 1.05rem; margin: 1.5rem 0 .25rem; }
p { margin: .25rem 0 .75rem; max-width: 60rem; }
nav a { display: inline-block; margin: 0 1rem .25rem 0; }
a { color: #0b63a5; }
.card { background: #fff; border: 1px solid #e5e7eb; border-radius: 8px; }
.card { padding: .75rem; margin: .5rem 0 1rem; }
.scroll { overflow-x: auto; -webkit-overflow-scrolling: touch; }
.figure { height: 440px; width: 100%; }
table { border-collapse: collapse; font-size: .875rem; font-variant-numeric: tabular-nums; }
th, td { padding: .35rem .6rem; text-align: right; white-space: nowrap; }
th, td { border-bottom: 1px solid #e5e7eb; }
th { font-weight: 600; color: #4b5563; vertical-align: bottom; }
th:first-child, td:first-child, .text { text-align: left; }
td:first-child { font-weight: 600; position: sticky; left: 0; background: #fff; }
.wrap { white-space: normal; min-width: 14rem; }
.note { color: #4b5563; font-size: .875rem; }
.wrong { border-left: 4px solid #b91c1c; }
.dot { display: inline-block; width: .7em; height: .7em; border-radius: 50%; margin-right: .4em; }
@media (max-width: 40rem) {
  body { font-size: 15px; }
  main { padding: 0 .6rem 2rem; }
  .figure { height: 420px; }
  .card { padding: .5rem; }
}
"""

# Nothing may be fetched: a page that tried would say so in the console.
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:"
)

DRAW = """
for (const [id, spec] of Object.entries(JSON.parse(document.getElementById("figures").textContent)))
  Plotly.newPlot(id, spec.data, spec.layout, {responsive: true, displaylogo: false,
    modeBarButtonsToRemove: ["lasso2d", "select2d"]});
"""


def page(results: Results) -> str:
    """The whole page."""
    from plotly.offline import get_plotlyjs

    figures: dict[str, charts.Spec] = {}
    numbers = count()
    body = [
        "<h1>adr-opt: the published study, again, with bounds</h1>",
        f"<p>{_overview(results)}</p>",
        _failures(results),
        "<nav>"
        + "".join(
            f'<a href="#{section.stem}">{escape(section.title)}</a>' for section in results.sections
        )
        + '<a href="#machines">Machines and versions</a></nav>',
        f'<div class="card note"><strong>What is calibrated.</strong> {escape(CALIBRATION)}</div>',
    ]
    for section in results.sections:
        body.append(f'<h2 id="{section.stem}">{escape(section.title)}</h2>')
        for title, note, spec in (
            ("Targets visited per test case", VISITS_NOTE, charts.visits(section, results.labels)),
            ("Planning time per test case", TIME_NOTE, charts.seconds(section, results.labels)),
            ("Visits against time", QUALITY_NOTE, quality.chart(section, results.labels)),
        ):
            name = f"figure-{next(numbers)}"
            figures[name] = spec
            body.append(
                f'<h3>{title}</h3><p class="note">{note}</p>'
                f'<div class="card"><div class="figure" id="{name}"></div></div>'
            )
        body.append(_means(section, results.labels))
        body.append(_beside(section, results))
        body.append(_paired(section, results.labels))
    body.append(_machines(results))
    data = json.dumps(figures, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">\n'
        '<link rel="icon" href="data:,"><title>adr-opt benchmark</title>\n'
        f"<style>{STYLE}</style></head>\n<body><main>\n"
        + "\n".join(part for part in body if part)
        + f'\n</main>\n<script type="application/json" id="figures">{data}</script>\n'
        f"<script>{get_plotlyjs()}</script>\n<script>{DRAW}</script>\n</body></html>\n"
    )


VISITS_NOTE = (
    "Means over the iterations of a field; the range of its iterations is in the label that "
    "appears at a point. Bands and dashed lines are published. Select a name below to hide it."
)
TIME_NOTE = (
    "Wall time from a ready timetable to a finished plan, on one core, logarithmic; behind each "
    "name its mean visits, without which times say little. The timetable is built once for all "
    "methods of a mission and stands below."
)
QUALITY_NOTE = (
    "Means over fields against the median time of processors, timetable included. A method that "
    "was run with several widths or limits is one curve; the table is in quality-….csv beside this "
    "page."
)


def _overview(results: Results) -> str:
    rows = sum(len(rows) for section in results.sections for rows in section.rows.values())
    failed = f", {len(results.failures)} findings below" if results.failures else ", none failed"
    return (
        f"{rows} plans, each checked from its instance alone by <code>check</code>{failed}. "
        "The same fields and the same keep-out zones for every method."
    )


def _failures(results: Results) -> str:
    if not results.failures:
        return ""
    lines = [f"<li>{escape(text)}</li>" for text in results.failures[:MOST_FAILURES]]
    if len(results.failures) > MOST_FAILURES:
        lines.append(f"<li>and {len(results.failures) - MOST_FAILURES} more</li>")
    return (
        '<div class="card wrong"><strong>What failed.</strong> A mission without a legal plan '
        f"counts as no visits.<ul>{''.join(lines)}</ul></div>"
    )


def _table(head: list[str], lines: list[list[str]], text_columns: int = 1) -> str:
    def cell(tag: str, number: int, text: str) -> str:
        return (
            f'<{tag} class="text">{text}</{tag}>'
            if number < text_columns
            else (f"<{tag}>{text}</{tag}>")
        )

    rows = [
        "<tr>" + "".join(cell("td", number, text) for number, text in enumerate(line)) + "</tr>"
        for line in lines
    ]
    titles = "".join(cell("th", number, text) for number, text in enumerate(head))
    return (
        f'<div class="card scroll"><table><thead><tr>{titles}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table></div>"
    )


def _means(section: Section, labels: dict[str, str]) -> str:
    lines = []
    for number, method in enumerate(section.rows):
        means = section.means(method)
        lines.append(
            [
                f'<span class="dot" style="background:{charts.colour(number)}"></span>'
                + escape(labels[method]),
                f"{means.visits_mean:.2f}" + _plus_minus(means.visits_half_width, 2),
                f"{means.visits_min}–{means.visits_max}",
                _gap(means),
                f"{means.optimal}" if means.bounded else "–",
                _percent(means.gap_to_best_known),
                duration(means.planning_median_s),
                duration(means.planning_max_s),
                _number(means.delta_v_m_s / 1e3, ".2f"),
                _number(means.duration_used_s / 86400.0, ".2f"),
                _number(means.refuellings, ".2f"),
                str(means.fields),
                str(means.missions),
                str(means.failed),
            ]
        )
    builds = {
        (row["field"], row["iteration"]): row["build_s"]
        for rows in section.rows.values()
        for row in rows
        if row["build_s"] is not None
    }
    build = sorted(builds.values())[len(builds) // 2] if builds else math.nan
    head = [
        "method",
        "visits, mean ± 95 %",
        "min–max",
        "gap to bound",
        "proven optimal",
        "gap to best known",
        "time, median",
        "time, max",
        "ΔV, km/s",
        "used, days",
        "refuellings",
        "fields",
        "missions",
        "failed",
    ]
    return (
        "<h3>Means</h3>"
        '<p class="note">Intervals by Student’s t over fields, each the mean of its iterations. '
        "Gap to the bound = (bound − objective) / bound, over the missions with a proven bound, "
        "their number in brackets; gap to the best known likewise: the best plan of this "
        "database, or of <code>instances/best-known.csv</code> where it lists the mission. "
        f"Timetable: median {duration(build)} for each mission, on one core.</p>"
        + _table(head, lines)
    )


def _beside(section: Section, results: Results) -> str:
    lines = []
    for text in PUBLISHED.get(section.suite, ()):
        method = next((key for key in section.rows if key.partition("@")[0] == text.method), None)
        low, high = text.visits
        stated = f"{low:g}–{high:g}" if high > low else f"{low:g}"
        if text.mean is not None and high > low:
            stated += f", mean {text.mean:g}"
        line = [text.planner, stated]
        if method is None:
            lines.append([*line, "not run", "", _seconds_range(text.seconds), "", "", ""])
            continue
        means = section.means(method)
        lines.append(
            [
                *line,
                f"{means.visits_mean:.2f}" + _plus_minus(means.visits_half_width, 2),
                f"{means.visits_min}–{means.visits_max}",
                _seconds_range(text.seconds),
                duration(means.planning_median_s),
                duration(means.with_timetable_median_s),
                _faster(text, means),
            ]
        )
    if not lines:
        return ""
    ours = "; ".join(sorted({str(row["processor"]) for row, _ in results.machines}))
    head = [
        "planner",
        "published visits",
        "ours, mean ± 95 %",
        "min–max",
        "published time",
        "ours, median",
        "with the timetable",
        "faster by (with it)",
    ]
    return (
        "<h3>Beside the published numbers</h3>"
        f'<p class="note">Published on: {escape(HARDWARE)}. Ours on one core of: {escape(ours)}, '
        "with compiled code and a timetable made beforehand. Different machines, languages and "
        "fields: only the order of magnitude can be compared. The study gives numbers for its own "
        "zones, which it does not describe; “what is calibrated” above says the rest.</p>"
        + _table(head, lines)
    )


def _paired(section: Section, labels: dict[str, str]) -> str:
    values = {method: section.visits(method) for method in section.rows}
    order = sorted(values, key=lambda key: -section.means(key).visits_mean)
    compared = pairs({key: values[key] for key in order})
    lines = [
        [
            escape(labels[str(pair.first)]),
            escape(labels[str(pair.second)]),
            str(pair.fields),
            f"{pair.difference:+.2f}" + _plus_minus(pair.half_width, 2),
            f"{pair.better} / {pair.equal} / {pair.worse}",
            _p(pair.p, pair.fields),
        ]
        for pair in compared
    ]
    if not lines:
        return ""
    few = any(pair.p is None for pair in compared)
    head = ["method", "minus", "fields", "visits, mean ± 95 %", "better / equal / worse", "p"]
    return (
        "<h3>Paired differences</h3>"
        '<p class="note">Over the missions that both methods have, averaged within each field. '
        "p: Wilcoxon’s signed-rank test by field, two-sided and exact, adjusted by Holm over this "
        f"table. {_too_few(len(compared)) if few else ''}</p>" + _table(head, lines, 2)
    )


def _too_few(together: int) -> str:
    """Why a p is missing."""
    needed = fields_needed(together)
    return (
        "A paired test on n fields cannot give less than 2<sup>−(n−1)</sup>, and adjusted over "
        f"{together} pairs not less than {together} times that: with fewer than {needed} fields "
        "none could be at most 0.05 whatever the plans are, so none is given."
    )


def _machines(results: Results) -> str:
    machines = [
        [
            escape(str(row["host"])),
            str(number),
            escape(str(row["processor"])),
            str(row["cores"]),
            escape(str(row["python"])),
            escape(str(row["versions"])),
        ]
        for row, number in results.machines
    ]
    return '<h2 id="machines">Machines and versions</h2>' + _table(
        ["host", "rows", "processor", "cores", "Python", "versions"], machines
    )


def duration(seconds: float) -> str:
    """A duration with a unit that suits it."""
    if math.isnan(seconds):
        return "–"
    if seconds < 1.0:
        return f"{1e3 * seconds:.3g} ms"
    return f"{seconds:.3g} s" if seconds < 1000.0 else f"{seconds:,.0f} s"


def _seconds_range(limits: tuple[float, float] | None) -> str:
    return "–" if limits is None else f"{limits[0]:,.0f}–{limits[1]:,.0f} s"


def _faster(text: Published, means: Means) -> str:
    """Orders of magnitude between the published time and ours, and between which visits that is."""
    if text.seconds is None or not means.with_timetable_median_s > 0.0:
        return "–"
    middle = math.sqrt(text.seconds[0] * text.seconds[1])
    powers = [
        round(math.log10(middle / ours))
        for ours in (means.planning_median_s, means.with_timetable_median_s)
    ]
    alone, whole = (f"10<sup>{power}</sup>" if power else "1" for power in powers)
    low, high = text.visits
    theirs = f"{low:g}–{high:g}" if high > low else f"{low:g}"
    return f"{alone} ({whole}), at {means.visits_mean:.1f} visits against {theirs}"


def _plus_minus(half: float, digits: int) -> str:
    return "" if math.isnan(half) else f" ± {half:.{digits}f}"


def _percent(share: float) -> str:
    return "–" if math.isnan(share) else f"{100.0 * share:.2f} %"


def _number(value: float, form: str) -> str:
    return "–" if math.isnan(value) else f"{value:{form}}"


def _gap(means: Means) -> str:
    return f"{_percent(means.gap_to_bound)} ({means.bounded})" if means.bounded else "–"


def _p(p: float | None, fields: int) -> str:
    if p is None:
        return f"n = {fields}: not below {least_p(fields):.2g}"
    return "&lt; 0.0001" if p < 1e-4 else f"{p:.4f}"
