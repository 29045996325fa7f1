"""What the compiled loop works on: arrays of indices, addresses and values; and the signs by which it answers."""

from __future__ import annotations

from collections import namedtuple

OK, SET, STEP, GET, NOT_FINITE, SAVE, RESTORE, NOT_CONVERGED = range(8)
"""What `advance` was doing when it stopped; OK: nothing wrong."""

ENDED, STOOD, TOO_LARGE, OUTSIDE = 16, 17, 18, 19
"""In the place of an FMI status: the component ends the simulation, returns early without getting on, does not hold a
value of its input, or answers with a status that the standard does not have."""

LAST_STATUS = 5
"""Largest status of FMI 2.0, "pending"; FMI 3.0 ends at "fatal", 4."""

Transfers = namedtuple(
    "Transfers",
    [
        "begin",  # (components + 1,) positions in `function`
        "function",  # (t,) addresses of the set or get functions
        "layout",  # (t,) data types of the values, positions in `loop_calls.LAYOUTS`
        "reference_begin",  # (t + 1,) positions in `reference`
        "size",  # (t,) numbers of values that the functions exchange
        "direct",  # (t,) whether these are doubles that stand in `u` or `y` side by side, in the same order
        "value_begin",  # (t + 1,) positions in `place` and `slot`
        "place",  # (v,) positions in `u` or `y`
        "slot",  # (v,) positions among the values that the function exchanges; variables that are one share them
        "reference",  # (r,) value references, uint32
    ],
)
"""The calls that set the inputs or get the outputs: one per component and type of variable."""

Values = namedtuple("Values", ["real", "word"])
"""Values as doubles and, where they are whole numbers, as integers of 64 bits; of the same length."""

Plan = namedtuple(
    "Plan",
    [
        "stage_begin",  # (stages + 1,) positions in `order`
        "order",  # (components,) components, stage by stage
        "handle",  # (components,) pointers to the instances
        "version",  # (components,) major version of FMI
        "period",  # (components,) communication steps that one step of a component takes
        "flexible",  # (components,) whether the size of a step may change
        "do_step",  # (components,) addresses of the functions that make a step
        "get_state",  # (components,) addresses of the functions that get the state
        "set_state",  # (components,) addresses of the functions that set the state
        "state",  # (components,) pointers to the states before the step
        "answer",  # (components, 2) what FMI 3.0 answers to a step: three flags and a time
        "inputs",  # Transfers
        "outputs",  # Transfers
        "u",  # (inputs,) values that the components hold
        "u_word",  # (inputs,) the same as whole numbers
        "y",  # (outputs,) latest outputs
        "y_word",  # (outputs,) the same as whole numbers
        "wide",  # positions in `y` of whole numbers of 64 bits, which are recorded as such
        "exact",  # (inputs,) whether an input is the whole number that feeds it
        "source",  # (inputs,) position in `y` of what feeds an input
        "gain",  # (inputs,) factor of the connection
        "offset",  # (inputs,) offset of the connection
        "share",  # (inputs,) share of the end of the step in what a component gets over it; 1: the latest
        "u_before",  # (inputs,) values at the start of the step
        "u_last",  # (inputs,) values of the sweep before
        "u_scale",  # (inputs, 2) nominal size, largest size so far
        "ending",  # (1,) component that asked to end the simulation with this step, -1: none
        "sweeps",  # (4,) most sweeps per step, sweeps made, most in a step, input that converges last
        "tolerance",  # (1,) change at which a sweep is the last, relative to the size
        "scratch",  # (longest transfer,) for values that are not doubles
        "bond_force",  # (bonds,) positions in `u` of forces on structures
        "bond_velocity",  # (bonds,) positions in `y` of the velocities that belong to them
        "bond_way",  # (bonds,) positions in `y` of the displacements that belong to them, -1: none
        "bond_gain",  # (bonds, 2) force times velocity, and force times displacement, to W and J
        "bond_owner",  # (bonds,) components that have the velocities
        "bond_before",  # (bonds, 2) velocity and displacement before the step
        "energy",  # (bonds, 2) energy that holding the forces adds, and energy into the structures [J]
    ],
)
"""Everything that the loop reads and writes, resolved to indices before the run."""
