"""Claims of peers, and the packages they come in."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from types import ModuleType

from adr_opt.common.errors import MissingExtra


def need(package: str) -> ModuleType:
    """Import an optional package.

    Raises
    ------
    MissingExtra
        It is not installed.
    """
    try:
        return import_module(package)
    except ImportError:
        raise MissingExtra("comparing with the peers", package, "peers") from None


def packages(*names: str) -> str:
    """Versions of the peers, for the heading."""
    found = []
    for name in names:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            found.append(f"{name} not installed")
    return ", ".join(found)


@dataclass(frozen=True)
class Promise:
    """Claims of a peer.

    Attributes
    ----------
    routes : tuple of tuple of int
        Bodies in order for each chaser, stations for refuelling.
    visits : float
        Prizes that the peer's model collects.
    bound : float
        The peer's bound on its own model; +inf for none.
    build_s, solve_s : float
        Wall times [s].
    history : tuple of (float, float)
        Seconds since the beginning of the search, and the bound proven by then.
    """

    routes: tuple[tuple[int, ...], ...]
    visits: float
    bound: float
    build_s: float
    solve_s: float
    history: tuple[tuple[float, float], ...] = ()

    @property
    def order(self) -> tuple[int, ...]:
        """Those of the one chaser."""
        (order,) = self.routes
        return order
