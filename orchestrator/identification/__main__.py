"""`python -m orchestrator.identification [inferred]`: identify a wheel anew and write its data.

Without a word the wheel class158, with the paper's friction law as printed (ten minutes); `inferred`: the wheel and the
law of the inferred cases (half an hour), `inferred alone` without what else is asked of Table 4.
"""

import sys

from fmus.wheel.inferred import MODES

from .data import write_identification
from .experiments import experiments
from .inferred import identify_inferred, inferred_misfit, write_inferred


def main(words: list[str]) -> int:
    """Do what the words ask for; return the exit code."""
    if not words:
        write_identification(report=print)
    elif words[0] == "inferred" and words[1:] in ([], ["alone"]):
        misfit = inferred_misfit()
        found = identify_inferred(misfit, report=print)
        more = experiments(misfit, found[0], print) if len(words) == 1 else ""
        write_inferred(MODES.parent, misfit, found, more)
    else:
        sys.stderr.write("usage: python -m orchestrator.identification [inferred [alone]]\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
