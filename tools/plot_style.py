# SPDX-License-Identifier: Apache-2.0
"""How the plots of generated pages look. Needs python3-matplotlib (apt install python3-matplotlib)."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

COLOURS = ["#1f5fa8", "#c8601a", "#3c8a4b", "#7a4fa3", "#8c8c8c"]
plt.rcParams.update({"font.size": 9, "axes.grid": True, "grid.color": "#e2e2e2", "axes.axisbelow": True,
                     "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False,
                     "figure.dpi": 100, "savefig.bbox": "tight"})
