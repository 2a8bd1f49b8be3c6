"""From syntax tree to canonical lines: equal trees have equal lines, which parse to the same tree."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from hashlib import sha256

from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.line_wrapping import STEP, Row
from ntp_dsl.language.syntax.nodes import Expression, Number

INDENT = " " * STEP
EMPTY_DOCSTRING = '""""""'
FEW = 4  # elements of a goal, or facts, that stand on one line


def hash_declaration(declaration: nodes.Declaration) -> str:
    """Return a hash of the declaration's meaning, 16 hexadecimal digits, without prose and layout."""
    plain = replace(declaration, docstring="")
    if isinstance(plain, nodes.ApiDeclaration | nodes.ProgramDeclaration):
        plain = replace(plain, says=())
    rows = declaration_rows(plain)
    text = "\n".join(" " * row.indent + row.text for row in rows)
    return sha256(text.encode()).hexdigest()[:16]


def header_rows(library: nodes.Library) -> list[Row]:
    """Return `library NAME`, and its docstring."""
    return [Row(0, f"library {library.name}"), *_docstring(library.docstring, 0)]


def use_row(use: nodes.Use) -> Row:
    return Row(0, f"use {use.library}")


def declaration_rows(declaration: nodes.Declaration) -> list[Row]:
    """Return one declaration, a row for each clause, section, loop and call."""
    for kind, formatter in FORMATTERS.items():
        if isinstance(declaration, kind):
            first, *rest = formatter(declaration)
            below = [Row(STEP + len(line) - len(line.lstrip()), line.lstrip()) for line in rest]
            below = [*_docstring(declaration.docstring, STEP), *below]
            if not below and isinstance(declaration, nodes.ProgramDeclaration | nodes.TaskDeclaration):
                below = [Row(STEP, EMPTY_DOCSTRING)]  # a body must not be empty
            return [Row(0, first), *below]
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


# Declarations: the first line is at the margin, the others are indented below it ----------------


def _type(declaration: nodes.TypeDeclaration) -> list[str]:
    parent = f" is {format_type(declaration.parent)}" if declaration.parent else ""
    return [f"type {declaration.name}{parent}"]


def _enum(declaration: nodes.EnumDeclaration) -> list[str]:
    return [f"enum {declaration.name}: {', '.join(declaration.members)}"]


def _record(declaration: nodes.RecordDeclaration) -> list[str]:
    return [f"record {declaration.name}{_parameters(declaration.fields)}"]


def _constant(declaration: nodes.ConstantDeclaration) -> list[str]:
    return [f"constant {declaration.name}: {format_type(declaration.type)}"]


def _predicate(declaration: nodes.PredicateDeclaration) -> list[str]:
    head = f"predicate {declaration.name}{_parameters(declaration.parameters)}"
    if declaration.body is not None:
        return [f"{head}:", format_expression(declaration.body)]
    return [f"{head}{_result(declaration.result)}{_by(declaration.by)}"]


def format_signature(declaration: nodes.PredicateDeclaration) -> str:
    """Return `drink(cup: Cup) -> Drink`."""
    return f"{declaration.name}{_parameters(declaration.parameters)}{_result(declaration.result)}"


def _api(declaration: nodes.ApiDeclaration) -> list[str]:
    head = f"api {declaration.name}{_parameters(declaration.parameters)}{_by(declaration.by)}"
    return [head, *_contract(declaration)]


def _program(declaration: nodes.ProgramDeclaration) -> list[str]:
    by = _by(declaration.by)
    head = f"program {declaration.name}{_parameters(declaration.parameters)}{by}:"
    calls = [f"calls {', '.join(each.id for each in declaration.calls)}"] if declaration.calls else []
    statements = [line for statement in declaration.body for line in format_statement(statement)]
    return [head, *_contract(declaration), *calls, *statements]


def _task(declaration: nodes.TaskDeclaration) -> list[str]:
    return [
        f"task {declaration.name}:",
        *(_shared_scene(declaration.shared) if declaration.shared else _scene(declaration.scene)),
        *_initially(declaration.initially),
        *(_goal(declaration.goal) if declaration.goal else []),
        *([f"run:     {_call(declaration.run)}"] if declaration.run else []),
        *([f"success: {format_expression(declaration.success)}"] if declaration.success else []),
    ]


