"""From syntax tree to canonical lines: equal trees have equal lines, and they read back."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from hashlib import sha256

from ntp_dsl.language import syntax
from ntp_dsl.language.layout import STEP, Row
from ntp_dsl.language.syntax import Expression, Number

INDENT = " " * STEP


def hash_declaration(declaration: syntax.Declaration) -> str:
    """What the declaration means, in 16 hexadecimal digits; docstrings and layout do not count."""
    rows = declaration_rows(replace(declaration, docstring=""))
    text = "\n".join(" " * row.indent + row.text for row in rows)
    return sha256(text.encode()).hexdigest()[:16]


def header_rows(library: syntax.Library) -> list[Row]:
    """`library NAME`, and what is said about it."""
    return [Row(0, f"library {library.name}"), *_docstring(library.docstring, 0)]


def use_row(use: syntax.Use) -> Row:
    return Row(0, f"use {use.library}")


def declaration_rows(declaration: syntax.Declaration) -> list[Row]:
    """One declaration, a row for each clause, section, loop and call."""
    for kind, formatter in FORMATTERS.items():
        if isinstance(declaration, kind):
            first, *rest = formatter(declaration)
            below = [Row(STEP + len(line) - len(line.lstrip()), line.lstrip()) for line in rest]
            return [Row(0, first), *_docstring(declaration.docstring, STEP), *below]
    raise AssertionError(f"no layout for a {type(declaration).__name__}")


def _docstring(text: str, indent: int) -> list[Row]:
    if not text:
        return []
    first, *rest = text.split("\n")
    lines = [f'"""{first}', *rest]
    if rest or text.endswith('"'):
        lines.append('"""')
    else:
        lines[0] += '"""'
    return [Row(indent, "\n".join(lines))]


# Declarations: the first line stands at the margin, the others are indented below it ------------


def _type(declaration: syntax.TypeDeclaration) -> list[str]:
    parent = f" is {format_type(declaration.parent)}" if declaration.parent else ""
    return [f"type {declaration.name}{parent}"]


def _enum(declaration: syntax.EnumDeclaration) -> list[str]:
    return [f"enum {declaration.name}: {', '.join(declaration.members)}"]


def _record(declaration: syntax.RecordDeclaration) -> list[str]:
    return [f"record {declaration.name}{_parameters(declaration.fields)}"]


def _constant(declaration: syntax.ConstantDeclaration) -> list[str]:
    return [f"constant {declaration.name}: {format_type(declaration.type)}"]


def _predicate(declaration: syntax.PredicateDeclaration) -> list[str]:
    head = f"predicate {declaration.name}{_parameters(declaration.parameters)}"
    if declaration.body is not None:
        return [f"{head}:", format_expression(declaration.body)]
    return [f"{head}{_result(declaration.result)}{_by(declaration.by)}"]


def format_signature(declaration: syntax.PredicateDeclaration) -> str:
    """`drink(cup: Cup) -> Drink`."""
    return f"{declaration.name}{_parameters(declaration.parameters)}{_result(declaration.result)}"


def _api(declaration: syntax.ApiDeclaration) -> list[str]:
    head = f"api {declaration.name}{_parameters(declaration.parameters)}{_by(declaration.by)}"
    return [head, *_contract(declaration)]


def _program(declaration: syntax.ProgramDeclaration) -> list[str]:
    by = _by(declaration.by)
    head = f"program {declaration.name}{_parameters(declaration.parameters)}{by}:"
    calls = [f"calls {', '.join(each.id for each in declaration.calls)}"] if declaration.calls else []
    statements = [line for statement in declaration.body for line in format_statement(statement)]
    return [head, *_contract(declaration), *calls, *statements]


def _task(declaration: syntax.TaskDeclaration) -> list[str]:
    return [
        f"task {declaration.name}:",
        *_scene(declaration.scene),
        *([f"goal:    {format_sampler(declaration.goal)}"] if declaration.goal else []),
        *([f"run:     {_call(declaration.run)}"] if declaration.run else []),
        *([f"success: {format_expression(declaration.success)}"] if declaration.success else []),
    ]


def _scene(groups: Sequence[syntax.SceneGroup]) -> list[str]:
    if len(groups) <= 1:
        return [f"scene:   {format_group(group)}" for group in groups]
    widest = max(len(group.name) for group in groups)
    return ["scene:", *(INDENT + format_group(group, widest) for group in groups)]


FORMATTERS: dict[type[syntax.Declaration], Callable[..., list[str]]] = {
    syntax.TypeDeclaration: _type,
    syntax.EnumDeclaration: _enum,
    syntax.RecordDeclaration: _record,
    syntax.ConstantDeclaration: _constant,
    syntax.PredicateDeclaration: _predicate,
    syntax.ApiDeclaration: _api,
    syntax.ProgramDeclaration: _program,
    syntax.TaskDeclaration: _task,
}


def _contract(declaration: syntax.ApiDeclaration | syntax.ProgramDeclaration) -> list[str]:
    clauses = {"requires": declaration.requires, "achieves": declaration.achieves}
    return [f"{word} {format_expression(value)}" for word, value in clauses.items() if value]


