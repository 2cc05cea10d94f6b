"""The search for a base as plain numbers and words; keys: docs, "Reports"."""

from __future__ import annotations

from typing import Any

import numpy as np

from sbam.plain import plain
from sbam.planning.placement.search import BaseMap, Place
from sbam.robots.options import options_text


def base_report(found: BaseMap) -> dict[str, Any]:
    """Everything that was found; SI units, angles in degrees.

    ``ok`` is whether the action can be done where the robot stands; ``sentences`` say what would have to change.
    """
    cells = found.room & (found.miss == 0.0)
    report = {
        "report": "reach",
        "ok": bool(found.here.planned),
        "robot": found.robot.name,
        "scene": found.task.scene.name,
        "model": found.task.model.name,
        "synthetic": found.task.model.synthetic,
        "sentences": sentences(found),
        "here": _place(found.here),
        "base": None if found.base is None else {**_place(found.base), "robot": base_option(found, found.base)},
        "objects": None if found.objects is None else _place(found.objects),
        "right_m": found.right,
        "forward_m": found.forward,
        "turn_deg": found.turn,
        "miss_m": found.miss,
        "share": found.share,
        "room": found.room.astype(int),
        "places": cells.size,
        "places_that_reach": np.count_nonzero(cells),
    }
    return plain(report)


def base_option(found: BaseMap, place: Place) -> str:
    """What to give as ``--robot`` for the robot to stand there."""
    options = dict(found.robot.description.options)
    for name in ("right", "forward", "turn"):
        value = round(options.get(name, 0.0) + getattr(place, name), 3)
        if value or name in options:
            options[name] = value
    source = found.robot.description.path
    name = found.robot.name if _is_built_in(found.robot.name, source) else source
    return f"{name}:{options_text(options)}" if options else name


def sentences(found: BaseMap) -> list[str]:
    """What a person wants to know, a sentence each."""
    name = found.robot.name
    if found.here.planned:
        return [f"{name} can do it where it stands"]
    said = [
        f"{name}'s {hand} hand stays {1e3 * miss:.0f} mm away from where it has to be with {role!r}"
        for (role, hand), miss in found.here.miss.items()
        if miss > 0.0
    ] or [f"{name}'s hands reach everything from where it stands, but no plan passes the checks"]
    if found.base is None:
        said.append(
            f"no place of its base within {1e3 * np.abs(found.right).max():.0f} mm aside and "
            f"{1e3 * np.abs(found.forward).max():.0f} mm forward or back would do"
        )
    else:
        said.append(
            f"its base would have to stand {_way(found.base)}: --robot {base_option(found, found.base)}"
            + _doubt(found.base)
        )
    if found.objects is None:
        said.append("no shift of all objects together on what they stand on would do")
    else:
        said.append(f"or the objects, all together, {_way(found.objects)}" + _doubt(found.objects))
    return said


def _way(place: Place) -> str:
    parts = [
        f"{1e3 * abs(value):.0f} mm {positive if value > 0 else negative}"
        for value, positive, negative in (
            (place.right, "to the right", "to the left"),
            (place.forward, "farther forward", "farther back"),
        )
        if abs(value) >= 5e-4
    ]
    if abs(place.turn) >= 0.5:
        parts.append(f"turned by {abs(place.turn):.0f} degrees to the {'left' if place.turn > 0 else 'right'}")
    return ", ".join(parts) or "where it is"


def _doubt(place: Place) -> str:
    return "" if place.planned else " (the hands reach from there, but no plan passed the checks)"


def _place(place: Place) -> dict[str, Any]:
    return {
        "right_m": place.right,
        "forward_m": place.forward,
        "turn_deg": place.turn,
        "miss": [{"object": name, "hand": hand, "miss_m": miss} for (name, hand), miss in place.miss.items()],
        "share": place.share,
        "planned": place.planned,
    }


def _is_built_in(name: str, path: str) -> bool:
    from sbam.robots import ROBOTS

    return name in ROBOTS and str(ROBOTS[name]) == path
