# %% [markdown]
# # A squealing wheel, by hand
#
# A notebook in plain Python: every `# %%` begins a cell (Jupyter with jupytext, VS Code, PyCharm and Spyder show it
# so), and `python examples/squeal_by_hand.py` runs it from top to bottom.
#
# Case 1 of the paper, half a second from small random modal velocities: run, look, listen.

# %%
from pathlib import Path
from tempfile import mkdtemp

import numpy as np

from orchestrator.results.file import open_results
from orchestrator.runs.run import Report, run_scenario
from orchestrator.runs.scenario import Scenario
from orchestrator.signals.limit_cycle import growth_of, limit_cycle
from orchestrator.signals.spectra import a_weighted, level, narrow_band, third_octaves
from orchestrator.sound.levels import REFERENCE_PRESSURE, sound_of
from orchestrator.sound.wav import pressure_of, write_wav
from orchestrator.stability.linear_model import model_of

folder = Path(mkdtemp())
outcome = run_scenario(Scenario("case1", duration=0.5, seed=0), folder, Report())

# %% [markdown]
# The results are an xarray dataset: every signal has a name, a unit and a description.

# %%
data = open_results(outcome.results)
velocity = data["wheel.v_lat"]
assert velocity.attrs["units"] == "m/s"
print(velocity.attrs["long_name"], "in", velocity.attrs["units"], "over", float(data["time"][-1]), "s")

# %% [markdown]
# **Spectra and bands** work on any signal with a time axis. The lines of a narrow-band spectrum add up to its mean
# square.

# %%
lines = narrow_band(velocity, resolution_hz=4.0)
bands = third_octaves(lines, lowest_hz=200.0)
print(level(bands, reference=5e-8).to_series().round(1))  # velocity level re 50 nm/s

# %% [markdown]
# **Growth.** The run knows its linear model: while the vibration is small it grows as the poles say.

# %%
model = model_of(data)
assert model is not None
for growth in growth_of(data, model.poles):
    print(f"{growth.frequency_hz:7.1f} Hz: pole {growth.pole:6.2f} 1/s, seen {growth.seen:6.2f} 1/s")

# %% [markdown]
# **What it has become**, and **how loud it is** at 7.5 m: level and the band that doubtful coefficients make of it.

# %%
cycle = limit_cycle(data)
sound = sound_of(data, resolution_hz=5.0)
weighted = level(a_weighted(sound.narrow).sum(), REFERENCE_PRESSURE)
print(f"{cycle.frequency_hz:.0f} Hz, {cycle.lateral_rms:.3f} m/s rms, stick {cycle.stick:.0%} of the time")
print(f"{sound.level_dba:.1f} dB(A), {sound.low_dba:.1f} to {sound.high_dba:.1f}")
assert np.isclose(float(weighted), sound.level_dba)

# %%
calibration = write_wav(pressure_of(data), folder / "case1.wav", "case1")
print(folder / "case1.wav", f"full scale {calibration.full_scale_pa:.3g} Pa")
