"""Commands about systems and FMUs: build, run, resume, info, export, check."""
