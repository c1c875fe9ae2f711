"""Fields of forms, from the JSON Schema of the instance."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any, get_args

from ....problem.instance import json_schema
from ..drafts import Part
from .words import NOT_EDITED, VARIANTS, WORDS, unit_of

Schema = dict[str, Any]

OF_TARGETS = ("window_s", "removal", "mass_kg")
"""Fields of targets in a form, beside prize and requirement, which stand in their table."""

KINDS = {
    "number": "number",
    "integer": "number",
    "string": "text",
    "boolean": "flag",
    "array": "list",
}
"""Kinds of fields by types of the schema."""


@cache
def form_fields() -> list[dict[str, Any]]:
    """Fields of all parts that forms edit, as JSON data.

    Each has ``part``, ``path`` (names between points, within a chaser or a station for those
    parts), ``label``, ``unit``, ``kind``, ``least``, ``most``, ``default``, ``help``,
    ``optional`` (whether null is allowed), ``whole`` (of a number), ``choices`` (of a choice), and
    ``of``, the choice to which a field belongs: ``[PATH, VALUE]``, or null.
    """
    schema = json_schema()
    found: list[dict[str, Any]] = []
    for part in get_args(Part):
        content = _resolved(schema["properties"][part], schema)
        if content.get("type") == "array":
            content = _resolved(content["items"], schema)
        found += [{"part": part, **field} for field in _inside(content, schema, "", None)]
    dynamics = _field(schema["properties"]["dynamics"], schema, "dynamics", None, must=True)
    target = schema["$defs"]["Target"]["properties"]
    services = [
        field
        for name in OF_TARGETS
        for field in _field(target[name], schema, name, None, must=True)
    ]
    return [
        *found,
        *({"part": "dynamics", **field} for field in dynamics),
        *({"part": "targets", **field} for field in services),
    ]


def _inside(
    content: Schema, schema: Schema, path: str, of: list[str] | None
) -> Iterator[dict[str, Any]]:
    """Fields of an object."""
    required = content.get("required", ())
    for name, inner in content["properties"].items():
        if name not in NOT_EDITED:
            yield from _field(inner, schema, f"{path}{name}", of, must=name in required)


def _field(
    content: Schema, schema: Schema, path: str, of: list[str] | None, *, must: bool
) -> Iterator[dict[str, Any]]:
    """A field, or those within it."""
    several: list[Schema] = content.get("anyOf") or content.get("oneOf") or []
    kinds = [_resolved(each, schema) for each in several]
    kept = [each for each in kinds if each.get("type") != "null"]
    optional = len(kept) < len(kinds)
    default = content.get("default")
    if len(kept) > 1:
        names = [_variant(each) for each in kept]
        yield _told(path, "choice", of, default=default, optional=False, choices=names)
        for name, each in zip(names, kept, strict=True):
            if "properties" in each:
                yield from _inside(each, schema, f"{path}.", [path, name])
        return
    inner = _resolved(kept[0] if kept else content, schema)
    if "properties" in inner:
        if optional or not must:
            yield _told(path, "choice", of, default=None, optional=True, choices=["given"])
            of = [path, "given"]
        yield from _inside(inner, schema, f"{path}.", of)
        return
    limits = {
        "least": inner.get("minimum", inner.get("exclusiveMinimum")),
        "most": inner.get("maximum", inner.get("exclusiveMaximum")),
    }
    whole = {"whole": True} if inner.get("type") == "integer" else {}
    if "enum" in inner:
        yield _told(path, "choice", of, default=default, optional=optional, choices=inner["enum"])
    else:
        kind = KINDS[inner["type"]]
        yield _told(path, kind, of, default=default, optional=optional, **limits, **whole)


def _told(path: str, kind: str, of: list[str] | None, **more: Any) -> dict[str, Any]:
    name = path.rpartition(".")[2]
    words = WORDS[name]
    return {
        "path": path,
        "label": words.label,
        "unit": unit_of(name),
        "kind": kind,
        "least": None,
        "most": None,
        "help": words.help,
        "of": of,
        **more,
    }


def _variant(content: Schema) -> str:
    """What a form calls one of several kinds: a word, its only name, or as :data:`VARIANTS`."""
    if "const" in content:
        return str(content["const"])
    return VARIANTS.get(content["title"]) or next(iter(content["properties"]))


def _resolved(content: Schema, schema: Schema) -> Schema:
    reference = content.get("$ref")
    if reference is None:
        return content
    found: Schema = schema["$defs"][reference.rpartition("/")[2]]
    return found
