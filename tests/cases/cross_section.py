"""What the suite takes of many cases; all the others are behind the marker `validate`.

Both give the second argument of pytest.mark.parametrize.
"""

from itertools import combinations, product

import pytest


def cross_section(*options, together=1):
    """Every combination of a choice from each option. The suite takes a few, in which each choice occurs, or each of `together` choices."""
    options = [list(option) for option in options]
    every = list(product(*options))
    taken = few_of([tuple(enumerate(choice)) for choice in product(*(range(len(option)) for option in options))], together)
    return [pytest.param(*choice, marks=() if k in taken else pytest.mark.validate) for k, choice in enumerate(every)]


def some_of(cases, taken):
    """All of these cases, each one argument; the suite takes those named in `taken`."""
    return [case if case in taken else pytest.param(case, marks=pytest.mark.validate) for case in cases]


def few_of(every, together):
    """Indices of a few of these tuples of (option, choice) in which every group of `together` of them occurs; greedily, always the same."""
    def groups(choices, size):
        return set(combinations(choices, size))

    missing = set().union(*(groups(choices, together) for choices in every))
    taken, pairs, times = [], set(), dict.fromkeys((choice for choices in every for choice in choices), 0)

    def worth(k):
        """What it adds; then what it adds of pairs; then how rare its choices are so far."""
        return len(groups(every[k], together) & missing), len(groups(every[k], 2) - pairs), -sum(times[choice] for choice in every[k])

    while missing:
        taken.append(max(range(len(every)), key=worth))
        missing -= groups(every[taken[-1]], together)
        pairs |= groups(every[taken[-1]], 2)
        for choice in every[taken[-1]]:
            times[choice] += 1
    return taken
