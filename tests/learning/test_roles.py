import pytest

from sbam.errors import BindingError, UnknownNameError
from sbam.learning import Role, bind_roles
from sbam.learning.roles import role_name
from sbam.scene.object_library import ObjectLibrary

LIBRARY = ObjectLibrary.built_in()
POURER = Role("pour_from", ("place", "pour from"), True, ("apple_juice",))
VESSEL = Role("pour_into", ("place", "pour into"), True, ("cup_large",))
TABLE = Role("place_onto", ("place onto",), False, ("kitchen_sideboard",))


def scene(**names):
    return {name: LIBRARY[model] for name, model in names.items()}


def test_demonstrated_objects_are_preferred():
    objects = scene(a="milk_small", b="apple_juice", c="cup_small", d="cup_large", t="kitchen_sideboard")
    assert bind_roles([POURER, VESSEL, TABLE], objects) == {"pour_from": "b", "pour_into": "d", "place_onto": "t"}


def test_other_objects_with_the_same_affordances_take_part():
    objects = scene(milk="milk_small", cup="cup_small", table="kitchen_sideboard", pin="rolling_pin")
    assert bind_roles([POURER, VESSEL, TABLE], objects) == {
        "pour_from": "milk",
        "pour_into": "cup",
        "place_onto": "table",
    }


def test_fewest_affordances_that_are_not_needed():
    role = Role("place", ("place",), True, ())
    with pytest.raises(BindingError, match="both 'milk' and 'cup'"):
        bind_roles([role], scene(milk="milk_small", cup="cup_small"))
    from dataclasses import replace

    plain = replace(LIBRARY["cup_small"], affordance_regions=LIBRARY["cup_small"].affordance_regions[:1])
    assert bind_roles([role], {"milk": LIBRARY["milk_small"], "block": plain}) == {"place": "block"}


def test_what_is_lacking_and_what_is_there_is_said():
    with pytest.raises(BindingError, match=r"'pour_from'.*pour from.*apple_juice.*cup \(affords place, pour into\)"):
        bind_roles([POURER], scene(cup="cup_small"))
    with pytest.raises(BindingError, match="too few objects"):
        bind_roles([VESSEL, Role("pour_into_2", ("pour into",), False, ())], scene(cup="cup_small"))
    with pytest.raises(BindingError, match="no objects"):
        bind_roles([POURER], {})


def test_a_role_that_moves_needs_a_movable_object():
    fixed = Role("place_onto", ("place onto",), True, ())
    with pytest.raises(BindingError, match="not movable"):
        bind_roles([fixed], scene(table="kitchen_sideboard"))


def test_ambiguity_is_refused_and_can_be_resolved():
    objects = scene(one="cup_small", two="cup_small", juice="apple_juice")
    with pytest.raises(BindingError, match=r"both 'one' and 'two'.*name the object"):
        bind_roles([POURER, VESSEL], objects)
    assert bind_roles([POURER, VESSEL], objects, {"pour_into": "two"})["pour_into"] == "two"


def test_bad_choices():
    objects = scene(cup="cup_small", juice="apple_juice")
    with pytest.raises(UnknownNameError, match="unknown role 'cup'"):
        bind_roles([POURER], objects, {"cup": "cup"})
    with pytest.raises(UnknownNameError, match="unknown object 'jug'"):
        bind_roles([POURER], objects, {"pour_from": "jug"})
    with pytest.raises(BindingError, match=r"cannot play.*lacks 'pour from'"):
        bind_roles([POURER], objects, {"pour_from": "cup"})


def test_role_names():
    assert role_name(("place", "pour from"), ()) == "pour_from"
    assert role_name(("place",), ()) == "place"
    assert role_name(("place", "pour into"), ("pour_into",)) == "pour_into_2"