def _parameters(parameters: Iterable[syntax.Parameter]) -> str:
    return f"({', '.join(map(_parameter, parameters))})"


def _parameter(parameter: syntax.Parameter) -> str:
    text = f"{parameter.name}: {format_type(parameter.type)}"
    if parameter.low is None or parameter.high is None:
        return text
    return f"{text} in {_number(parameter.low)} .. {_number(parameter.high)}"


def format_type(name: syntax.TypeName) -> str:
    """`Block`, or `list[Placement]`."""
    return f"list[{name.name}]" if name.is_list else name.name


def format_sampler(sampler: syntax.Sampler) -> str:
    """`towers(blocks, placements=1..6, height=2..4)`."""
    options = [
        f"{each.name}={each.low}" + (f"..{each.high}" if each.high != each.low else "")
        for each in sampler.options
    ]
    knobs = ", ".join([*sampler.groups, *options])
    return f"{sampler.name}({knobs}){_result(sampler.result)}{_by(sampler.by)}"


def _result(type: syntax.TypeName | None) -> str:
    return f" -> {format_type(type)}" if type else ""


def _by(provider: syntax.Name | None) -> str:
    return f" by {provider.id}" if provider else ""


def format_group(group: syntax.SceneGroup, width: int = 0) -> str:
    """`blocks: 8 Block on table`; in a scene the names are padded to the widest one's width."""
    count = f"{group.count}" if group.most is None else f"{group.count}..{group.most}"
    head = f"{group.name}:".ljust(width + 1)
    text = f"{head} {count} {format_type(group.type)} on {group.place}"
    return f"{text} with {', '.join(map(_detail, group.details))}" if group.details else text


def _detail(detail: syntax.Detail) -> str:
    return f"{detail.name}({', '.join(map(_setting, detail.settings))})"


def _setting(setting: syntax.Setting) -> str:
    match setting:
        case syntax.Interval(low, high):
            return f"{_number(low)} .. {_number(high)}"
        case syntax.Text(value):
            return f'"{value}"'
        case Number():
            return _number(setting)
        case syntax.Name(id):
            return id


# Statements -------------------------------------------------------------------------------------


def format_statement(statement: syntax.Statement) -> list[str]:
    """The lines of a statement, without the indentation of the body that it stands in."""
    if isinstance(statement, syntax.Call):
        return [_call(statement)]
    if isinstance(statement, syntax.When):
        head = f"when {format_expression(statement.condition)}:"
    else:
        head = f"for {_generator(statement.generator)}:"
    return [head, *(INDENT + line for line in format_statement(statement.body))]


def _call(call: syntax.Call) -> str:
    return f"{call.callee}({', '.join(_expression(each, SUM) for each in call.arguments)})"


# Expressions ------------------------------------------------------------------------------------

# How tightly a node holds its parts together. What is not listed never needs brackets.
TIGHTNESS: dict[type[syntax.Node], int] = {
    syntax.Quantified: 0,  # reaches as far as it can: bracketed wherever something may follow
    syntax.Or: 1,
    syntax.And: 2,
    syntax.Not: 3,
    syntax.Compare: 4,
}
SUM, PRODUCT, TERM = 5, 6, 7


def format_expression(expression: Expression) -> str:
    """An expression on one line, with no more brackets than it takes to read it back."""
    return _expression(expression, 0)


def _tightness(expression: Expression) -> int:
    if isinstance(expression, syntax.Arithmetic):
        return SUM if expression.operator in "+-" else PRODUCT
    return TIGHTNESS.get(type(expression), TERM)


def _expression(expression: Expression, needed: int) -> str:
    text = _bare(expression)
    return f"({text})" if _tightness(expression) < needed else text


def _bare(expression: Expression) -> str:
    match expression:
        case syntax.Name(id):
            return id
        case syntax.Field(value, name):
            return f"{value.id}.{name}"
        case syntax.Wildcard():
            return "any"
        case Number():
            return _number(expression)
        case syntax.Arithmetic(operator, left, right):
            own = _tightness(expression)
            return f"{_expression(left, own)} {operator} {_expression(right, own + 1)}"
        case syntax.Atom(predicate, arguments):
            return f"{predicate}({', '.join(_expression(each, SUM) for each in arguments)})"
        case syntax.Compare(operator, left, right):
            return f"{_expression(left, SUM)} {operator} {_expression(right, SUM)}"
        case syntax.Not(value):
            return f"not {_expression(value, 3)}"
        case syntax.And(values):
            return " and ".join(_expression(value, 3) for value in values)
        case syntax.Or(values):
            return " or ".join(_expression(value, 2) for value in values)
        case syntax.Quantified(quantifier, body, generators):
            heads = " ".join(f"for {_generator(each, 1)}" for each in generators)
            return f"{quantifier} {_expression(body, 1)} {heads}"
    raise AssertionError(f"no text for a {type(expression).__name__}")


def _generator(generator: syntax.Generator, needed: int = 0) -> str:
    head = f"{generator.variable} in {generator.iterable.id}"
    if generator.condition is None:
        return head
    return f"{head} if {_expression(generator.condition, needed)}"


def _number(number: Number) -> str:
    digits = repr(number.value).removesuffix(".0")
    return f"{digits} {number.unit}" if number.unit else digits
