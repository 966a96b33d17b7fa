# SPDX-License-Identifier: Apache-2.0
"""Charts as SVG text: axes, panels of lines, marks and bars, and their legend. plots.py says what is drawn.

Places are pixels from the top left corner, written with one decimal, so that the same values give the same bytes. A chart has
a white ground of its own: it reads the same on a dark page. Colours are those of Okabe and Ito (Color Universal Design, 2008),
which people with any colour vision tell apart; marks differ in shape, too.
"""
import html
import math

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#555555", "#000000", "#f0e442")
MARKS = ("circle", "square", "triangle", "diamond", "cross")
INK, FRAME, GRID, FAINT = "#222", "#999", "#ddd", "#eee"
MARK_PX = 3.2
FONT_PX = 12
LABEL_PX = 26  # a value of three digits; above a narrower bar it stands upright
LABELLED_DECADES = 2  # on a logarithmic axis of more decades 2 and 5 have a line without a number


def px(value):
    return f"{round(value, 1) + 0.0:.1f}"


def text(x, y, words, anchor="start", **more):
    others = "".join(f' {name.replace("_", "-")}="{value}"' for name, value in more.items())
    return f'<text x="{px(x)}" y="{px(y)}" text-anchor="{anchor}"{others}>{html.escape(words, quote=False)}</text>'


def line(x1, y1, x2, y2, colour, width=1, dash=""):
    dashes = f' stroke-dasharray="{dash}"' if dash else ""
    return (f'<line x1="{px(x1)}" y1="{px(y1)}" x2="{px(x2)}" y2="{px(y2)}" '
            f'stroke="{colour}" stroke-width="{width}"{dashes}/>')


class Linear:
    """An axis from 0 to the first round value that is not below the greatest of `values`."""

    def __init__(self, label, values, ticks_max=6):
        self.label = label
        top = max(values)
        step = 10.0 ** math.floor(math.log10(top / ticks_max))
        step *= next(factor for factor in (1, 2, 5, 10) if math.ceil(top / (step * factor) - 1e-9) <= ticks_max)
        count = math.ceil(top / step - 1e-9)
        self.high = count * step
        self.ticks = [(i * step, f"{i * step:,g}") for i in range(count + 1)]

    def share(self, value):
        return value / self.high


class Logarithmic:
    """An axis between round values (1, 2 or 5 of a decade) that enclose `values`, all of which are above 0."""

    def __init__(self, label, values):
        self.label = label
        first, last = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
        rounds = [(factor, factor * 10.0 ** k) for k in range(first, last + 1) for factor in (1, 2, 5)]
        self.low = max(value for _, value in rounds if value <= min(values) * (1 + 1e-9))
        self.high = min(value for _, value in rounds if value >= max(values) * (1 - 1e-9))
        has_all = math.log10(self.high / self.low) <= LABELLED_DECADES
        self.ticks = [(value, f"{value:,g}" if factor == 1 or has_all else "")
                      for factor, value in rounds if self.low <= value <= self.high]

    def share(self, value):
        return math.log10(value / self.low) / math.log10(self.high / self.low)


class Groups:
    """An axis of names, each with a stretch of the same length; the value of a group is its index."""

    def __init__(self, label, names):
        self.label, self.count = label, len(names)
        self.ticks = [(i, name) for i, name in enumerate(names)]

    def share(self, value):
        return (value + 0.5) / self.count


class Style:
    """How a series is drawn and stands in the legend."""

    def __init__(self, colour, mark=None, dash="", is_line=True, opacity=1.0):
        self.colour, self.mark, self.dash, self.is_line, self.opacity = colour, mark, dash, is_line, opacity


def mark(x, y, style):
    r, shape = MARK_PX, style.mark
    if shape == "circle":
        return f'<circle cx="{px(x)}" cy="{px(y)}" r="{r}" fill="{style.colour}"/>'
    if shape == "cross":
        return (f'<path d="M{px(x - r)},{px(y - r)} L{px(x + r)},{px(y + r)} M{px(x - r)},{px(y + r)} L{px(x + r)},{px(y - r)}" '
                f'stroke="{style.colour}" stroke-width="2" fill="none"/>')
    corners = {"square": ((-1, -1), (1, -1), (1, 1), (-1, 1)), "triangle": ((0, -1.3), (1.2, 1), (-1.2, 1)),
               "diamond": ((0, -1.4), (1.4, 0), (0, 1.4), (-1.4, 0))}[shape]
    points = " ".join(f"{px(x + r * dx)},{px(y + r * dy)}" for dx, dy in corners)
    return f'<polygon points="{points}" fill="{style.colour}"/>'


