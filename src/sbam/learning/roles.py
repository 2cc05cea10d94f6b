"""Roles: the parts that objects play, bound by affordance so that other objects can take part."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from sbam.errors import BindingError, UnknownNameError
from sbam.learning.model import Role
from sbam.scene.object_model import ObjectModel

_OTHER_OBJECT = 1000.0
"""Cost of an object that was not demonstrated in the role; an affordance more than needed costs 1."""
_IMPOSSIBLE = 1e9


def bind_roles(
    roles: Sequence[Role], objects: Mapping[str, ObjectModel], chosen: Mapping[str, str] | None = None
) -> dict[str, str]:
    """Find an object for every role.

    An object can play a role if it bears all its affordances and, if the role moves, is movable. Of several, those
    that were demonstrated in the role are preferred, then those with the fewest affordances that are not needed.

    Args:
        roles: the roles of a model.
        objects: name in the scene -> object model.
        chosen: role -> name of the object that shall play it, for some or all roles.

    Returns:
        Role -> name of the object in the scene; no object plays two roles.

    Raises:
        BindingError: if a role finds no object, or several that are equally good; says what lacks and what is there.
        UnknownNameError: if ``chosen`` names an unknown role or object.
    """
    names = tuple(objects)
    cost = np.array([[_cost(role, objects[name]) for name in names] for role in roles]).reshape(len(roles), len(names))
    _apply_choices(cost, roles, names, objects, chosen or {})
    for role, row in zip(roles, cost, strict=True):
        if not (row < _IMPOSSIBLE).any():
            raise BindingError(f"no object can play the role {_described(role)}; there are {_inventory(objects)}")
    columns, total = _assign(cost)
    if total >= _IMPOSSIBLE:
        wanted = ", ".join(_described(role) for role in roles)
        raise BindingError(f"too few objects for the roles {wanted}; there are {_inventory(objects)}")
    for row, role in enumerate(roles):
        _refuse_ambiguity(cost, row, columns, total, role, names)
    return {role.name: names[column] for role, column in zip(roles, columns, strict=True)}


def role_name(affordances: Sequence[str], taken: Sequence[str]) -> str:
    """Name of a role: its most telling affordance, numbered if that name is taken."""
    telling = min(affordances, key=lambda affordance: (affordance == "place", affordance))
    name = base = telling.replace(" ", "_")
    number = 2
    while name in taken:
        name, number = f"{base}_{number}", number + 1
    return name


def _cost(role: Role, model: ObjectModel) -> float:
    lacking = set(role.affordances) - set(model.affordances)
    if lacking or (role.moves and not model.movable):
        return _IMPOSSIBLE
    extra = len(set(model.affordances) - set(role.affordances))
    return extra + (0.0 if model.name in role.demonstrated else _OTHER_OBJECT)


def _apply_choices(
    cost: Float[np.ndarray, "roles objects"],
    roles: Sequence[Role],
    names: tuple[str, ...],
    objects: Mapping[str, ObjectModel],
    chosen: Mapping[str, str],
) -> None:
    row_of = {role.name: row for row, role in enumerate(roles)}
    for role, name in chosen.items():
        if role not in row_of:
            raise UnknownNameError("role", role, row_of)
        if name not in names:
            raise UnknownNameError("object", name, names, "the scene")
        row, column = row_of[role], names.index(name)
        if cost[row, column] >= _IMPOSSIBLE:
            lacking = sorted(set(roles[row].affordances) - set(objects[name].affordances))
            why = f"it lacks {', '.join(map(repr, lacking))}" if lacking else "it cannot be moved"
            raise BindingError(f"object {name!r} cannot play the role {_described(roles[row])}: {why}")
        kept = cost[row, column]
        cost[row, :] = cost[:, column] = _IMPOSSIBLE
        cost[row, column] = kept


def _assign(cost: Float[np.ndarray, "roles objects"]) -> tuple[list[int], float]:
    from scipy.optimize import linear_sum_assignment

    if cost.shape[0] > cost.shape[1]:
        return [], _IMPOSSIBLE
    rows, columns = linear_sum_assignment(cost)
    return [int(column) for column in columns], float(cost[rows, columns].sum())


def _refuse_ambiguity(
    cost: Float[np.ndarray, "roles objects"],
    row: int,
    columns: list[int],
    total: float,
    role: Role,
    names: tuple[str, ...],
) -> None:
    without = cost.copy()
    without[row, columns[row]] = _IMPOSSIBLE
    others, other_total = _assign(without)
    if others and other_total <= total:
        raise BindingError(
            f"both {names[columns[row]]!r} and {names[others[row]]!r} can play the role {_described(role)}; "
            "name the object that shall"
        )


def _described(role: Role) -> str:
    demonstrated = f", as {' or '.join(role.demonstrated)} did" if role.demonstrated else ""
    movable = ", movable" if role.moves else ""
    return f"{role.name!r} (affords {', '.join(role.affordances)}{movable}{demonstrated})"


def _inventory(objects: Mapping[str, ObjectModel]) -> str:
    parts = [
        f"{name} (affords {', '.join(model.affordances) or 'nothing'}{'' if model.movable else ', not movable'})"
        for name, model in objects.items()
    ]
    return "; ".join(parts) or "no objects"
