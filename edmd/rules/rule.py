"""What a user hands over: a rule is a frozen record of floats, each with its meaning and its check."""

from dataclasses import asdict, dataclass, fields
from math import inf
from typing import Annotated, Any, get_type_hints

from ccd import checks


def number(what, above=-inf, at_least=-inf, at_most=inf):
    """A check (name, value) -> float that says what is expected."""
    def check(name, value):
        if isinstance(value, str | bool):
            raise ValueError(f"{name} = {value!r}: expected {what}")
        return checks.real_number(name, value, what, above, at_least, at_most=at_most)
    return check


Share = Annotated[float, "normal restitution e: speed after over speed before a head-on collision, 0 to 1",
                  number("a number from 0 to 1", at_least=0, at_most=1)]
ContactTime = Annotated[float, "TC model: a collision sooner than this after one of a partner is smooth and elastic; 0: off",
                        number("a time, 0 or more", at_least=0)]
ContactShare = Annotated[float, "the same in times in which a body moves by its length, for gases that cool; the longer of both holds",
                         number("a number, 0 or more", at_least=0)]


@dataclass(frozen=True)
class Rule:
    """Base of the rules: ValueError when a number is out of its range."""

    def __post_init__(self):
        for name, hint in get_type_hints(type(self), include_extras=True).items():
            object.__setattr__(self, name, hint.__metadata__[1](name, getattr(self, name)))

    def document(self) -> dict[str, Any]:
        """The rule as JSON and a config hold it."""
        return {"kind": self.kind, **asdict(self)}

    @property
    def parameters(self) -> tuple[float, ...]:
        """Its numbers but for the contact times, in order: what its kernel reads."""
        return tuple(getattr(self, item.name) for item in fields(self) if not item.name.startswith("contact_"))
