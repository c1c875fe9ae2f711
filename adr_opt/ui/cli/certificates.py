"""``--certificate``: write the evidence for a plan or a bound."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ...common.errors import InputError
from . import param
from .output import say
from .parameters import check_out

if TYPE_CHECKING:
    from ...mission.result import Result
    from ...problem.instance import Instance

certificate_option = param.file(
    "--certificate",
    "Certificate file to write, for 'verify'; FILE.gz is compressed.",
    name="certificate_path",
)


def check_certificate(
    path: str | None,
    instance: Instance,
    method: str,
    bound: str | None,
    *inputs: str | None,
    margin: float,
    out: str | None = None,
    refine: bool = False,
    group: str | None = None,
) -> None:
    """Raise :class:`InputError` in advance if no certificate is possible.

    Parameters
    ----------
    path : str or None
        Where it is to be written; None for nowhere.
    instance : Instance
    method : str
    bound : str or None
        The bound that runs beside it.
    *inputs : str or None
        Files that are read.
    margin : float
    out : str or None
        Where else something is written.
    refine : bool
    group : str, optional
        Entry points of the method; those of planners by default.
    """
    from ...judge.verify.rules import FOLLOWS
    from ...problem.support import refuse
    from ...run.methods import BOUNDS, PLANNERS, names, spec

    if path is None:
        return
    check_out(path, *inputs, results=(out,))
    if margin or refine:
        what = "--margin" if margin else "--refine"
        raise InputError(
            f"--certificate: with {what} nothing is proven about the instance itself; leave out one"
        )
    group = group or PLANNERS
    able = spec(method, group).shows_evidence or (
        bound is not None and spec(bound, BOUNDS).shows_evidence
    )
    if not able:
        known = [name for name in names(group) if spec(name, group).shows_evidence]
        raise InputError(
            f"--certificate: {method!r} gives no evidence for its bound; use one of: "
            f"{', '.join(known)}"
        )
    refuse(instance, FOLLOWS)


def save_certificate(
    path: str, instance: Instance, result: Result, quiet: bool, *, plan: bool = True
) -> None:
    """Write the certificate of a result.

    Parameters
    ----------
    plan : bool
        Whether it goes with the plan of the result; if not, it is that of the bound alone.

    Raises
    ------
    InputError
        Nothing was proven, or it cannot be written.
    """
    from ...mission.certify import certificate_of
    from ...mission.prizes import Prizes

    certificate = certificate_of(instance, result if plan else replace(result, plan=None))
    certificate.save(path)
    if quiet:
        return
    bound = certificate.upper_bound
    shown = "there is no plan" if bound is None else f"upper bound {bound:.15g}"
    say(f"wrote {path}: {shown}")
    prizes = Prizes(instance)
    proven = prizes.rounded_down(result.upper_bound)
    if bound is not None and not prizes.meets(proven, bound):
        say(
            f"note: the certificate is that of the bound before the last step of the proof, which "
            f"packs routes and proves {result.upper_bound:.15g}"
        )
