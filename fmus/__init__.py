"""The components of the wheel/rail system: physics, contract and FMU packaging."""
