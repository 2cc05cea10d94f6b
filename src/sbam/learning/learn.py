"""Learning an action model from demonstrations (paper, section III-C; method.md, section 4)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from sbam.constraints import RegionPair, constraint_type
from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.loading import as_demonstration, as_demonstrations
from sbam.errors import DemonstrationError, SettingsError
from sbam.learning.anchors import AnchorSet, align_events, warp
from sbam.learning.binding import (
    Library,
    bind_demonstration,
    check_recording,
    demonstrated_models,
    involved_objects,
    new_roles,
    unknown_objects,
)
from sbam.learning.generalization import GeneralizedChange
from sbam.learning.hand_holds import hand_holds
from sbam.learning.incremental import add_candidates, first_demonstration
from sbam.learning.keypoints import keypoint_histogram, keypoint_times
from sbam.learning.model import ActionModel, Anchor, Role, Variant
from sbam.learning.pairs import pairs_that_move
from sbam.learning.settings import LearningSettings
from sbam.learning.sketch import ChannelCandidates, DemonstrationSketch, PairCandidates, sketch_demonstration
from sbam.learning.strokes import equalize_sketches
from sbam.learning.variants import order_groups
from sbam.scene.object_library import ObjectLibrary

Progress = Callable[[int, int], None]


def learn(
    demonstrations: Demonstration | str | Path | Sequence[Demonstration | str | Path],
    constraint: str = "cartesian",
    mode: str | None = None,
    library: Library | None = None,
    name: str | None = None,
    progress: Progress | None = None,
    settings: LearningSettings | None = None,
) -> ActionModel:
    """Learn a Spatial Bimanual Action Model.

    Args:
        demonstrations: one or more demonstrations of the same action, their files or folders, or ``built-in:NAME``.
        constraint: name of a constraint type: ``cartesian``, ``cylindrical``, ``symbolic``, or one of your own.
        mode: ``default`` or ``paper``; None: that of the settings, else ``default``.
        library: models of the objects; None: the built-in library.
        name: name of the action; None: that of the first demonstration.
        progress: called with the number of finished demonstrations and of all.
        settings: single choices; None: those of ``mode``.

    Returns:
        The model. In mode ``default`` it is the same as if the demonstrations had been added one by one.

    Raises:
        DemonstrationError: if there is no demonstration, nothing moves, or the objects do not correspond.
        SettingsError: if mode and settings contradict each other.
        UnknownNameError: for an unknown constraint type, mode or object.
        FileFormatError: if a file that is given cannot be used.
    """
    constraint_type(constraint)
    demonstrations = as_demonstrations(demonstrations)
    if settings is None:
        settings = LearningSettings.for_mode(mode or "default")
    elif mode not in (None, settings.mode):
        raise SettingsError("mode", mode, f"{settings.mode!r} as in the settings, or no mode beside settings")
    library = ObjectLibrary.built_in() if library is None else library
    if not demonstrations:
        raise DemonstrationError(name or "(none)", "there is nothing to learn from", "give one or more demonstrations")
    for demonstration in demonstrations:
        check_recording(demonstration)
    _check_objects(demonstrations, library, settings)
    model: ActionModel | None = None
    sketches: list[DemonstrationSketch] = []
    for done, demonstration in enumerate(demonstrations):
        sketch = _sketch(demonstration, sketches, library, constraint, settings)
        sketches.append(sketch)
        if not _keeps_candidates(settings):
            model = _extended(model, sketch, name or sketches[0].name, constraint, settings)
        if progress is not None:
            progress(done + 1, len(demonstrations))
    return model or _build(name or sketches[0].name, constraint, settings, tuple(sketches))


def add_demonstration(
    model: ActionModel, demonstration: Demonstration | str | Path, library: Library | None = None
) -> ActionModel:
    """The model with one more demonstration; the earlier recordings are not needed.

    Args:
        model: a model from `learn` or from a file; it is not changed.
        demonstration: another demonstration of the same action, its file, or ``built-in:NAME``.
        library: models of the objects; None: the built-in library.

    Raises:
        DemonstrationError: if it does not show the same roles.
    """
    library = ObjectLibrary.built_in() if library is None else library
    demonstration = as_demonstration(demonstration)
    sketch = _sketch(demonstration, model.demonstrations, library, model.constraint, model.settings, model.changes)
    if _keeps_candidates(model.settings):
        return _build(model.name, model.constraint, model.settings, (*model.demonstrations, sketch))
    return _extended(model, sketch, model.name, model.constraint, model.settings)


def with_variants(model: ActionModel) -> ActionModel:
    """The model with its variants learned anew, one for each order in which objects are taken and put back.

    Args:
        model: learned from all demonstrations.
    """
    sketches = model.demonstrations
    known = model.settings.variants and all(sketch.candidates for sketch in sketches)
    groups = order_groups(sketches) if known else np.zeros(len(sketches), dtype=int)
    if not groups.any():
        return replace(model, variants=())
    variants = []
    for group in range(groups.max() + 1):
        members = np.flatnonzero(groups == group)
        own = _generalize(model.name, model.constraint, model.settings, tuple(sketches[index] for index in members))
        variants.append(Variant(members, own.changes, own.anchors, own.keypoint_times, own.holds, own.notes))
    return replace(model, variants=tuple(variants))


def _keeps_candidates(settings: LearningSettings) -> bool:
    """Whether times may shift with further demonstrations, so that all must be generalised anew."""
    return settings.time_alignment != "seconds"


def _check_objects(demonstrations: Sequence[Demonstration], library: Library, settings: LearningSettings) -> None:
    """Name the demonstration that lacks an object, rather than the first one after it that has it."""
    involved = [involved_objects(demonstrated_models(d, library), settings) for d in demonstrations]
    most = max(range(len(involved)), key=lambda index: len(involved[index]))
    for demonstration, names in zip(demonstrations, involved, strict=True):
        if len(names) < len(involved[most]):
            missing = [object_name for object_name in involved[most] if object_name not in names]
            raise DemonstrationError(
                demonstration.name,
                f"lacks {', '.join(missing)} (or objects with the same affordances), which "
                f"{demonstrations[most].name!r} shows; it shows {', '.join(names) or 'no known affordances'}",
            )


def _sketch(
    demonstration: Demonstration,
    earlier: Sequence[DemonstrationSketch],
    library: Library,
    constraint: str,
    settings: LearningSettings,
    changes: Sequence[GeneralizedChange] = (),
) -> DemonstrationSketch:
    """What is kept of a demonstration; ``changes`` stand for the candidates that earlier ones may no longer have."""
    check_recording(demonstration)
    if any(demonstration.name == sketch.name for sketch in earlier):
        raise DemonstrationError(demonstration.name, "is in the model already", "rename it if it is another recording")
    models = demonstrated_models(demonstration, library)
    if earlier:
        objects = bind_demonstration(demonstration, models, [sketch.roles for sketch in earlier], settings)
    else:
        objects = new_roles(models, settings)
        if not objects:
            raise DemonstrationError(
                demonstration.name,
                f"no two of its objects belong together by their affordances; it shows {', '.join(models) or 'none'}",
            )
    sketch = sketch_demonstration(demonstration, objects, models, constraint, settings)
    if earlier:
        sketch = _of_known_pairs(sketch, earlier[0].candidates or changes, earlier[0].name)
    if not any(role.moves for role in sketch.roles):
        raise DemonstrationError(demonstration.name, f"none of its objects ({', '.join(objects.values())}) moves")
    notes = tuple(
        f"{name} of {demonstration.name} is not in the object library and does not move: left out"
        for name in unknown_objects(demonstration, library)
    )
    return replace(sketch, notes=notes)


def _of_known_pairs(
    sketch: DemonstrationSketch, known: Sequence[PairCandidates | GeneralizedChange], first: str
) -> DemonstrationSketch:
    """The sketch with the pairs that the first demonstration shows, in their order, and no others."""
    own = {candidates.pair: candidates for candidates in sketch.candidates}
    for pair, constraint, from_agent in ((one.pair, one.constraint, one.from_agent) for one in known):
        if pair not in own:
            problem = f"has objects that cannot be moved, or afford other things, than those of {first!r}"
        elif own[pair].from_agent != from_agent:
            problem = f"its support can be moved and that of {first!r} cannot, or the other way round"
        elif own[pair].constraint != constraint:
            problem = (
                f"is seen as {own[pair].constraint}, in {first!r} as {constraint}: the objects are built differently"
            )
        else:
            continue
        raise DemonstrationError(sketch.name, f"{pair}: {problem}", "learn them as two actions")
    return replace(sketch, candidates=tuple(own[one.pair] for one in known))


@dataclass(frozen=True)
class _TimeAxis:
    """Anchors of all demonstrations: times in their own time and on the model's."""

    anchors: AnchorSet
    model: Float[np.ndarray, " anchors"]


