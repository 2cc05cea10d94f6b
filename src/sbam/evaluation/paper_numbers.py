"""The paper's own numbers: Tables II and III."""

from __future__ import annotations

PAPER_DATA = "real recordings of the KIT Bimanual Manipulation Dataset, simulated humanoids, solver of the paper"
"""What the paper's numbers are on."""

CONSTRAINTS = ("cartesian", "cylindrical", "symbolic")
"""Columns of `PAPER_TABLES`: the paper's CaAC, CyAC and SSAC."""

_TABLE, _CUP, _RIM = "place onto of table", "place of cup", "pour into of cup"
_MOUTH, _BOTTLE = "pour from of bottle", "place of bottle"
_LEFT, _RIGHT = "left handle of pin", "right handle of pin"

PLACES = {
    ("place_onto", "place onto"): _TABLE,
    ("pour_into", "place"): _CUP,
    ("pour_into", "pour into"): _RIM,
    ("pour_from", "pour from"): _MOUTH,
    ("pour_from", "place"): _BOTTLE,
    ("handle_left", "handle left"): _LEFT,
    ("handle_left", "handle right"): _RIGHT,
}
"""(role, affordance) -> the paper's name of the region."""

PAPER_TABLES: dict[str, dict[tuple[str, str], dict[str, tuple[float, float, float]]]] = {
    "pouring": {
        (_TABLE, _CUP): {
            "cartesian": (135.233, 123.702, 10.385),
            "cylindrical": (132.965, 131.112, 10.379),
            "symbolic": (155.870, 138.069, 10.363),
        },
        (_TABLE, _RIM): {
            "cartesian": (136.563, 136.543, 9.445),
            "cylindrical": (132.257, 144.325, 9.442),
            "symbolic": (157.483, 155.158, 9.454),
        },
        (_TABLE, _MOUTH): {
            "cartesian": (175.586, 203.581, 0.444),
            "cylindrical": (176.766, 203.715, 0.444),
            "symbolic": (190.240, 191.454, 0.444),
        },
        (_TABLE, _BOTTLE): {
            "cartesian": (214.453, 216.694, 0.396),
            "cylindrical": (216.057, 219.126, 0.396),
            "symbolic": (218.582, 218.675, 0.396),
        },
        (_CUP, _RIM): {
            "cartesian": (23.087, 22.889, 0.208),
            "cylindrical": (22.072, 21.133, 0.208),
            "symbolic": (24.532, 29.096, 0.208),
        },
        (_CUP, _MOUTH): {
            "cartesian": (174.932, 211.721, 1.849),
            "cylindrical": (176.445, 221.118, 1.575),
            "symbolic": (180.333, 214.044, 2.708),
        },
        (_CUP, _BOTTLE): {
            "cartesian": (182.554, 192.510, 7.894),
            "cylindrical": (182.544, 200.068, 7.327),
            "symbolic": (197.645, 208.331, 5.384),
        },
        (_RIM, _MOUTH): {
            "cartesian": (165.770, 208.665, 3.357),
            "cylindrical": (169.718, 218.626, 1.805),
            "symbolic": (173.982, 215.371, 1.963),
        },
        (_RIM, _BOTTLE): {
            "cartesian": (172.947, 184.193, 1.688),
            "cylindrical": (175.450, 193.651, 7.585),
            "symbolic": (189.538, 203.633, 2.313),
        },
        (_MOUTH, _BOTTLE): {
            "cartesian": (123.095, 97.722, 0.621),
            "cylindrical": (121.581, 94.565, 0.621),
            "symbolic": (133.062, 93.486, 0.621),
        },
    },
    "rolling": {
        (_LEFT, _RIGHT): {
            "cartesian": (8.762, 5.996, 0.782),
            "cylindrical": (11.802, 22.036, 1.552),
            "symbolic": (12.006, 12.215, 1.387),
        },
        (_LEFT, _TABLE): {
            "cartesian": (134.810, 72.513, 21.103),
            "cylindrical": (134.788, 87.605, 25.146),
            "symbolic": (115.850, 71.209, 17.747),
        },
        (_RIGHT, _TABLE): {
            "cartesian": (135.882, 75.134, 21.034),
            "cylindrical": (136.227, 90.163, 29.437),
            "symbolic": (118.420, 74.384, 15.387),
        },
    },
}
"""Task -> pair -> constraint type -> average, standard deviation and minimum, mm (Tables II and III)."""


PAPER_OBJECTS = {"apple_juice", "cup_large", "cup_small", "kitchen_sideboard", "milk_small", "rolling_pin"}
"""Object models of the paper's demonstrations; its numbers say nothing of tasks with others."""


def paper_row(pair: str) -> tuple[str, tuple[str, str]] | None:
    """Task and row of the paper's tables for one of our pairs (its text), in either order; None if it has none."""
    names = {f"{affordance} of {role}": place for (role, affordance), place in PLACES.items()}
    ends = [names.get(end) for end in pair.split(" -> ")]
    for task, table in PAPER_TABLES.items():
        for row in table:
            if set(row) == set(ends):
                return task, row
    return None
