"""Prints python/machband/stimuli.py, a typed function for each kind of stimulus, from what the installed package says."""

import re
import textwrap

import machband

HEAD = '''"""A function for each kind of stimulus, which returns a `machband.Stimulus`.

Written by scripts/generate_stimuli.py; do not edit.
"""

# ruff: noqa: E501

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypedDict

from ._common import suggests
from ._stimulus import Stimulus

__all__ = {names!r}

Shader = {shaders}
Shape = {shapes}
'''

VIEW = {
    "size": ("int | tuple[int, int] | None", "Side in pixels, or height and width, as in `machband.Stimulus`."),
    "ppd": ("float | None", "Pixels per degree of visual angle."),
    "visual_size": (
        "float | tuple[float, float] | None",
        "Degrees of visual angle of the longer side, or height and width [default: `size` / `ppd`, or 10].",
    ),
}


#: Types with names, which `machband.shade` has too.
NAMED = {("shaded-mesh", "shader"): "Shader", ("shaded-mesh", "mesh"): "Shape"}


def choices(parameter):
    """Return the type of a parameter that has a few names as values."""
    return f"Literal[{', '.join(map(repr, parameter.choices))}]".replace("'", '"')


def type_of(kind, parameter):
    """Return the type of a parameter of a kind of stimulus."""
    if parameter.choices:
        return NAMED.get((kind, parameter.name)) or choices(parameter)
    if isinstance(parameter.default, str):
        return "str | Sequence[float]"
    try:
        machband.Stimulus(kind, size=1, **{parameter.name: "inf"})
    except machband.Error:
        return "float"
    return 'float | Literal["inf"]'


def expected_of(kind, parameter):
    """Return what a parameter can be, with the range that the error for a huge number names."""
    try:
        machband.Stimulus(kind, size=1, **{parameter.name: 1e9})
    except machband.Error as error:
        found = re.search(r" is outside (\S+)…(\S+);", str(error))
        if found and not all(end in parameter.expected for end in found.groups()):
            ends = " to ".join(found.groups())
            is_told = parameter.expected.removeprefix("the ") in parameter.description.lower()
            return ends if is_told else f"{parameter.expected}, {ends}"
    return parameter.expected


def default_of(parameter):
    """Return a default as Python writes it."""
    default = parameter.default
    whole = isinstance(default, float) and default.is_integer()
    return repr(int(default) if whole else default).replace("'", '"')


def parameters():
    """Return the source of a dict of the parameters of all kinds."""
    types = {}
    for kind in machband.kinds():
        for name, one in machband.parameters(kind).items():
            types.setdefault(name, []).append(type_of(kind, one))
    # The widest type is the longest.
    fields = [f"    {name}: {max(found, key=len)}" for name, found in types.items()]
    about = '    """The parameters of all kinds of stimulus."""'
    return "\n".join(["", "", "class Parameters(TypedDict, total=False):", about, "", *fields])


def function(kind, about):
    """Return the source of a function."""
    known = machband.parameters(kind)
    arguments = [f"    {name}: {type_of(kind, one)} = {default_of(one)}," for name, one in known.items()]
    arguments += [f"    {name}: {type} = None," for name, (type, _) in VIEW.items()]
    texts = {name: f"{one.description}. Expected: {expected_of(kind, one)}." for name, one in known.items()}
    texts |= {name: said for name, (_, said) in VIEW.items()}
    described = []
    for name, said in texts.items():
        described += [f"    {name}", *textwrap.wrap(said, 112, initial_indent=" " * 8, subsequent_indent=" " * 8)]
    given = ", ".join(f"{name}={name}" for name in texts)
    return "\n".join([
        "", "", "@suggests", f"def {kind.replace('-', '_')}(", "    *,", *arguments, ") -> Stimulus:",
        *textwrap.wrap(f'"""{about.rstrip(".")}.', 116, initial_indent="    ", subsequent_indent="    "),
        "", "    Parameters", "    ----------", *described, '    """',
        *textwrap.wrap(f'return Stimulus("{kind}", {given})', 116, initial_indent="    ", subsequent_indent=" " * 8),
    ])


kinds = machband.kinds()
mesh = machband.parameters("shaded-mesh")
names = sorted(kind.replace("-", "_") for kind in kinds)
head = HEAD.format(names=names, shaders=choices(mesh["shader"]), shapes=choices(mesh["mesh"]))
print(head.replace("'", '"'), end="")
print(parameters())
print("\n".join(function(kind, about) for kind, about in kinds.items()))