def _scene(groups: Sequence[nodes.SceneGroup]) -> list[str]:
    if len(groups) <= 1:
        return [f"scene:   {format_group(group)}" for group in groups]
    widest = max(len(group.name) for group in groups)
    return ["scene:", *(INDENT + format_group(group, widest) for group in groups)]


def _shared_scene(shared: nodes.SharedScene) -> list[str]:
    if not shared.own:
        return [f"scene:   as {shared.task}"]
    widest = max(len(each.name) for each in shared.own)
    rows = [
        format_group(each, widest) if isinstance(each, nodes.SceneGroup) else _varied(each, widest)
        for each in shared.own
    ]
    return [f"scene:   as {shared.task} with", *(INDENT + row for row in rows)]


def _varied(varied: nodes.Varied, width: int) -> str:
    return f"{f'{varied.name}:'.ljust(width + 1)} {_count(varied)}"


def _count(group: nodes.SceneGroup | nodes.Varied) -> str:
    return f"{group.count}" if group.most is None else f"{group.count}..{group.most}"


def _initially(facts: Sequence[nodes.Atom]) -> list[str]:
    texts = [format_expression(each) for each in facts]
    if len(texts) <= FEW:
        return [f"initially: {', '.join(texts)}"] if texts else []
    return ["initially:", *(INDENT + text for text in texts)]


def _goal(goal: nodes.Goal) -> list[str]:
    if isinstance(goal, nodes.Sampler):
        return [f"goal:    {format_sampler(goal)}"]
    rows = [f"({', '.join(_expression(each, SUM) for each in row.terms)})" for row in goal.rows]
    if len(rows) <= FEW or goal.result:
        return [f"goal:    {', '.join(rows)}{_result(goal.result)}"]
    return ["goal:", *(INDENT + row for row in rows)]


FORMATTERS: dict[type[nodes.Declaration], Callable[..., list[str]]] = {
    nodes.TypeDeclaration: _type,
    nodes.EnumDeclaration: _enum,
    nodes.RecordDeclaration: _record,
    nodes.ConstantDeclaration: _constant,
    nodes.PredicateDeclaration: _predicate,
    nodes.ApiDeclaration: _api,
    nodes.ProgramDeclaration: _program,
    nodes.TaskDeclaration: _task,
}


def _contract(declaration: nodes.ApiDeclaration | nodes.ProgramDeclaration) -> list[str]:
    clauses = {"requires": declaration.requires, "achieves": declaration.achieves}
    contract = [f"{word} {format_expression(value)}" for word, value in clauses.items() if value]
    says = ", ".join(f'"{each.value}"' for each in declaration.says)
    return [*([f"says {says}"] if says else []), *contract]


def _parameters(parameters: Iterable[nodes.Parameter]) -> str:
    return f"({', '.join(map(_parameter, parameters))})"


def _parameter(parameter: nodes.Parameter) -> str:
    text = f"{parameter.name}: {format_type(parameter.type)}"
    if parameter.low is None or parameter.high is None:
        return text
    return f"{text} in {_range(parameter.low, parameter.high)}"


def format_type(name: nodes.TypeName) -> str:
    """Return `Block`, or `list[Placement]`."""
    return f"list[{name.name}]" if name.is_list else name.name


def format_sampler(sampler: nodes.Sampler) -> str:
    """Return `towers(blocks, placements=1..6, height=2..4)`."""
    options = [
        f"{each.name}={each.low}" + (f"..{each.high}" if each.high != each.low else "")
        for each in sampler.options
    ]
    given = ", ".join([*sampler.groups, *options])
    return f"{sampler.name}({given}){_result(sampler.result)}{_by(sampler.by)}"


def _result(type: nodes.TypeName | None) -> str:
    return f" -> {format_type(type)}" if type else ""


def _by(provider: nodes.Name | None) -> str:
    return f" by {provider.id}" if provider else ""


def format_group(group: nodes.SceneGroup, width: int = 0) -> str:
    """Return `blocks: 8 Block on table`; in a scene the names are padded to the widest one's width."""
    head = f"{group.name}:".ljust(width + 1)
    count = "" if group.is_single else f"{_count(group)} "
    text = f"{head} {count}{format_type(group.type)} on {group.place}"
    return f"{text} with {', '.join(map(_detail, group.details))}" if group.details else text


