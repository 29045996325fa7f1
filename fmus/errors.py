"""The error of the components: data that cannot be what they are given for."""


class DataError(ValueError):
    """Data is wrong: the message says what, where, what was wanted and what came.

    Only this is a mistake of the user's. Any other exception from these packages is a fault of theirs.
    """
