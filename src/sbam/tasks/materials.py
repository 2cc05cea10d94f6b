"""Who touches whom, and the settings with which poured spheres neither tunnel nor boil."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import mujoco

TIMESTEP = 0.002  # s
CONTACT_TIME = 0.004  # s: time constant of a contact's spring, at least two steps
DENSITY = 1000.0  # kg/m^3, of spheres: water
FRICTION = 0.1  # of shells; spheres have none
OBJECT_FRICTION = 0.8
ROLLING_FRICTION = 2e-3  # m, of supports

_LEFT, _RIGHT, _OBJECT, _SUPPORT, _PARTICLE, _SHELL, _FOOT, _DOUGH = (1 << bit for bit in range(8))
LEFT = (_LEFT, _RIGHT | _OBJECT | _SUPPORT)
RIGHT = (_RIGHT, _LEFT | _OBJECT | _SUPPORT)
FOOT = (_FOOT, _OBJECT)
OBJECT = (_OBJECT, _LEFT | _RIGHT | _OBJECT | _SUPPORT | _SHELL)
SUPPORT = (_SUPPORT, _LEFT | _RIGHT | _OBJECT | _PARTICLE | _SHELL)
PARTICLE = (_PARTICLE, _PARTICLE | _SUPPORT | _SHELL)
SHELL = (_SHELL, _PARTICLE)
DOUGH = (_DOUGH, _OBJECT)
OPEN_SHELL = (_SHELL, _PARTICLE | _OBJECT | _LEFT | _RIGHT | _SUPPORT | _SHELL)
"""Contact bits (contype, conaffinity): who touches whom. Arms do not touch spheres, nor links of their own arm."""


def physics_options(spec: mujoco.MjSpec) -> None:
    """Set integrator, solver and contacts."""
    import mujoco

    option = spec.option
    option.timestep = TIMESTEP
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    option.cone = mujoco.mjtCone.mjCONE_PYRAMIDAL
    option.iterations, option.ls_iterations = 20, 10
    option.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP  # what stands still costs nothing
    spec.default.geom.solref = [CONTACT_TIME, 1.0]
    spec.default.geom.friction = [FRICTION, 0.001, 0.0001]


def add_sphere(spec: mujoco.MjSpec, index: int, radius: float, contype: int, conaffinity: int) -> None:
    """Add a sphere that moves freely, called ``particle/INDEX``.

    Its contacts have no friction, like a liquid's: a quarter of the equations, and a third of the time.
    """
    import mujoco

    body = spec.worldbody.add_body(name=f"particle/{index}")
    body.add_freejoint()
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[radius, 0.0, 0.0],
        density=DENSITY,
        condim=1,
        priority=1,
        contype=contype,
        conaffinity=conaffinity,
        rgba=[0.95, 0.55, 0.10, 1.0],
    )
