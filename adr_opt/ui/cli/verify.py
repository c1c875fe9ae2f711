"""``verify``: verify a plan's quality by its certificate."""

from __future__ import annotations

import math

import click

from ...common.errors import InputError
from ...common.wording import counted
from . import complete, param
from .output import emit, emit_json
from .parameters import about, check_out

MOST_CONNECTIONS = 1_000_000
"""Default of :mod:`adr_opt.judge.verify`, repeated as that module takes long to import."""


TOLD = (
    "verified",
    "upper_bound",
    "objective",
    "gap",
    "labels",
    "legs",
    "connections",
    "departures",
    "cost_bound",
    "reasons",
)
"""Fields of a verdict printed by --json under the same names."""


@click.command("verify", short_help="Recompute the bound of CERTIFICATE, and judge PLAN by it.")
@param.instance
@click.argument("paths", metavar="[PLAN] CERTIFICATE", nargs=-1, shell_complete=complete.files)
@click.option(
    "--connections",
    type=click.IntRange(0, MOST_CONNECTIONS),
    metavar="N",
    help="Number of connections to fly again by the physics of 'check'; default 1000.",
)
@click.option(
    "--seed", type=click.IntRange(0), default=0, help="Seed for choosing them; default 0."
)
@param.file("--labels", "Closed labels to check, in place of a search for them.")
@param.file("--save-labels", "Closed labels to write, for --labels.")
@param.as_json
def command(
    instance_path: str,
    paths: tuple[str, ...],
    connections: int | None,
    seed: int,
    labels: str | None,
    save_labels: str | None,
    as_json: bool,
) -> int:
    """Recompute the bound of CERTIFICATE for INSTANCE, and judge PLAN by it.

    A separate program does so, which shares only the connections with planners and proofs.
    Without PLAN, the bound alone is verified. Ctrl-C ends it at once. Exit status 1: refused.
    """
    if not 1 <= len(paths) <= 2:
        raise InputError(
            "give an instance, a certificate and, between them, a plan if it is judged"
        )
    from ...judge.admit import admit
    from ...judge.verify import verify
    from ...judge.verify.verdict import CONNECTIONS
    from ...plan.certificate import Certificate
    from ...plan.plan import Plan
    from ...problem.instance import load
    from .bars import wanted
    from .work import attend

    check_out(save_labels, instance_path, *paths, labels)
    instance = load(instance_path)
    plan = Plan.load(paths[0]) if len(paths) == 2 else None
    path = paths[-1]
    read = Certificate.load(path)
    tried = CONNECTIONS if connections is None else connections
    with about(path):
        certificate = admit(instance, read).plan
    if plan is not None:
        with about(paths[0]):
            plan.instance.refuse_other(instance)
    verdict = attend(
        lambda: verify(
            instance,
            plan,
            certificate,
            seed=seed,
            connections=tried,
            labels=labels,
            save_labels=save_labels,
        ),
        "verifying",
        live=wanted(as_json, quiet=False),
    )
    if as_json:
        told = {name: getattr(verdict, name) for name in TOLD}
        emit_json({"instance": instance.name, **told})
        return 0 if verdict.verified else 1
    if verdict.upper_bound == -math.inf:
        proven = "no plan keeps all rules"
    elif math.isfinite(verdict.upper_bound):
        proven = f"no plan collects more than {verdict.upper_bound:.15g}"
    else:
        proven = "nothing was proven"
    for reason in verdict.reasons:
        emit(f"{path}: refused: {reason}")
    effort = counted(verdict.legs, "leg") if verdict.legs else counted(verdict.labels, "label")
    emit(f"{path}: {'verified: ' if verdict.verified else ''}{proven} ({effort})")
    if verdict.connections:
        emit(
            f"  {counted(verdict.connections, 'connection')} flown again; better ones "
            f"searched at {counted(verdict.departures, 'departure')}"
        )
    if plan is None and certificate.plan_sha256 is not None:
        emit("  unjudged: the plan to which it belongs, which is not given")
    if verdict.verified and plan is not None:
        if verdict.gap is not None:
            emit(f"  the plan collects {plan.objective:.15g}: {_judged(verdict.gap)}")
        if verdict.cost_bound is not None:
            emit(f"  no plan that collects as much costs less than {verdict.cost_bound:.6g} m/s")
        elif plan.cost_bound is not None:
            emit("  the bound on cost is not in the certificate, and was not verified")
    return 0 if verdict.verified else 1


def _judged(gap: float) -> str:
    return "optimal" if gap <= 0.0 else f"at most {100.0 * gap:.2f} % less than the best"
