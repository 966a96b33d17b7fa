# SPDX-License-Identifier: Apache-2.0
"""Series of `tessera-sim scaling`: results with a table "series", a row for each number of slaves (tests/sim/record_scaling.py)."""

TABLE = "series"


def series_of(run):
    """Name of a series -> its rows, from few slaves to many; a row maps a column's name to its value."""
    made = run["tables"][TABLE]
    found = {}
    for values in made["rows"]:
        row = dict(zip(made["columns"], values))
        found.setdefault(row["series"], []).append(row)
    return found


def speeds_table(run, counts):
    """Frames per second at each number of slaves in `counts`, and what happens at the greatest that was tried."""
    series = series_of(run)
    is_cut_alike = len({row["tile_px"] for rows in series.values() for row in rows}) == 1
    columns = ["frames/s with" if is_cut_alike else "frames/s (tile edge) with", *counts[:-1], f"{counts[-1]} slaves",
               "speed-up", "what ends it", "bytes a frame"]
    cells = []
    for name, rows in series.items():
        at = {str(row["slaves"]): row for row in rows}
        last, best = rows[-1], max(rows, key=lambda row: row["speed_up"])
        speeds = [f"{at[count]['frames_per_s']:.2f}" + ("" if is_cut_alike else f" ({at[count]['tile_px']})") for count in counts]
        shares = ", ".join(f"{who} {100 * last[what]:.0f} %" for who, what in
                           (("wire", "wire_share"), ("master", "master_cpu_share"), ("slaves", "utilisation")))
        cells.append([name, *speeds, f"{best['speed_up']:.0f} at {best['slaves']}", f"{last['limit']}: {shares}",
                      f"{last['bytes_per_frame']:,}"])
    return columns, cells