def _time_axis(sketches: Sequence[DemonstrationSketch], settings: LearningSettings) -> _TimeAxis:
    durations = [sketch.duration for sketch in sketches]
    if settings.time_alignment == "events":
        kinds = {"lift", "place", *settings.alignment_events}
        events = [[event for event in sketch.events if event.kind in kinds] for sketch in sketches]
        anchors = align_events(events, durations)
    else:
        times = np.column_stack([np.zeros(len(durations)), durations])
        anchors = AnchorSet(("start", "end"), (None, None), times)
    return _TimeAxis(anchors, anchors.mean_times)


def _build(
    name: str, constraint: str, settings: LearningSettings, sketches: tuple[DemonstrationSketch, ...]
) -> ActionModel:
    """A model of all sketches, with its variants."""
    return with_variants(_generalize(name, constraint, settings, sketches))


def _generalize(
    name: str, constraint: str, settings: LearningSettings, sketches: tuple[DemonstrationSketch, ...]
) -> ActionModel:
    """Generalise all sketches, in their order."""
    used, notes = sketches, ()
    if settings.time_alignment == "events" and settings.equalize_strokes:
        used, notes = equalize_sketches(sketches, settings)
    axis = _time_axis(used, settings)
    pairs = _watched_pairs(used, settings)
    changes: tuple[GeneralizedChange, ...] = ()
    for index, sketch in enumerate(used):
        candidates = [
            _aligned(candidate, axis.anchors.times[index], axis.model)
            for candidate in sketch.candidates
            if candidate.pair in pairs
        ]
        changes = _generalized(changes, candidates, index + 1, settings, axis.model)
    model = _assembled(name, constraint, settings, used, changes, axis)
    return replace(model, demonstrations=sketches, notes=notes + model.notes)


