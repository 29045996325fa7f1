"""From one declaration to the files that other tools read: model description, FMU, system structure."""
