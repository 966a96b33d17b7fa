# SPDX-License-Identifier: Apache-2.0
"""What one run of one row found: figures beside their bounds, and whether the row holds."""
import json


class Report:
    """A row holds when every figure is within its bound and every claim is true. Its chances come from `seed`."""

    def __init__(self, row, seed):
        self.row, self.seed = row, seed
        self.figures, self.claims, self.notes = [], [], []
        self.values = {"picture_equal": None, "tiles_lost": None, "tiles_reissued": None, "tiles_rendered_twice": None,
                       "event": None}
        self.error = None

    def figure(self, name, measured, bound, unit="ms", least=False):
        """measured <= bound (least: >=). Times come in seconds and are printed in milliseconds."""
        scale = 1e3 if unit == "ms" else 1
        holds = measured >= bound if least else measured <= bound
        self.figures.append({"name": name, "measured": round(measured * scale, 3), "bound": round(bound * scale, 3),
                             "unit": unit, "least": least, "holds": bool(holds)})
        return holds

    def claim(self, name, is_true, detail=""):
        self.claims.append({"name": name, "holds": bool(is_true), "detail": str(detail)})
        return bool(is_true)

    def picture(self, is_equal):
        self.values["picture_equal"] = bool(is_equal) if self.values["picture_equal"] is None else (
            self.values["picture_equal"] and bool(is_equal))
        self.claim("same picture", is_equal)

    def event(self, name, count, expected=1):
        self.values["event"] = name
        self.claim(f"{expected} event {name}", count == expected, f"{count} events")

    def note(self, text):
        self.notes.append(text)

    @property
    def holds(self):
        return self.error is None and bool(self.figures or self.claims) and all(
            f["holds"] for f in self.figures) and all(c["holds"] for c in self.claims)

    def figures_text(self):
        if not self.figures:
            return f"{len(self.claims)} claims"

        def short(value):
            return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"
        return "; ".join(f"{f['name']} {short(f['measured'])} {'≥' if f['least'] else '≤'} {short(f['bound'])} {f['unit']}".strip()
                         for f in self.figures)

    def text(self):
        parts = []
        for f in self.figures:
            mark = "" if f["holds"] else "!"
            relation = ">=" if f["least"] else "<="
            parts.append(f"{mark}{f['name']} {f['measured']:g} {relation} {f['bound']:g} {f['unit']}")
        parts += [f"NOT {c['name']} ({c['detail']})" if c["detail"] else f"NOT {c['name']}"
                  for c in self.claims if not c["holds"]]
        held = [c["name"] for c in self.claims if c["holds"]]
        if held:
            parts.append(", ".join(held))
        parts += self.notes
        if self.error:
            parts.append("error: " + self.error)
        return "; ".join(parts)

    def json(self, outcome):
        found = {f["name"]: f for f in self.figures}

        def pair(name, key):
            one = found.get(name)
            return {f"{key}": one["measured"] if one else None, f"{key}_bound": one["bound"] if one else None}

        return json.dumps({"id": self.row, "outcome": outcome, "seed": self.seed, **self.values,
                           **pair("gap", "gap_ms"), **pair("detection", "detection_ms"),
                           **pair("memory", "peak_memory_mib"), "figures": self.figures, "claims": self.claims,
                           "notes": self.notes, "error": self.error})