def _extended(
    model: ActionModel | None,
    sketch: DemonstrationSketch,
    name: str,
    constraint: str,
    settings: LearningSettings,
) -> ActionModel:
    """Update the generalised changes with one sketch, of which then only the frame is kept (the paper's way)."""
    earlier = model.demonstrations if model else ()
    sketches = (*earlier, sketch)
    pairs = {change.pair for change in model.changes} if model else set(_watched_pairs(sketches, settings))
    candidates = [candidate for candidate in sketch.candidates if candidate.pair in pairs]
    changes = _generalized(model.changes if model else (), candidates, len(sketches), settings, None)
    kept = tuple(sketch.without_candidates() for sketch in sketches)
    return _assembled(name, constraint, settings, kept, changes, _time_axis(kept, settings))


def _watched_pairs(sketches: Sequence[DemonstrationSketch], settings: LearningSettings) -> tuple[RegionPair, ...]:
    pairs = tuple(candidate.pair for candidate in sketches[-1].candidates)
    if settings.pairs == "all":
        return pairs
    return pairs_that_move(pairs, {role.role for sketch in sketches for role in sketch.roles if role.moves})


def _aligned(
    candidates: PairCandidates, own: Float[np.ndarray, " anchors"], model: Float[np.ndarray, " anchors"]
) -> PairCandidates:
    """The candidates on the model's time axis, with a knot at every anchor."""
    channels = []
    for channel in candidates.channels:
        time = np.union1d(channel.time, own)
        value = np.interp(time, channel.time, channel.value)
        channels.append(ChannelCandidates(warp(time, own, model), value))
    return replace(candidates, channels=tuple(channels))