class Panel:
    """One diagram in a box (left, top, width, height) of its lines, without what is written around it."""

    def __init__(self, box, x_axis, y_axis, title="", label_px=46):
        self.left, self.top, self.width, self.height = box
        self.label_px = label_px  # from the label of the y axis to that axis
        self.x_axis, self.y_axis = x_axis, y_axis
        self.parts = []
        self.labels = []  # above all else
        self._draw_grid()
        if title:
            self.parts.append(text(self.left + self.width / 2, self.top - 10, title, "middle", font_weight="bold"))

    def x(self, value):
        return self.left + self.width * self.x_axis.share(value)

    def y(self, value):
        return self.top + self.height * (1 - self.y_axis.share(value))

    def _draw_grid(self):
        right, bottom = self.left + self.width, self.top + self.height
        for value, words in self.y_axis.ticks:
            self.parts.append(line(self.left, self.y(value), right, self.y(value), GRID if words else FAINT))
            self.parts.append(text(self.left - 7, self.y(value) + 4, words, "end") if words else "")
        for value, words in self.x_axis.ticks:
            if not isinstance(self.x_axis, Groups):
                self.parts.append(line(self.x(value), self.top, self.x(value), bottom, GRID if words else FAINT))
            self.parts.append(text(self.x(value), bottom + 17, words, "middle") if words else "")
        self.parts.append(line(self.left, self.top, self.left, bottom, FRAME))
        self.parts.append(line(self.left, bottom, right, bottom, FRAME))
        self.parts.append(text(self.left + self.width / 2, bottom + 35, self.x_axis.label, "middle") if self.x_axis.label else "")
        x, y = self.left - self.label_px, self.top + self.height / 2
        self.parts.append(text(x, y, self.y_axis.label, "middle", transform=f"rotate(-90 {px(x)} {px(y)})"))

    def draw(self, points, style):
        """`points` as a line, marks, or marks on a line, by `style`."""
        places = [(self.x(x), self.y(y)) for x, y in points]
        if style.is_line:
            dash = f' stroke-dasharray="{style.dash}"' if style.dash else ""
            path = " ".join(f"{px(x)},{px(y)}" for x, y in places)
            self.parts.append(f'<polyline points="{path}" fill="none" stroke="{style.colour}" stroke-width="1.8"{dash}/>')
        if style.mark:
            self.parts += [mark(x, y, style) for x, y in places]

    def bar(self, group, place, places, low, high, style):
        """A bar up to the middle of `low` and `high`, its value above it; a thin line between them if they differ."""
        stretch = self.width / self.x_axis.count
        width = 0.8 * stretch / places
        x = self.x(group) - 0.4 * stretch + place * width
        y = self.y((low + high) / 2)
        self.parts.append(f'<rect x="{px(x + 1)}" y="{px(y)}" width="{px(width - 2)}" height="{px(self.top + self.height - y)}" '
                          f'fill="{style.colour}" fill-opacity="{style.opacity}"/>')
        if low != high:
            self.parts.append(line(x + width / 2, self.y(low), x + width / 2, self.y(high), INK))
        words, halo = f"{(low + high) / 2:.2f}", {"font_size": FONT_PX - 1, "stroke": "#fff", "stroke_width": 3, "paint_order": "stroke"}
        if width >= LABEL_PX:
            self.labels.append(text(x + width / 2, self.y(high) - 4, words, "middle", **halo))
        else:
            x, y = x + width / 2 + 4, self.y(high) - 4
            self.labels.append(text(x, y, words, transform=f"rotate(-90 {px(x)} {px(y)})", **halo))

    def level(self, value, words, dash="6 3"):
        """A line across the panel, named at its right end."""
        self.parts.append(line(self.left, self.y(value), self.left + self.width, self.y(value), INK, 1, dash))
        self.parts.append(text(self.left + self.width + 6, self.y(value) + 4, words))


def legend(left, top, entries, columns=1, column_px=0):
    """`entries` are pairs (words, style), drawn row by row."""
    parts = []
    for i, (words, style) in enumerate(entries):
        x, y = left + i % columns * column_px, top + i // columns * 19
        if style.is_line:
            parts.append(line(x, y - 4, x + 26, y - 4, style.colour, 1.8, style.dash))
        if style.mark:
            parts.append(mark(x + 13, y - 4, style))
        if not style.is_line and not style.mark:
            parts.append(f'<rect x="{px(x + 8)}" y="{px(y - 10)}" width="12" height="12" fill="{style.colour}" '
                         f'fill-opacity="{style.opacity}"/>')
        parts.append(text(x + 33, y, words))
    return parts


def picture(width, height, title, parts):
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
             f'font-family="sans-serif" font-size="{FONT_PX}" fill="{INK}">',
             f"<title>{html.escape(title, quote=False)}</title>",
             f'<rect width="{width}" height="{height}" fill="#fff"/>',
             text(width / 2, 22, title, "middle", font_size=FONT_PX + 3, font_weight="bold")]
    return "\n".join([*lines, *filter(None, parts), "</svg>", ""])
