"""What can go wrong, by whose fault it is. Every message is one sentence: what, where, wanted, got."""


class InputError(Exception):
    """The user gave something that cannot be used: a file, a name, a value."""


class Fault(str):
    """A notice: what a file has wrong, though it changes no number. Strict reading makes an `InputError` of it."""

    __slots__ = ()


class SimulationError(Exception):
    """A component failed during the run; what was computed until then is kept."""


class DamageWarning(UserWarning):
    """A file is damaged, and what is whole of it was read."""