def _generalized(
    changes: tuple[GeneralizedChange, ...],
    candidates: Sequence[PairCandidates],
    demonstrations: int,
    settings: LearningSettings,
    anchors: Float[np.ndarray, " anchors"] | None,
) -> tuple[GeneralizedChange, ...]:
    """Changes after one more demonstration; ``anchors`` are knots in both, None: only the ends belong together."""
    if not changes:
        return tuple(_first_change(candidate) for candidate in candidates)
    result = []
    for change, candidate in zip(changes, candidates, strict=True):
        assert (change.pair, change.constraint, change.from_agent) == (
            candidate.pair,
            candidate.constraint,
            candidate.from_agent,
        )
        channels = []
        for old, new in zip(change.channels, candidate.channels, strict=True):
            given = None if anchors is None else (_nearest(old.time, anchors), _nearest(new.time, anchors))
            channels.append(add_candidates(old, new.time, new.value, demonstrations, settings, given))
        result.append(replace(change, channels=tuple(channels)))
    return tuple(result)


def _first_change(candidates: PairCandidates) -> GeneralizedChange:
    kind = constraint_type(candidates.constraint)
    channels = tuple(
        first_demonstration(name, unit, channel.time, channel.value)
        for name, unit, channel in zip(kind.channel_names, kind.channel_units, candidates.channels, strict=True)
    )
    return GeneralizedChange(candidates.pair, candidates.constraint, channels, candidates.from_agent)


def _nearest(time: Float[np.ndarray, " samples"], wanted: Float[np.ndarray, " anchors"]) -> Int[np.ndarray, " anchors"]:
    """Index of the time nearest to each of the wanted ones, up to rounding equal to it."""
    return np.abs(time[:, None] - wanted).argmin(axis=0)


def _assembled(
    name: str,
    constraint: str,
    settings: LearningSettings,
    sketches: tuple[DemonstrationSketch, ...],
    changes: tuple[GeneralizedChange, ...],
    axis: _TimeAxis,
) -> ActionModel:
    anchors = tuple(
        Anchor(kind, role, float(time))
        for kind, role, time in zip(axis.anchors.kinds, axis.anchors.roles, axis.model, strict=True)
    )
    duration = float(axis.model[-1])
    histogram = keypoint_histogram(changes, duration, settings)
    roles = _roles(sketches, changes)
    named = {role.name for role in roles}
    holds = hand_holds(sketches, axis.anchors, axis.model)
    unwatched = tuple(
        f"the {hold.hand} hand holds {hold.role}, which is in no watched pair: this is no part of the action"
        for hold in holds
        if hold.role not in named
    )
    return ActionModel(
        name=name,
        constraint=constraint,
        mode=settings.mode,
        roles=roles,
        changes=changes,
        anchors=anchors,
        keypoint_times=keypoint_times(histogram, axis.model),
        holds=tuple(hold for hold in holds if hold.role in named),
        synthetic=any(sketch.synthetic for sketch in sketches),
        demonstrations=sketches,
        settings=settings,
        notes=axis.anchors.notes + unwatched + tuple(note for sketch in sketches for note in sketch.notes),
    )


def _roles(sketches: Sequence[DemonstrationSketch], changes: Sequence[GeneralizedChange]) -> tuple[Role, ...]:
    """The roles that take part in a watched pair."""
    regions = {region for change in changes for region in (change.pair.first, change.pair.second) if region is not None}
    result = []
    for name in (role.role for role in sketches[0].roles):
        played = [role for sketch in sketches for role in sketch.roles if role.role == name]
        affordances = tuple(sorted(region.affordance for region in regions if region.role == name))
        if affordances:
            moves = any(role.moves for role in played)
            result.append(Role(name, affordances, moves, tuple(sorted({role.object for role in played}))))
    return tuple(result)
