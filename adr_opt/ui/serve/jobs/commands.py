"""Command lines of jobs, on files of the project named from its folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from ....analysis.trade.axes import KINDS
from ....common.errors import InputError
from ..forms.options import words_of
from ..objects.dropped import DroppedObjects
from ..project.plan_files import FIELD, INSTANCE, PLAN
from ..project.record import ResultRecord
from ..requests import JobRequest
from ..session import EditingSession
from .verbs import VERBS, JobVerb, unsure

REFINED, CERTIFICATE = "refined.json", "certificate.json.gz"

MOST_STARTS = 10
"""Number of plans that are there already from which a trade-off starts."""

NO_CERTIFICATE = "there is no certificate for this plan; prove a bound with one first"


class JobCommand(NamedTuple):
    """The command of a job.

    Attributes
    ----------
    words : list of str
        Verb, files and options.
    inputs : tuple of int
        Results that it reads.
    instance_sha256 : str or None
        Of the instance that it is about.
    """

    words: list[str]
    inputs: tuple[int, ...] = ()
    instance_sha256: str | None = None


class JobInputs:
    """Files of the project that verbs read.

    Parameters
    ----------
    session : EditingSession
    dropped : DroppedObjects
    """

    def __init__(self, session: EditingSession, dropped: DroppedObjects) -> None:
        self._session, self._dropped = session, dropped
        self._folder = session.folder.path

    def check(self, request: JobRequest) -> None:
        """Refuse, before anything is made, what :meth:`command` refuses.

        Raises
        ------
        InputError
            As of it.
        """
        verb = _verb(request)
        words_of(verb.options, request.options)
        self._files(verb, request, None)

    def command(self, request: JobRequest, place: Path) -> JobCommand:
        """The command line of a job.

        Parameters
        ----------
        request : JobRequest
        place : path
            Folder of its result; the draft is written there where the verb reads it.

        Raises
        ------
        InputError
            There is no such verb or option, or what it needs is not there.
        """
        verb = _verb(request)
        options = words_of(verb.options, request.options)
        read = self._files(verb, request, place)
        outputs = [
            f"{each.sign}={self._named(place / each.file.format_map(_values(verb, request)))}"
            for each in verb.outputs
            if each.asked_by is None or request.options.get(each.asked_by)
        ]
        if request.verb == "tradeoff":
            of_designs = _of_designs(request)
            outputs.append(
                f"--out={self._named(place / ('points.jsonl' if of_designs else 'points.csv'))}"
            )
        return read._replace(words=[request.verb, *read.words, *options, *outputs, "--json"])

    def _files(self, verb: JobVerb, request: JobRequest, place: Path | None) -> JobCommand:
        """Files that a verb reads, and the results to which they belong."""
        given = [self._session.results.record(number) for number in request.results]
        if verb.needs == ("mission",):
            return self._mission(place)
        if verb.needs == ("instance",):
            return self._draft(place, request)
        if verb.needs == ("catalogue",):
            return JobCommand(self._catalogue())
        plans = self._plans(given, 2 if "plans" in verb.needs else 1)
        files = [self._of(plans[0], INSTANCE)]
        refined = [record for record in given if REFINED in record.files]
        if "refined" in verb.needs:
            refined = [self._made_of(plans[0], given, REFINED, "refine the plan first")]
        if {"plan or refined", "refined"} & {*verb.needs} and refined:
            files.append(self._of(refined[0], REFINED))
        else:
            files += [self._of(record, PLAN) for record in plans]
        used = [*plans]
        if request.verb == "report" and refined:
            files.append(f"--refined={self._of(refined[0], REFINED)}")
        if refined and request.verb in ("report", "fly", "export", "screen"):
            used.append(refined[0])
        if "catalogue" in verb.needs:
            files += [*self._objects(), "--skip-bad", *self._errors()]
        if "certificate" in verb.needs:
            certificate = self._made_of(plans[0], given, CERTIFICATE, NO_CERTIFICATE)
            files.append(self._of(certificate, CERTIFICATE))
            used.append(certificate)
        if "uncertainty" in verb.needs:
            files.append(f"--uncertainty={self._uncertainty(request, place)}")
        numbers = tuple(dict.fromkeys(record.number for record in used))
        return JobCommand(files, numbers, plans[0].instance_sha256)

    def _plans(self, given: list[ResultRecord], least: int) -> list[ResultRecord]:
        """The plans among the given results; else the plan that was refined, or the shown one."""
        results = self._session.results
        plans = [record for record in given if record.has_plan]
        for record in given:
            if not plans and record.inputs and REFINED in record.files:
                plans = [results.record(record.inputs[0])]
        shown = self._session.shown()
        if not plans and shown is not None:
            plans = [results.record(shown[0])]
        if len(plans) < least:
            raise InputError("plan first" if least == 1 else f"choose at least {least} plans")
        return plans if least > 1 else plans[:1]

    def _draft(self, place: Path | None, request: JobRequest) -> JobCommand:
        """The file of the edited instance: that of one of its plans, or a new one."""
        instance = self._session.instance()
        known = self._session.results.newest_of(instance.sha256)
        plans = request.verb == "solve"  # whose result is a plan with its instance
        more = ["--refine", *self._around(request)] if plans else []
        if known is not None and not plans:
            file = self._of(self._session.results.record(known), INSTANCE)
            if request.verb == "tradeoff" and not _of_designs(request):
                there = self._session.results.legal_of(instance.sha256)[:MOST_STARTS]
                starts = [f"--start={self._of(record, PLAN)}" for record in there]
                numbers = tuple(sorted(record.number for record in there))
                return JobCommand([file, *starts], numbers or (known,), instance.sha256)
            return JobCommand([file], (known,), instance.sha256)
        if place is not None:
            instance.save(place / INSTANCE)
        file = self._named((place or self._folder) / INSTANCE)
        return JobCommand([file, *more], (), instance.sha256)

    def _mission(self, place: Path | None) -> JobCommand:
        """The mission as edited with all its targets, before windows were found for it."""
        field = self._session.without_found_windows()
        if place is not None:
            field.save(place / FIELD)
        own = self._dropped.latest("ground stations")
        more = [] if own is None else [f"--stations={self._named(own)}"]
        return JobCommand([self._named((place or self._folder) / FIELD), *more], (), field.sha256)

    def _around(self, request: JobRequest) -> list[str]:
        if not request.options.get("around"):
            return []
        return [*(f"--screen={file}" for file in self._objects()), *self._errors()]

    def _objects(self) -> list[str]:
        files = [self._named(path) for path in self._dropped.of("catalogue")]
        if not files:
            raise InputError("there is no catalogue; drop a TLE or OMM file first")
        return files

    def _errors(self) -> list[str]:
        errors = self._dropped.latest("errors")
        return [] if errors is None else [f"--errors={self._named(errors)}"]

    def _catalogue(self) -> list[str]:
        satcat = self._dropped.latest("satcat")
        more = [] if satcat is None else [f"--satcat={self._named(satcat)}"]
        return [*self._objects(), *more, "--skip-bad"]

    def _made_of(
        self, plan: ResultRecord, given: list[ResultRecord], file: str, without: str
    ) -> ResultRecord:
        """The result with a file made from a plan: among the given ones, or else the latest."""
        for record in (*given, *reversed(self._session.results.all())):
            of_plan = plan.number in (record.number, *record.inputs) or file == CERTIFICATE
            if file in record.files and record.instance_sha256 == plan.instance_sha256 and of_plan:
                return record
        raise InputError(without)

    def _uncertainty(self, request: JobRequest, place: Path | None) -> str:
        """The dropped uncertainty file, or one with the values of the form."""
        path = self._dropped.latest("uncertainty")
        if path is None:
            path = (place or self._folder) / "uncertainty.json"
            if place is not None:
                unsure(request.options).save(path)
        return self._named(path)

    def _of(self, record: ResultRecord, file: str) -> str:
        return self._named(self._session.results.place(record.number) / file)

    def _named(self, path: Path) -> str:
        return str(path.relative_to(self._folder))


def _values(verb: JobVerb, request: JobRequest) -> dict[str, Any]:
    """Options of a request, with the defaults of others."""
    return {option.name: option.default for option in verb.options} | request.options


def _verb(request: JobRequest) -> JobVerb:
    if request.verb not in VERBS:
        raise InputError(
            f"verb {request.verb[:40]!r} is not offered here; use one of: {', '.join(VERBS)}"
        )
    return VERBS[request.verb]


def _of_designs(request: JobRequest) -> bool:
    varied = [
        str(request.options.get(name) or "").partition("=")[0] for name in ("vary", "vary_too")
    ]
    priced = any(
        request.options.get(f"{name}_cost_eur") is not None for name in ("launch", "kit", "kg")
    )
    return priced or any(name in KINDS and KINDS[name].of_designs for name in varied)