def _detail(detail: nodes.Detail) -> str:
    return f"{detail.name}({', '.join(map(_setting, detail.settings))})"


def _setting(setting: nodes.Setting) -> str:
    match setting:
        case nodes.Interval(low, high):
            return _range(low, high)
        case nodes.Text(value):
            return f'"{value}"'
        case Number():
            return _number(setting)
        case nodes.Name(id):
            return id


# Statements -------------------------------------------------------------------------------------


def format_statement(statement: nodes.Statement) -> list[str]:
    """Return the lines of a statement, without the indentation of the body around it."""
    if isinstance(statement, nodes.Call):
        return [_call(statement)]
    if isinstance(statement, nodes.When):
        head = "else:" if statement.is_else else f"when {format_expression(statement.condition)}:"
    else:
        head = f"for {_generator(statement.generator)}:"
    return [head, *(INDENT + line for line in format_statement(statement.body))]


def _call(call: nodes.Call) -> str:
    return f"{call.callee}({', '.join(_expression(each, SUM) for each in call.arguments)})"


# Expressions ------------------------------------------------------------------------------------

# Precedence of operators. What is not listed never needs brackets.
PRECEDENCE: dict[type[nodes.Node], int] = {
    nodes.Quantified: 0,  # reaches as far as it can: bracketed wherever something may follow
    nodes.Or: 1,
    nodes.And: 2,
    nodes.Not: 3,
    nodes.Compare: 4,
}
SUM, PRODUCT, TERM = 5, 6, 7


def format_expression(expression: Expression) -> str:
    """Return an expression on one line, with no more brackets than parsing it needs."""
    return _expression(expression, 0)


def _precedence(expression: Expression) -> int:
    if isinstance(expression, nodes.Arithmetic) and not _is_negative(expression):
        return SUM if expression.operator in "+-" else PRODUCT
    return PRECEDENCE.get(type(expression), TERM)


def _is_negative(expression: nodes.Arithmetic) -> bool:
    """Return whether it is written `-x`."""
    is_term = isinstance(expression.right, nodes.Name | nodes.Field | nodes.Atom)
    return expression.operator == "-" and expression.left == nodes.ZERO and is_term


def _expression(expression: Expression, needed: int) -> str:
    text = _bare(expression)
    return f"({text})" if _precedence(expression) < needed else text


def _bare(expression: Expression) -> str:
    match expression:
        case nodes.Name(id):
            return id
        case nodes.Field(value, name):
            return f"{value.id}.{name}"
        case nodes.Wildcard():
            return "any"
        case Number():
            return _number(expression)
        case nodes.Arithmetic(right=right) if _is_negative(expression):
            return f"-{_bare(right)}"
        case nodes.Arithmetic(operator, left, right):
            own = _precedence(expression)
            return f"{_expression(left, own)} {operator} {_expression(right, own + 1)}"
        case nodes.Atom(predicate, arguments):
            return f"{predicate}({', '.join(_expression(each, SUM) for each in arguments)})"
        case nodes.Compare(operator, left, right):
            return f"{_expression(left, SUM)} {operator} {_expression(right, SUM)}"
        case nodes.Not(value):
            return f"not {_expression(value, 3)}"
        case nodes.And(values):
            return " and ".join(_expression(value, 3) for value in values)
        case nodes.Or(values):
            return " or ".join(_expression(value, 2) for value in values)
        case nodes.Quantified(quantifier, body, generators):
            heads = " ".join(f"for {_generator(each, 1)}" for each in generators)
            counted = "" if expression.count is None else f" {expression.count}"
            return f"{quantifier}{counted} {_expression(body, 1)} {heads}"
    raise AssertionError(f"no text for a {type(expression).__name__}")


def _generator(generator: nodes.Generator, needed: int = 0) -> str:
    head = f"{generator.variable} in {generator.iterable.id}"
    if generator.condition is None:
        return head
    return f"{head} if {_expression(generator.condition, needed)}"


def _range(low: Number, high: Number) -> str:
    """Return `3 .. 12 cm`: a unit that both bounds have is written once."""
    return f"{_number(replace(low, unit='') if low.unit == high.unit else low)} .. {_number(high)}"


def _number(number: Number) -> str:
    digits = repr(number.value).removesuffix(".0")
    return f"{digits} {number.unit}" if number.unit else digits
