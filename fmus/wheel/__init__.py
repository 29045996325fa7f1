"""The wheel: modes of a wheelset at the contact point, as a modal component."""
