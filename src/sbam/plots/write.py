"""Writing all figures of a model or of a plan into a folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from sbam.constraints import RegionPair, Symbolic, constraint_type
from sbam.demonstrations.demonstration import Demonstration
from sbam.learning.binding import Library, bind_demonstration, demonstrated_models
from sbam.learning.generalization import pair_vector
from sbam.learning.model import ActionModel
from sbam.learning.pairs import against_support
from sbam.learning.sketch import constraint_values
from sbam.planning.plan import Plan
from sbam.plots.constraints import plot_spatial_relations
from sbam.plots.learning import plot_generalized_changes, plot_keypoints, plot_segmentation
from sbam.plots.planning import plot_comparison, plot_scene_path, plot_trajectory
from sbam.plots.style import save_figure
from sbam.scene import ObjectLibrary

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_plan_plots(plan: Plan, folder: str | Path) -> list[Path]:
    """Write ``comparison.png``, ``trajectory.png`` and ``scene_path.png``.

    Args:
        plan: the plan.
        folder: where to; made if needed.

    Returns:
        The files.

    Raises:
        OutputError: if a file cannot be written.
    """
    figures = {
        "comparison": plot_comparison(plan),
        "trajectory": plot_trajectory(plan),
        "scene_path": plot_scene_path(plan),
    }
    return _write(figures, folder)


def write_model_plots(
    model: ActionModel,
    folder: str | Path,
    demonstrations: Sequence[Demonstration] = (),
    library: Library | None = None,
) -> list[Path]:
    """Write ``generalized_changes.png``, ``keypoints.png``, and what else there is to see of a model.

    That is ``spatial_relations.png`` for symbolic models and, if a demonstration is at hand, ``segmentation.png``: the
    steps of the segmentation of one of its channels.

    Args:
        model: the model.
        folder: where to; made if needed.
        demonstrations: recordings that the model was learned from; the first one is shown.
        library: models of their objects; None: the built-in library.

    Returns:
        The files.

    Raises:
        OutputError: if a file cannot be written.
        DemonstrationError: if a demonstration does not show the model's roles.
    """
    figures = {"generalized_changes": plot_generalized_changes(model), "keypoints": plot_keypoints(model)}
    if isinstance(constraint_type(model.constraint), Symbolic):
        figures["spatial_relations"] = plot_spatial_relations()
    for demonstration in demonstrations[:1]:
        figures["segmentation"] = _segmentation(model, demonstration, library)
    return _write(figures, folder)


def _segmentation(model: ActionModel, demonstration: Demonstration, library: Library | None) -> Figure:
    """Segmentation of the liveliest channel of the first pair, which is one that the action is about; no angle."""
    change = model.changes[0]
    values = demonstrated_channels(model, demonstration, change.pair, change.constraint, library)
    straight = [channel.unit != "rad" for channel in change.channels]
    liveliest = int(np.argmax(np.where(straight, np.ptp(values, axis=0), -1.0)))
    channel = change.channels[liveliest]
    return plot_segmentation(
        demonstration.time - demonstration.time[0],
        values[:, liveliest],
        f"{change.pair}, {channel.name}",
        channel.unit,
        model.settings,
        demonstration.synthetic,
    )


def demonstrated_channels(
    model: ActionModel,
    demonstration: Demonstration,
    pair: RegionPair,
    constraint: str,
    library: Library | None = None,
) -> Float[np.ndarray, "samples channels"]:
    """Channels of a pair in a recording, sample by sample; azimuths unwrapped along time.

    Args:
        model: says which roles there are.
        demonstration: the recording.
        pair: the two regions.
        constraint: constraint type.
        library: models of the recording's objects; None: the built-in library.
    """
    models = demonstrated_models(demonstration, ObjectLibrary.built_in() if library is None else library)
    roles = [sketch.roles for sketch in model.demonstrations]
    objects: Mapping[str, str] = bind_demonstration(demonstration, models, roles, model.settings)
    T_agent_world = demonstration.T_world_agent.inv()
    paths = []
    for reference in (pair.first, pair.second):
        if reference is None:
            paths.append(paths[0][:1])
            continue
        name = objects[reference.role]
        poses = T_agent_world * demonstration.T_world_object[name]
        paths.append(poses.apply(models[name].region(reference.affordance).center))
    role_models = {role: models[name] for role, name in objects.items()}
    from_agent = against_support(pair, role_models, model.settings)
    return constraint_values(constraint, pair_vector(paths[0], paths[1], from_agent))


def _write(figures: Mapping[str, Figure], folder: str | Path) -> list[Path]:
    paths = []
    for name, figure in figures.items():
        path = Path(folder) / f"{name}.png"
        save_figure(figure, path)
        paths.append(path)
    return paths
