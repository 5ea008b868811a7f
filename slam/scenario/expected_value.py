"""Descriptions of the expected value, in the terms of scenario files."""

from collections.abc import Iterator
from itertools import count
from reprlib import Repr
from typing import Any, Final, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic_core import ErrorDetails

from slam.errors import did_you_mean
from slam.named_code import PLACE

_PLAIN: Final[dict[str, str]] = {
    "float_type": "a number", "float_parsing": "a number", "finite_number": "a finite number",
    "int_type": "a whole number", "int_parsing": "a whole number", "int_parsing_size": "a whole number",
    "int_from_float": "a whole number", "bool_type": "true or false", "bool_parsing": "true or false",
    "string_type": "text", "string_unicode": "text",
    "greater_than": "a number greater than {gt}", "greater_than_equal": "a number of at least {ge}",
    "less_than": "a number less than {lt}", "less_than_equal": "a number of at most {le}",
    "literal_error": "{expected}",
}  # fmt: skip
"""Expected values by the type of pydantic's error, with the fields of its context."""
_PATTERNS: Final = {
    PLACE: "module:name, such as my_lines:split",
    r"^[A-Za-z0-9][A-Za-z0-9._ -]*$": "letters, digits, spaces and any of . _ -, with a letter or a digit first",
}
_PLURALS: Final[dict[Any, str]] = {
    float: "numbers", int: "whole numbers", str: "texts", bool: "values true or false", Any: "values",
}  # fmt: skip
_short: Final = Repr()
_short.maxlevel, _short.maxstring, _short.maxother = 3, 60, 60


def describe_expected(error: ErrorDetails, annotation: Any) -> str:
    """Describe the value of that annotation: ``expected a list of 2 numbers, like [1, 2] (got [1])``."""
    kind, value = error["type"], error["input"]
    if kind == "missing":
        return "this key is missing"
    if kind == "value_error":
        words = error["msg"].removeprefix("Value error, ")
        return words if isinstance(value, str) and value and value in words else _with_value(words, value)
    return _with_value(_words(kind, error.get("ctx", {}), annotation) or error["msg"], value, _meant(value, annotation))


def is_fixed_list(annotation: Any) -> bool:
    """Return True for a list with a fixed number of items."""
    return get_origin(annotation) is tuple and Ellipsis not in get_args(annotation)


def bare_annotation(annotation: Any) -> Any:
    """Strip an annotation of ``Annotated`` and ``| None``, at every depth of lists."""
    arguments = get_args(annotation)
    if hasattr(annotation, "__metadata__"):
        return bare_annotation(arguments[0])
    if get_origin(annotation) is tuple:
        return tuple[tuple(item if item is Ellipsis else bare_annotation(item) for item in arguments)]  # type: ignore[misc]
    if type(None) in arguments:
        return bare_annotation(next(argument for argument in arguments if argument is not type(None)))
    return annotation


def _words(kind: str, context: dict[str, Any], annotation: Any) -> str | None:
    if kind in _PLAIN:
        numbers = {key: f"{value:g}" if isinstance(value, float) else value for key, value in context.items()}
        return f"expected {_PLAIN[kind].format(**numbers)}"
    if kind == "string_pattern_mismatch" and context["pattern"] in _PATTERNS:
        return f"expected {_PATTERNS[context['pattern']]}"
    if kind in {"tuple_type", "list_type", "too_short", "too_long"}:
        return f"expected {_list_of(annotation, context)}"
    if kind in {"model_type", "model_attributes_type", "dict_type"}:
        return f"expected {_section_of(annotation)}"
    return None


def _with_value(words: str, value: Any, meant: str = "") -> str:
    """Append the given value, shortened, unless it is a mapping."""
    given = "" if isinstance(value, dict) else f"got {_short.repr(value)}"
    notes = "; ".join(filter(None, (given, meant)))
    return f"{words} ({notes})" if notes else words


def _meant(value: Any, annotation: Any) -> str:
    """Suggest the most similar word of a choice, or explain how a number becomes text."""
    if annotation is str and isinstance(value, int | float):
        return "put it in quotes"
    known = [choice for choice in get_args(annotation) if isinstance(choice, str)]
    return did_you_mean(value, known, otherwise="") if isinstance(value, str) else ""


def _section_of(annotation: Any) -> str:
    if not (isinstance(annotation, type) and issubclass(annotation, BaseModel)):
        return "a section of settings"
    first, *others = annotation.model_fields
    return f"a section with keys such as {', '.join([first, *others[:2]])}"


def _list_of(annotation: Any, context: dict[str, Any]) -> str:
    """Describe the list that is expected; a list of numbers with an example."""
    if get_origin(annotation) is not tuple:
        return "a list"
    least, most = context.get("min_length", 1), context.get("max_length")
    bounded = not is_fixed_list(annotation) and ("min_length" in context or most is not None)
    bound = "" if not bounded else f"{least} or more " if most is None else f"{most} or fewer "
    example = _example(annotation, least, count(1))
    words = f"a list of {bound}{_items(annotation)}"
    return words if example is None else f"{words}, like {example}"


def _items(annotation: Any) -> str:
    """Describe the items, as in ``2 numbers`` or ``lists of 2 numbers``."""
    items = get_args(annotation)
    return _plural(items[0]) if Ellipsis in items else f"{len(items)} {_plural(items[0])}"


def _plural(annotation: Any) -> str:
    if get_origin(annotation) is tuple:
        return f"lists of {_items(annotation)}"
    if get_origin(annotation) is Literal:
        return "names"
    return _PLURALS.get(annotation, "sections")


def _example(annotation: Any, least: int, numbers: Iterator[int]) -> str | None:
    """Write a list of that shape; None for items other than numbers."""
    if annotation in (float, int):
        return str(next(numbers))
    if get_origin(annotation) is not tuple:
        return None
    items = get_args(annotation)
    parts = [_example(item, 2, numbers) for item in (items[:1] * max(least, 2) if Ellipsis in items else items)]
    return None if None in parts else f"[{', '.join(filter(None, parts))}]"
