"""Random syntax trees, for property tests."""

from __future__ import annotations

from hypothesis import strategies as st

from ntp_dsl.language.parsing.term_builder import RESERVED
from ntp_dsl.language.parsing.tree_builder import clean
from ntp_dsl.language.syntax import nodes as s

names = st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,6}", fullmatch=True).filter(
    lambda name: name not in RESERVED and name != "list"
)
docstrings = st.text(st.characters(codec="utf-8", exclude_characters="\r"), max_size=40).map(
    lambda text: clean(text.replace('"""', ""))
)
numbers = st.builds(
    s.Number,
    st.floats(-1e6, 1e6, allow_nan=False).map(lambda value: value or 0.0),
    st.sampled_from(["", "m", "cm", "deg"]),
)
terms = st.recursive(
    st.builds(s.Name, names)
    | st.builds(s.Field, st.builds(s.Name, names), names)
    | st.just(s.Wildcard())
    | numbers,
    lambda inner: (
        st.builds(s.Arithmetic, st.sampled_from("+-*/"), inner, inner)
        | st.builds(s.Atom, names, st.lists(inner, max_size=2).map(tuple))
    ),
    max_leaves=4,
)
atoms = st.builds(s.Atom, names, st.lists(terms, max_size=3).map(tuple))


def _generators(conditions: st.SearchStrategy[s.Expression]) -> st.SearchStrategy[s.Generator]:
    return st.builds(s.Generator, names, st.builds(s.Name, names), st.none() | conditions)


def _several(inner: st.SearchStrategy[s.Expression]) -> st.SearchStrategy[tuple[s.Expression, ...]]:
    return st.lists(inner, min_size=2, max_size=3).map(tuple)


conditions = st.recursive(
    atoms | st.builds(s.Compare, st.sampled_from(["==", "!=", "<", "<=", ">", ">="]), terms, terms),
    lambda inner: (
        st.builds(s.Not, inner)
        | st.builds(s.And, _several(inner))
        | st.builds(s.Or, _several(inner))
        | st.builds(
            s.Quantified,
            st.sampled_from(["all", "some"]),
            inner,
            st.lists(_generators(inner), min_size=1, max_size=2).map(tuple),
        )
        | st.builds(
            s.Quantified,
            st.sampled_from(["exactly", "at least"]),
            inner,
            st.lists(_generators(inner), min_size=1, max_size=2).map(tuple),
            st.integers(0, 20),
        )
    ),
    max_leaves=5,
)
calls = st.builds(s.Call, names, st.lists(terms, max_size=2).map(tuple))
statements = st.recursive(
    calls,
    lambda inner: st.builds(s.When, conditions, inner) | st.builds(s.For, _generators(conditions), inner),
    max_leaves=3,
)
alternatives = st.builds(
    lambda condition, some, other: (s.When(condition, some), s.When(s.Not(condition), other, is_else=True)),
    conditions,
    statements,
    statements,
)
bodies = st.lists(statements.map(lambda each: (each,)) | alternatives, min_size=1, max_size=3).map(
    lambda several: tuple(each for some in several for each in some)
)
types = st.builds(s.TypeName, names, st.booleans())
bounds = st.tuples(numbers, numbers).filter(lambda bounds: bounds[0].unit or not bounds[1].unit)
ranges = bounds | st.just((None, None))
parameters = st.lists(
    st.builds(lambda name, type, span: s.Parameter(name, type, *span), names, types, ranges),
    max_size=3,
).map(tuple)
options = st.tuples(names, st.integers(0, 99), st.integers(0, 99))
providers = st.none() | st.builds(s.Name, names)
samplers = st.builds(
    s.Sampler,
    names,
    st.lists(names, max_size=2).map(tuple),
    st.lists(options.map(lambda option: s.Option(*option)), max_size=2).map(tuple),
    st.none() | types,
    providers,
)
texts = st.text(st.characters(codec="utf-8", exclude_characters='"\r\n\0'), max_size=9)
settings_of_details = st.one_of(
    numbers,
    bounds.map(lambda bounds: s.Interval(*bounds)),
    st.builds(s.Name, names),
    st.builds(s.Text, texts),
)
details = st.builds(s.Detail, names, st.lists(settings_of_details, max_size=3).map(tuple))
groups = st.builds(
    s.SceneGroup,
    names,
    st.integers(0, 99),
    types,
    names,
    st.none() | st.integers(0, 99),
    st.lists(details, max_size=4).map(tuple),
)
said = {"name": names, "docstring": docstrings}
contract = {"requires": st.none() | conditions, "achieves": st.none() | conditions}
declarations = st.one_of(
    st.builds(s.TypeDeclaration, parent=st.none() | types, **said),
    st.builds(s.EnumDeclaration, members=st.lists(names, min_size=1).map(tuple), **said),
    st.builds(s.RecordDeclaration, fields=parameters, **said),
    st.builds(s.ConstantDeclaration, type=types, **said),
    st.builds(s.PredicateDeclaration, parameters=parameters, body=conditions, **said),
    st.builds(
        s.PredicateDeclaration,
        parameters=parameters,
        result=st.none() | types,
        by=providers,
        **said,
    ),
    st.builds(s.ApiDeclaration, parameters=parameters, by=providers, **contract, **said),
    st.builds(
        s.ProgramDeclaration,
        parameters=parameters,
        body=bodies,
        by=providers,
        calls=st.lists(st.builds(s.Name, names), max_size=3).map(tuple),
        **contract,
        **said,
    ),
    st.builds(
        s.TaskDeclaration,
        scene=st.lists(groups, max_size=2).map(tuple),
        goal=st.none() | samplers,
        run=calls,
        success=st.none() | conditions,
        **said,
    ),
)
libraries = st.builds(
    s.Library,
    names,
    st.lists(st.builds(s.Use, names), max_size=2).map(tuple),
    st.lists(declarations, max_size=3).map(tuple),
    docstrings,
)
