"""Region pair: the two affordance regions whose connecting vector is watched."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, order=True)
class RegionReference:
    """A region of whichever object plays a role: ``role`` of the action model, ``affordance`` of the region."""

    role: str
    affordance: str

    def __str__(self) -> str:
        return f"{self.affordance} of {self.role}"


@dataclass(frozen=True, order=True)
class RegionPair:
    """An ordered pair of regions; its vector is d = first - second, in the agent frame, m.

    Attributes:
        first: the region A0 of the paper.
        second: the region A1, or None for an own-start pair: the place where ``first`` was at the start.
    """

    first: RegionReference
    second: RegionReference | None

    @property
    def is_own_start(self) -> bool:
        """Whether the pair measures against the first region's own place at the start."""
        return self.second is None

    @property
    def is_same_object(self) -> bool:
        """Whether both regions belong to one object, so that the pair carries its orientation."""
        return self.second is not None and self.first.role == self.second.role

    @property
    def roles(self) -> tuple[str, ...]:
        """The roles whose poses move the vector."""
        if self.second is None or self.second.role == self.first.role:
            return (self.first.role,)
        return (self.first.role, self.second.role)

    def __str__(self) -> str:
        return f"{self.first} -> {'own start' if self.second is None else self.second}"
