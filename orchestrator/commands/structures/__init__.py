"""Commands about rails and wheels: data in, modes and FMUs out."""
