"""The suite takes few cases of many, but every choice; what it leaves out is behind the marker `validate`."""

from itertools import combinations, product

import pytest
from cross_section import cross_section, some_of

OPTIONS = ("abcdef", [1, 2, 3], [0.5, -0.5])


def in_suite(cases):
    return [case.values for case in cases if not case.marks]


@pytest.mark.parametrize(("together", "few"), [(1, 6), (2, 20), (3, 36)])
def test_every_group_of_choices_occurs_and_nothing_is_lost(together, few):
    cases = cross_section(*OPTIONS, together=together)
    assert [case.values for case in cases] == list(product(*OPTIONS))
    assert all([mark.name for mark in case.marks] in ([], ["validate"]) for case in cases)

    def groups(choices):
        return {group for choice in choices for group in combinations(enumerate(choice), together)}
    assert groups(in_suite(cases)) == groups(product(*OPTIONS))
    assert len(in_suite(cases)) <= few


def test_choices_are_mixed_where_that_costs_nothing():
    taken = in_suite(cross_section(*OPTIONS))
    assert [sum(choice[1] == k for choice in taken) for k in (1, 2, 3)] == [2, 2, 2]
    assert len({choice[1:] for choice in taken}) == 6


def test_some_of_them():
    first, *others = some_of([1e-3, 1e-5, 1e-7], [1e-3])
    assert first == 1e-3
    assert [(each.values, [mark.name for mark in each.marks]) for each in others] == [((1e-5,), ["validate"]), ((1e-7,), ["validate"])]
