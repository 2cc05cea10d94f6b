"""Which object of a demonstration plays which role."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.events import object_motion
from sbam.errors import BindingError, DemonstrationError, UnknownNameError
from sbam.learning.model import Role
from sbam.learning.pairs import candidate_pairs
from sbam.learning.roles import bind_roles, role_name
from sbam.learning.settings import LearningSettings
from sbam.learning.sketch import SketchedRole
from sbam.scene.object_library import ObjectLibrary
from sbam.scene.object_model import ObjectModel

Library = ObjectLibrary | Mapping[str, ObjectModel]


def demonstrated_models(demonstration: Demonstration, library: Library) -> dict[str, ObjectModel]:
    """Object models of the objects in a demonstration, without those unknown ones that never move.

    Raises:
        UnknownNameError: if the library lacks an object that moves; names the demonstration.
    """
    known = tuple(library)
    for name in unknown_objects(demonstration, library):
        if object_motion(demonstration, name).moving:
            where = f"demonstration {demonstration.name!r}, where it moves; the object library holds no such model"
            raise UnknownNameError("object", name, known, where)
    return {name: library[name] for name in demonstration.objects if name in known}


def check_recording(demonstration: Demonstration) -> None:
    """Refuse what cannot be learned from, whoever made it.

    Raises:
        DemonstrationError: if there are fewer than two frames, times do not increase, poses are missing or not finite.
    """
    name, time = demonstration.name, demonstration.time
    if len(time) < 2:
        raise DemonstrationError(name, f"has {len(time)} frame(s)", "a movement needs two or more")
    if not np.all(np.isfinite(time)) or not np.all(np.diff(time) > 0):
        raise DemonstrationError(name, "its times do not increase from frame to frame")
    bodies = [*demonstration.T_world_object.items(), *demonstration.T_world_hand.items()]
    for body, poses in bodies:
        if poses.shape != time.shape:
            raise DemonstrationError(name, f"{body} has poses of shape {poses.shape}", f"expected {time.shape}")
        finite = np.isfinite(poses.as_matrix()).all(axis=(1, 2))
        if not finite.all():
            raise DemonstrationError(name, f"the pose of {body} is not finite in frame {int(np.argmin(finite))}")


def unknown_objects(demonstration: Demonstration, library: Library) -> tuple[str, ...]:
    """Names of the objects in a demonstration that the library lacks."""
    known = tuple(library)
    return tuple(name for name in demonstration.objects if name not in known)


def involved_objects(models: Mapping[str, ObjectModel], settings: LearningSettings) -> tuple[str, ...]:
    """Names of the objects that take part in some watched pair."""
    pairs = candidate_pairs(models, settings)
    return tuple(name for name in models if any(name in pair.roles for pair in pairs))


def new_roles(models: Mapping[str, ObjectModel], settings: LearningSettings) -> dict[str, str]:
    """Roles for the objects of a first demonstration: role -> object name."""
    objects: dict[str, str] = {}
    for name in sorted(involved_objects(models, settings)):
        objects[role_name(models[name].affordances, tuple(objects))] = name
    return objects


def bind_demonstration(
    demonstration: Demonstration,
    models: Mapping[str, ObjectModel],
    earlier: Sequence[Sequence[SketchedRole]],
    settings: LearningSettings,
) -> dict[str, str]:
    """Objects of a further demonstration for the roles of the earlier ones: role -> object name.

    Args:
        demonstration: the further demonstration.
        models: its objects.
        earlier: roles of each earlier demonstration.
        settings: pairs, which say which objects are involved.

    Raises:
        DemonstrationError: if it lacks an object that the earlier ones have, or has one that they lack.
    """
    roles = [
        Role(
            name=first.role,
            affordances=first.affordances,
            moves=False,
            demonstrated=tuple(sorted({role.object for roles in earlier for role in roles if role.role == first.role})),
        )
        for first in earlier[0]
    ]
    involved = involved_objects(models, settings)
    try:
        objects = bind_roles(roles, {name: models[name] for name in involved})
    except BindingError as error:
        raise DemonstrationError(demonstration.name, f"does not show what the others do: {error}") from error
    extra = [name for name in involved if name not in objects.values()]
    if extra:
        raise DemonstrationError(
            demonstration.name,
            f"shows {', '.join(extra)}, which the demonstrations before it lack",
            "all demonstrations of an action must show the same objects, or others with the same affordances",
        )
    return objects
