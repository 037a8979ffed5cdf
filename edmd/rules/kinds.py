"""The kinds of rules, side by side, and the row of numbers by which the engine knows one.

A new rule is a file with its record and its kernel, a member and a branch here. Parameters are plain floats of the world: one compiled
engine serves all rules.
"""

from difflib import get_close_matches
from enum import IntEnum

import numpy as np

from ccd.compiling import kernel, large_kernel
from edmd.rules import inelastic, power_law, viscoelastic
from edmd.rules.elastic import Elastic
from edmd.rules.inelastic import Inelastic
from edmd.rules.power_law import PowerLaw
from edmd.rules.rough import Rough
from edmd.rules.rule import Rule
from edmd.rules.viscoelastic import Viscoelastic

# CONTACT_TIME: the one in force, from the least one and from the share of a thermal time; from PARAMETERS on those of the kind
KIND, CONTACT_TIME, LEAST_CONTACT_TIME, CONTACT_SHARE, PARAMETERS = range(5)
RULE_ROW = 8


class RuleKind(IntEnum):
    """How two bodies rebound. The smooth ones are those before ROUGH."""

    ELASTIC = 0
    INELASTIC = 1
    VISCOELASTIC = 2
    POWER_LAW = 3
    ROUGH = 4


RECORDS = {RuleKind.ELASTIC: Elastic, RuleKind.INELASTIC: Inelastic, RuleKind.VISCOELASTIC: Viscoelastic, RuleKind.POWER_LAW: PowerLaw,
           RuleKind.ROUGH: Rough}
RULES = {record.kind: record for record in RECORDS.values()}
ELASTIC, INELASTIC, VISCOELASTIC, ROUGH = (int(RuleKind.ELASTIC), int(RuleKind.INELASTIC), int(RuleKind.VISCOELASTIC), int(RuleKind.ROUGH))


@large_kernel
def smooth_restitution(rule, approach):
    """The normal restitution of a smooth, inelastic rule at this approach velocity. rule: its row."""
    kind, parameters = int(rule[KIND]), rule[PARAMETERS:]
    if kind == INELASTIC:
        return inelastic.restitution(approach, parameters)
    if kind == VISCOELASTIC:
        return viscoelastic.restitution(approach, parameters)
    return power_law.restitution(approach, parameters)


@kernel
def set_contact_time(rule, thermal_time):
    """The contact time in force while bodies take this time to move by their length."""
    rule[CONTACT_TIME] = max(rule[LEAST_CONTACT_TIME], rule[CONTACT_SHARE] * thermal_time)


def rule_row(rule):
    """The row of a rule, for the world; its contact time is not in force yet."""
    row = np.zeros(RULE_ROW)
    row[KIND] = next(kind for kind, record in RECORDS.items() if type(rule) is record)
    row[LEAST_CONTACT_TIME] = getattr(rule, "contact_time", 0.0)
    row[CONTACT_SHARE] = getattr(rule, "contact_share", 0.0)
    row[PARAMETERS:PARAMETERS + len(rule.parameters)] = rule.parameters
    return row


def chosen_rule(restitution=1.0, rule=None):
    """The rule of `Simulation(restitution=..., rule=...)`: a record as it is, a name with that restitution where it has one, or by the
    restitution alone. ValueError in words."""
    given = Inelastic(restitution).restitution                  # or it says what is wrong
    if isinstance(rule, Rule):
        if given != 1.0:
            raise ValueError(f"restitution = {given} and rule = {rule!r}: expected one of them; the rule has its own restitution")
        return rule
    if rule is None:
        return Elastic() if given == 1.0 else Inelastic(given)
    if not isinstance(rule, str) or rule not in RULES:
        close = get_close_matches(str(rule), RULES, 1)
        raise ValueError(f"rule = {rule!r}: expected a rule such as edmd.Rough(restitution=0.9), or one of {', '.join(map(repr, RULES))}"
                         + (f" (did you mean {close[0]!r}?)" if close else ""))
    record = RULES[rule]
    if "restitution" in record.__dataclass_fields__:
        return record(restitution=given)
    if given != 1.0:
        raise ValueError(f"restitution = {given} and rule = {rule!r}: this rule has no constant restitution; expected one of them")
    return record()


def rule_of(document):
    """The rule that `Rule.document` describes."""
    return RULES[document["kind"]](**{key: value for key, value in document.items() if key != "kind"})
