"""Synthetic pouring: the left hand takes the cup, the right hand pours from a bottle or carton, both are put back.

The person is taken to plan as people do, from what is to be done and not from any constraint: the cup is brought to a
comfortable place, the mouth of the bottle is led beside and then over the rim while the bottle tilts about it, and
eyes and hand keep the mouth over the rim while liquid flows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.demonstration import Demonstration, Hand, Label
from sbam.demonstrations.synthetic.motion import (
    PEAK_SPEED_RATIO,
    UP,
    SubMovement,
    about,
    between,
    lean,
    minimum_jerk,
    put_back,
    reach,
    sample_times,
    standing_still,
    superpose,
    upright,
    wander,
)
from sbam.demonstrations.synthetic.person import (
    PERSONS,
    TABLE,
    HandTimes,
    Person,
    palm_towards,
    rest_pose,
    stand_at_table,
    take_and_leave,
)
from sbam.scene.object_library import ObjectLibrary
from sbam.scene.object_model import ObjectModel


@dataclass(frozen=True)
class PouringLayout:
    """What is poured into what, and where the bottle stands as seen from the cup.

    Attributes:
        name: for the demonstration's name.
        bottle: object with the affordances ``pour from`` and ``place``.
        cup: object with the affordances ``pour into`` and ``place``.
        angle: direction from cup to bottle, rad from the agent's right towards its front.
        distance: from cup to bottle, m.
    """

    name: str
    bottle: str
    cup: str
    angle: float
    distance: float


JUICE_LAYOUTS = (
    PouringLayout("juice_right", "apple_juice", "cup_large", 0.0, 0.20),
    PouringLayout("juice_right_away", "apple_juice", "cup_large", np.pi / 4, 0.40),
    PouringLayout("juice_left", "apple_juice", "cup_large", np.pi, 0.30),
)
MILK_LAYOUT = PouringLayout("milk_right", "milk_small", "cup_small", 0.0, 0.20)


FLOWING = np.deg2rad(60.0)
"""Tilt above which liquid is taken to flow, rad; the mouth leaves the rim only as it stops."""


@dataclass(frozen=True)
class _Schedule:
    """Onsets and durations of the sub-movements, s."""

    left: HandTimes
    right: HandTimes
    cup_raise: tuple[float, float]
    cup_lower: tuple[float, float]
    carry: tuple[float, float]
    tilt: tuple[float, float]
    tilt_back: tuple[float, float]
    leave: tuple[float, float]
    carry_back: tuple[float, float]
    end: float


def generate_pouring(
    layout: PouringLayout, seed: int, person: Person = PERSONS[0], library: ObjectLibrary | None = None
) -> Demonstration:
    """A synthetic demonstration of pouring.

    Args:
        layout: which objects, and where they stand.
        seed: the same seed gives the same demonstration.
        person: who demonstrates.
        library: where the objects' regions and sizes come from; the built-in one if None.

    Returns:
        A demonstration at 100 Hz with both hands and labels; objects rest exactly on the table before they are lifted
        and after they are placed.

    Raises:
        UnknownNameError: if the library lacks an object, or an object lacks an affordance.
    """
    library = ObjectLibrary.built_in() if library is None else library
    bottle, cup, table = library[layout.bottle], library[layout.cup], library[TABLE]
    rng = np.random.default_rng([seed, 0])
    across = np.cos(layout.angle) < -0.3  # the right hand must fetch the bottle from beyond the cup
    tilt = np.deg2rad(rng.uniform(79.0, 104.0))
    schedule = _schedule(rng, person, layout, across, tilt)
    time = sample_times(schedule.end)

    offset = 0.5 * layout.distance * np.array([np.cos(layout.angle), np.sin(layout.angle), 0.0])
    middle = np.array([0.02, 0.45 * person.scale, 0.0])
    cup_start = middle - offset + rng.normal(0.0, (0.006, 0.006, 0.0))
    bottle_start = middle + offset + rng.normal(0.0, (0.006, 0.006, 0.0))
    T_agent_cup = _cup_motion(rng, time, schedule, person, cup, cup_start)
    T_agent_bottle = _bottle_motion(rng, time, schedule, bottle, cup, T_agent_cup, bottle_start, tilt, across)
    hands = _hands(rng, time, schedule, person, {"left": (cup, T_agent_cup), "right": (bottle, T_agent_bottle)}, across)

    T_world_table, T_world_agent = stand_at_table(rng, table)
    return Demonstration(
        name=f"synthetic_pouring_{layout.name}_{seed}",
        time=time,
        T_world_object={
            layout.cup: T_world_agent * T_agent_cup,
            layout.bottle: T_world_agent * T_agent_bottle,
            TABLE: standing_still(T_world_table, len(time)),
        },
        T_world_hand={hand: T_world_agent * pose for hand, pose in hands.items()},
        T_world_agent=T_world_agent,
        labels=_labels(schedule, layout),
        synthetic=True,
        source=f"synthetic: generate_pouring(layout={layout.name!r}, seed={seed}, person={person.name!r})",
        notes=("generated by the project, not recorded from a person",),
    )


def _schedule(rng: np.random.Generator, person: Person, layout: PouringLayout, across: bool, tilt: float) -> _Schedule:
    """Draw when everything happens; hands are asynchronous, in 0.1 to 0.7 s."""
    draw = rng.uniform
    tempo = person.tempo * draw(0.93, 1.06)
    first_lift = draw(1.25, 1.7) * tempo + (0.1 if across else 0.0)
    way = layout.distance + (0.35 if across else 0.0)
    carry = (0.60 + 0.95 * way) * draw(0.9 if across else 0.8, 1.1) * tempo
    if across:
        bottle_lift, cup_lift = first_lift, first_lift + carry * draw(0.45, 0.55) + 0.8 * tempo
    else:
        cup_lift, bottle_lift = first_lift, first_lift + draw(0.1, 0.85) * tempo
    raise_cup = draw(1.35, 1.65) * tempo * (0.92 if across else 1.0)
    tilt_up = PEAK_SPEED_RATIO * tilt / np.deg2rad(draw(170.0, 245.0))
    tilt_down = PEAK_SPEED_RATIO * tilt / np.deg2rad(draw(170.0, 245.0))
    # The tilt begins under way, but the mouth must have arrived, and the cup nearly so, before liquid flows.
    arrival = draw(0.25, 0.52) * tilt_up
    tilt_on = max(
        bottle_lift + draw(0.15, 0.9) * tempo,
        bottle_lift + carry - arrival,
        cup_lift + raise_cup - 0.6 * tilt_up,
    )
    if not across:  # across, the bottle waits beside the cup; else people slow down rather than wait
        carry = tilt_on + arrival - bottle_lift
    back_on = tilt_on + tilt_up + draw(0.5, 1.1 if across else 1.6)
    lower_on, lower = back_on + draw(0.2, 0.45) + (0.2 if across else 0.0), draw(1.15, 1.45) * tempo
    cup_place = lower_on + lower
    carry_back = (0.72 + 0.75 * way) * draw(0.9, 1.15) * tempo
    stops = back_on + tilt_down * _phase(1.0 - FLOWING / tilt)
    leave_on = stops - draw(0.24, 0.28) * tilt_down
    down_on = cup_place + draw(0.2, 0.35) if across else stops + tilt_down * draw(0.0, 0.2)
    bottle_place = down_on + carry_back

    def hand(lift: float, place: float, way: float) -> HandTimes:
        grasp, leave = lift - draw(0.12, 0.3), place + draw(0.12, 0.3)
        reach_time, retreat_time = (0.55 + 1.0 * way) * tempo * draw(0.9, 1.15, 2)
        return HandTimes(grasp - reach_time, grasp, lift, place, leave, leave + retreat_time)

    left, right = (
        hand(cup_lift, cup_place, 0.4 if across else 0.25),
        hand(bottle_lift, bottle_place, 0.5 if across else 0.3),
    )
    return _Schedule(
        left,
        right,
        cup_raise=(cup_lift, raise_cup),
        cup_lower=(lower_on, lower),
        carry=(bottle_lift, carry),
        tilt=(tilt_on, tilt_up),
        tilt_back=(back_on, tilt_down),
        leave=(leave_on, (1.35 if across else 1.15) * tilt_down),
        carry_back=(down_on, carry_back),
        end=max(left.rest, right.rest) + draw(0.2, 0.5 if across else 0.8),
    )


def _phase(progress: float) -> float:
    """When a minimum-jerk movement has made that progress (0 to 1), as a fraction of its duration."""
    phase = np.linspace(0.0, 1.0, 201)
    return float(np.interp(progress, minimum_jerk(phase, 0.0, 1.0), phase))


def _cup_motion(
    rng: np.random.Generator,
    time: NDArray[np.float64],
    schedule: _Schedule,
    person: Person,
    cup: ObjectModel,
    start: NDArray[np.float64],
) -> RigidTransform:
    """The cup is dragged off towards the body, raised, held still, and put back; agent frame."""
    (lift, raise_time), (lower_on, lower) = schedule.cup_raise, schedule.cup_lower
    rim_height = float(cup.up @ (cup.region("pour into").center - cup.region("place").center))
    rim = np.array([-0.01, 0.37 * person.scale, rng.normal(0.345, 0.012) * person.scale])
    pouring = rim - rim_height * UP + 0.35 * (start - (-0.08, 0.45, 0.0)) * (1.0, 1.0, 0.0)
    pouring += rng.normal(0.0, (0.012, 0.012, 0.0))
    drag = np.array([rng.normal(0.0, 0.01), -rng.uniform(0.02, 0.11), rng.uniform(0.02, 0.06)])
    then = rng.uniform(0.15, 0.35)
    movements = [
        SubMovement(lift, 0.5 * raise_time, drag),
        *reach(rng, lift + then * raise_time, (1.0 - then) * raise_time, pouring - start - drag),
        *reach(rng, lower_on, lower, put_back(rng, start) - pouring, horizontal=(0.0, 0.85), detour=(0.0, -0.015, 0.0)),
    ]
    held = between(time, (lift, 0.5), (lower_on + lower - 0.5, 0.5))[:, None]
    position = superpose(time, start, movements)
    position += held * (wander(rng, time, 0.0015, (0.1, 0.5)) + wander(rng, time, 0.00007, (6.0, 11.0)))
    while_lifted = between(time, (lift, 0.45 * raise_time), (lift + 0.4 * raise_time, 0.8 * raise_time))
    while_pouring = between(time, schedule.tilt, schedule.tilt_back)
    tilt = (
        lean(np.deg2rad(rng.uniform(-130.0, -60.0)), np.deg2rad(rng.uniform(4.0, 17.0)) * while_lifted)
        + lean(np.deg2rad(rng.normal(0.0, 20.0)), np.deg2rad(rng.uniform(2.0, 6.0)) * while_pouring)
        + held * wander(rng, time, np.deg2rad(0.5), (0.1, 0.6))
    )
    yaw = rng.uniform(-np.pi, np.pi) + np.deg2rad(rng.normal(0.0, 5.0)) * minimum_jerk(time, lift, lower_on - lift)
    turn = Rotation.from_rotvec(tilt) * about("z", yaw) * upright(cup.up)
    return _standing_on_edge(cup, position, turn)


def _bottle_motion(
    rng: np.random.Generator,
    time: NDArray[np.float64],
    schedule: _Schedule,
    bottle: ObjectModel,
    cup: ObjectModel,
    T_agent_cup: RigidTransform,
    start: NDArray[np.float64],
    tilt: float,
    across: bool,
) -> RigidTransform:
    """The mouth is led to the rim and the bottle tilts about it; agent frame."""
    (tilt_on, tilt_up), (back_on, tilt_down) = schedule.tilt, schedule.tilt_back
    rim_path = T_agent_cup.apply(cup.region("pour into").center)
    during = (time > tilt_on + 0.5 * tilt_up) & (time < back_on)
    rim = rim_path[during].mean(axis=0)

    # Offsets of the mouth from the rim: beside it, over it, beside it again.
    poured_to = np.pi + rng.normal(0.0, np.deg2rad(7.0))
    side = -np.array([np.cos(poured_to), np.sin(poured_to), 0.0])
    aside = np.array([-side[1], side[0], 0.0])
    beside = rng.uniform(0.07, 0.10) * side + rng.uniform(0.045, 0.07) * UP
    over = rng.uniform(0.013, 0.024) * side + rng.normal(0.0, 0.003) * aside + rng.uniform(0.031, 0.038) * UP
    beside_again = rng.uniform(0.10, 0.13) * side + rng.uniform(0.04, 0.06) * UP

    mouth_local = bottle.region("pour from").center
    height = float(bottle.up @ (mouth_local - bottle.region("place").center))
    mouth_start = start + height * UP
    mouth_end = put_back(rng, start) + height * UP
    detour = np.array([rng.normal(0.0, 0.01), -rng.uniform(0.0, 0.025), 0.01])
    waiting, clear = beside, beside_again
    if across:  # past the cup on the person's side, to the right of it, and there wait for the cup
        waiting = clear = np.array([0.20, 0.02, 0.03])
        detour += (0.0, -0.10, 0.05)
    approach = tilt_on - 0.45 * tilt_up, 1.0 * tilt_up
    movements = [
        *reach(rng, *schedule.carry, rim + waiting - mouth_start, horizontal=(0.12, 1.0), detour=detour),
        SubMovement(tilt_on - rng.uniform(0.02, 0.1), 0.85 * tilt_up, over - beside),
        SubMovement(*schedule.leave, clear - over),
        *reach(
            rng,
            *schedule.carry_back,
            mouth_end - rim - clear,
            horizontal=(0.0, 0.82),
            vertical=(0.25 if across else 0.1, 1.0),
            detour=detour * (1.0, 1.0, 0.5),
        ),
    ]
    if across:
        movements.append(SubMovement(*approach, beside - waiting))
    mouth = superpose(time, mouth_start, movements)
    looked_at = between(time, (tilt_on - 0.3, 0.3 + 0.4 * tilt_up), (back_on + 0.35 * tilt_down, 0.5))
    mouth += looked_at[:, None] * (rim_path - rim)
    lift, place = schedule.right.lift, schedule.right.place
    held = between(time, (lift, 0.5), (place - 0.5, 0.5))[:, None]
    mouth += held * (wander(rng, time, 0.0012, (0.2, 0.8)) + wander(rng, time, 0.00008, (6.0, 11.0)))

    share = rng.uniform(0.90, 0.97)  # the rest follows slowly, as the bottle empties
    course = share * minimum_jerk(time, tilt_on, tilt_up)
    course += (1.0 - share) * minimum_jerk(time, tilt_on + 0.6 * tilt_up, back_on - tilt_on - 0.6 * tilt_up)
    course *= 1.0 - minimum_jerk(time, back_on, tilt_down)
    yaw = np.deg2rad(rng.normal(0.0, 6.0)) + np.deg2rad(rng.normal(0.0, 4.0)) * minimum_jerk(time, lift, place - lift)
    yaw += np.deg2rad(rng.normal(0.0, 6.0)) * between(time, (lift, tilt_on - lift + 0.3), (back_on, place - back_on))
    turn = (
        Rotation.from_rotvec(lean(poured_to, tilt * course))
        * Rotation.from_rotvec(held * wander(rng, time, np.deg2rad(0.7), (0.1, 0.7)))
        * about("z", yaw)
        * upright(bottle.up)
    )
    return RigidTransform.from_components(mouth - turn.apply(mouth_local), turn)


def _standing_on_edge(model: ObjectModel, position: NDArray[np.float64], turn: Rotation) -> RigidTransform:
    """Poses whose base, however it leans, touches the planned height with its lowest edge.

    Args:
        model: object with a ``place`` region.
        position: (T, 3) planned place of the base's centre, agent frame, m.
        turn: T rotations.
    """
    place = model.region("place")
    sine = np.linalg.norm(turn.apply(model.up)[:, :2], axis=1)
    raised = position + sine[:, None] * (float(place.half_axes.max()) * UP)
    return RigidTransform.from_components(raised - turn.apply(place.center), turn)


def _hands(
    rng: np.random.Generator,
    time: NDArray[np.float64],
    schedule: _Schedule,
    person: Person,
    held: dict[Hand, tuple[ObjectModel, RigidTransform]],
    across: bool,
) -> dict[Hand, RigidTransform]:
    """Both hands: from rest to the object, rigid on it while it moves, back to rest; agent frame."""
    poses: dict[Hand, RigidTransform] = {}
    for hand, (model, T_agent_object) in held.items():
        times = schedule.left if hand == "left" else schedule.right
        grasp = model.grasp_regions[0]
        facing = np.deg2rad(rng.normal(25.0, 8.0) if hand == "left" else rng.normal(60.0 if across else 170.0, 8.0))
        palm = palm_towards(hand, float(facing), np.deg2rad(rng.normal(8.0, 3.0)))
        first = T_agent_object[0]
        on_axis = grasp.center + rng.uniform(-0.5, 0.5) * grasp.half_length * grasp.axis
        position = first.apply(on_axis) - (0.5 * grasp.width + 0.018) * palm.as_matrix()[:, 2]
        T_object_hand = first.inv() * RigidTransform.from_components(position, palm)
        rest = rest_pose(rng, person, hand), rest_pose(rng, person, hand)
        detour = np.array([0.0, -0.01, rng.uniform(0.015, 0.05)])
        if across:  # around the cup, or around the way of the bottle
            detour += (0.0, -0.05, 0.10 if hand == "right" else 0.0)
        poses[hand] = take_and_leave(rng, time, times, rest, T_agent_object * T_object_hand, detour)
    return poses


def _labels(schedule: _Schedule, layout: PouringLayout) -> tuple[Label, ...]:
    left, right = schedule.left, schedule.right
    raised, tilted_back = sum(schedule.cup_raise), sum(schedule.tilt_back)
    pour = schedule.tilt[0] + 0.3 * schedule.tilt[1], tilted_back - 0.5 * schedule.tilt_back[1]
    phases: list[tuple[Hand, str, float, float, str]] = [
        ("left", "approach", left.start, left.grasp, layout.cup),
        ("left", "grasp", left.grasp, left.lift, layout.cup),
        ("left", "lift", left.lift, raised, layout.cup),
        ("left", "hold", raised, schedule.cup_lower[0], layout.cup),
        ("left", "place", schedule.cup_lower[0], left.leave, layout.cup),
        ("left", "retreat", left.leave, left.rest, ""),
        ("right", "approach", right.start, right.grasp, layout.bottle),
        ("right", "grasp", right.grasp, right.lift, layout.bottle),
        ("right", "lift", right.lift, pour[0], layout.bottle),
        ("right", "pour", *pour, layout.cup),
        ("right", "place", pour[1], right.leave, layout.bottle),
        ("right", "retreat", right.leave, right.rest, ""),
    ]
    return tuple(Label(hand, start, end, action, target) for hand, action, start, end, target in phases)
