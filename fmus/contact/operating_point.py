"""The steady state of a running contact, moved while it runs: slowly varying creepages, load and friction. Kernel."""

from ..compile import kernel
from .law import law
from .layout import D
from .parameters import P


@kernel
def move_operating_point(parameters, derived, creepages, load, mu0):  # type: ignore[no-untyped-def]
    """Give the contact another steady state; wheel and rail go on to feel only what fluctuates about it.

    Parameters
    ----------
    creepages : (lon, lat, spin) steady creepages
    load : steady normal force [N]; the elastic constant of the Hertzian contact stays, so the steady approach follows
        the load to the power 2/3. The contact patch keeps its size.
    mu0 : Coulomb friction coefficient
    """
    if (
        creepages[0] == parameters[P.steady_creepage_lon]
        and creepages[1] == parameters[P.steady_creepage_lat]
        and creepages[2] == parameters[P.steady_creepage_spin]
        and load == parameters[P.normal_load]
        and mu0 == parameters[P.mu0]
    ):
        return
    derived[D.approach] *= (load / parameters[P.normal_load]) ** (2.0 / 3.0)
    parameters[P.hertz_stiffness] = 1.5 * load / derived[D.approach]
    parameters[P.steady_creepage_lon] = creepages[0]
    parameters[P.steady_creepage_lat] = creepages[1]
    parameters[P.steady_creepage_spin] = creepages[2]
    parameters[P.normal_load] = load
    parameters[P.mu0] = mu0
    derived[D.f_lon], derived[D.f_lat], derived[D.f_spin] = law(parameters, derived, 0.0, 0.0, 0.0, load)
