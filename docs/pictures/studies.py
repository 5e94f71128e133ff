"""Figures and tables of docs/studies.md, from the pages of `struna simulate --report`.

    python3 docs/pictures/studies.py PAGES_FOLDER [PICTURES_FOLDER]

Reads the numbers that the pages hold; prints tables, writes SVG files. Standard library only.
"""
import json
import math
import pathlib
import sys

COLOURS = ["#1a1d21", "#0072b2", "#d55e00", "#009e73", "#aa4499"]
DASHES = ["", "7 3", "2 2", "8 3 2 3", "4 4"]


class Page:
    """What a page says of one output."""

    def __init__(self, folder, name, output):
        text = (folder / (name + ".html")).read_text(encoding="utf-8")
        start = text.index('id="report-data">') + len('id="report-data">')
        data = json.loads(text[start : text.index("</script>", start)])
        self.data = data
        spectrum = next(o for o in data["spectra"]["outputs"] if o["name"] == output)
        self.frequency = data["spectra"]["frequency"]
        self.density = spectrum["density"]
        self.density_linear = spectrum["densityLinear"]
        self.density_measured = spectrum["densityMeasured"]
        transfer = data["transfer"]
        self.lines = transfer["simulated"]["frequency"]
        self.h1_lines = self.apparent_mass(transfer["simulated"], output)
        self.ratio_lines = self.apparent_mass(transfer.get("amplitudeRatio", transfer["simulated"]), output)
        self.ratio = smoothed(self.lines, self.ratio_lines)

    @staticmethod
    def apparent_mass(function, output):
        found = next(o for o in function["outputs"] if o["name"] == output)
        pairs = zip(function["frequency"], found["re"], found["im"])
        return [math.hypot(re, im) / (2 * math.pi * f) ** 2 for f, re, im in pairs]

    def rms(self, lo, hi, density=None):
        """Of the force between two frequencies [N]."""
        df = self.frequency[1] - self.frequency[0]
        density = density or self.density
        return math.sqrt(sum(d * d * df for f, d in zip(self.frequency, density) if lo <= f < hi))

    def mean(self, lo, hi, values):
        """Root mean square of an apparent mass over the lines of a band [kg]."""
        inside = [v for f, v in zip(self.lines, values) if lo <= f < hi]
        return math.sqrt(sum(v * v for v in inside) / len(inside))

    def largest(self, lo, hi):
        """Of the apparent mass's amplitude ratio, smoothed [kg]."""
        return max(v for f, v in self.ratio if lo <= f < hi)


def smoothed(frequency, values, parts=96):
    """Root mean squares over 1/96 octave."""
    points, band = [], []
    edge = frequency[0] * 2 ** (1 / parts)
    for f, v in list(zip(frequency, values)) + [(math.inf, 0.0)]:
        if f >= edge and band:
            centre = math.exp(sum(math.log(b[0]) for b in band) / len(band))
            points.append((centre, math.sqrt(sum(b[1] ** 2 for b in band) / len(band))))
            band = []
            while edge <= f < math.inf:
                edge *= 2 ** (1 / parts)
        band.append((f, v))
    return points


def decades(lo, hi):
    for exponent in range(math.floor(math.log10(lo)), math.ceil(math.log10(hi)) + 1):
        for mantissa in (1, 2, 5):
            value = mantissa * 10.0**exponent
            if lo * 0.999 <= value <= hi * 1.001:
                yield value, mantissa == 1


def chart(file, title, x_label, y_label, x_range, y_range, curves):
    """A log-log line chart; curves: [(name, [(x, y), ...])]."""
    width, height, left, top, right, bottom = 900, 420, 74, 58, 14, 46

    def place(x, y):
        u = math.log(x / x_range[0]) / math.log(x_range[1] / x_range[0])
        v = math.log(max(y, 1e-30) / y_range[0]) / math.log(y_range[1] / y_range[0])
        return left + u * (width - left - right), height - bottom - v * (height - top - bottom)

    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">',
        f'<rect width="{width}" height="{height}" fill="#fff"/>',
        f'<clipPath id="c"><rect x="{left}" y="{top}" width="{width - left - right}" height="{height - top - bottom}"/></clipPath>',
        f'<text x="{left}" y="18" font-size="14" font-weight="600">{title}</text>',
    ]
    for value, major in decades(*x_range):
        x, y = place(value, y_range[0])
        out.append(f'<path d="M{x:.1f} {top}V{y:.1f}" stroke="#{"d5d9de" if major else "edeff1"}"/>')
        out.append(f'<text x="{x:.1f}" y="{y + 16:.1f}" text-anchor="middle" fill="#5b636d">{value:g}</text>')
    for value, major in decades(*y_range):
        x, y = place(x_range[0], value)
        out.append(f'<path d="M{x:.1f} {y:.1f}H{width - right}" stroke="#{"d5d9de" if major else "edeff1"}"/>')
        if major:
            out.append(f'<text x="{x - 6:.1f}" y="{y + 4:.1f}" text-anchor="end" fill="#5b636d">{value:g}</text>')
    out.append(f'<text x="{(left + width - right) / 2}" y="{height - 8}" text-anchor="middle">{x_label}</text>')
    middle = (top + height - bottom) / 2
    out.append(f'<text transform="rotate(-90 16 {middle})" x="16" y="{middle}" text-anchor="middle">{y_label}</text>')
    place_x = left
    for k, (name, points) in enumerate(curves):
        style = f'stroke="{COLOURS[k % 5]}" stroke-dasharray="{DASHES[k % 5]}" stroke-width="1.6" fill="none"'
        path = " ".join("{:.1f} {:.1f}".format(*place(x, y)) for x, y in points)
        out.append(f'<path clip-path="url(#c)" d="M{path}" {style}/>')
        out.append(f'<path d="M{place_x} 38h28" {style}/><text x="{place_x + 34}" y="42">{name}</text>')
        place_x += 52 + 7.2 * len(name)
    out.append("</svg>\n")
    file.write_text("\n".join(out), encoding="utf-8")


def table(heading, rows):
    print("| " + " | ".join(heading) + " |")
    print("|" + "---|" * len(heading))
    for row in rows:
        print("| " + " | ".join(row) + " |")
    print()


def peaks_table(cases, bands):
    rows = []
    for name, page in cases:
        rows.append([name] + [f"{page.largest(*band):.4f}" for band in bands])
    table(["largest apparent mass [kg]"] + [f"{lo} to {hi} Hz" for lo, hi in bands], rows)


def force_table(cases):
    rows = []
    for name, page in cases:
        inside, above = page.rms(10, 1000), page.rms(1050, 4000)
        # A record's window leaks: the linear response shows what of it is that.
        rows.append([name, f"{inside:.4g}", f"{above:.3g}", f"{page.rms(1050, 4000, page.density_linear):.1g}", f"{page.data['events']}"])
    table(["force [N rms]", "10 to 1000 Hz", "1050 to 4000 Hz", "there without contact", "contact events"], rows)


def run_a(folder, pictures):
    cases = [(name, Page(folder, stem, "force_z")) for name, stem in
             [("no band", "paper_gap_no_band"), ("gap 0.15 mm", "paper_gap_small_gap"), ("gap 0.65 mm", "paper_gap_large_gap")]]
    print("Run A, z\n")
    bands = [(10, 60), (60, 120), (120, 250), (250, 500), (500, 1000)]
    peaks_table(cases, bands)
    force_table(cases)
    rows = []
    for kind in ("ratio_lines", "h1_lines"):
        for name, page in cases:
            rows.append([("amplitude ratio, " if kind == "ratio_lines" else "H1, ") + name]
                        + [f"{1e3 * page.mean(*band, getattr(page, kind)):.2f}" for band in bands])
    table(["rms apparent mass [g]"] + [f"{lo} to {hi} Hz" for lo, hi in bands], rows)
    chart(pictures / "run_a.svg", "Run A: apparent mass along z, amplitude ratio", "frequency [Hz]", "apparent mass [kg]",
          (10, 1000), (1e-4, 0.1), [(name, page.ratio) for name, page in cases])


def run_b(folder, pictures):
    stems = ["none", "case_1", "case_2", "case_3", "case_4", "case_3_wide", "case_4_wide"]
    cases = [(stem.replace("_", " "), Page(folder, "paper_filter_" + stem, "force_y")) for stem in stems]
    print("Run B, y\n")
    peaks_table(cases, [(10, 50), (50, 120), (120, 250), (250, 450), (450, 1000)])
    force_table(cases)
    chart(pictures / "run_b.svg", "Run B: apparent mass, amplitude ratio", "frequency [Hz]", "apparent mass [kg]", (10, 1000), (1e-4, 0.1),
          [(name, page.ratio) for name, page in cases[:5]])
    chart(pictures / "run_b_force.svg", "Run B: transmitted force", "frequency [Hz]", "force [N/√Hz]", (10, 4000), (1e-8, 1),
          [(name, smoothed(page.frequency, page.density)) for name, page in cases[:3]])


def closed_loop(folder, pictures):
    page = Page(folder, "wire_in_band", "force_y")
    signal = page.data["comparison"]["signals"][0]
    print("wire_in_band\n")
    table(["second", *[str(k + 1) for k in range(len(signal["correlation"]))]], [["correlation", *[f"{r:.3f}" for r in signal["correlation"]]]])
    edges = signal["edges"]
    table(["half octave [Hz]", *[f"{a:.0f}–{b:.0f}" for a, b in zip(edges, edges[1:])]],
          [["simulated less measured [dB]", *[f"{d:+.2f}" for d in signal["difference"]]]])
    chart(pictures / "wire_in_band.svg", "wire_in_band: transmitted force", "frequency [Hz]", "force [N/√Hz]", (10, 2000), (1e-5, 0.1),
          [("measured in its band", smoothed(page.frequency, page.density_measured)), ("simulated", smoothed(page.frequency, page.density)),
           ("without contact", smoothed(page.frequency, page.density_linear))])


def main():
    folder = pathlib.Path(sys.argv[1])
    pictures = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else folder
    closed_loop(folder, pictures)
    run_a(folder, pictures)
    run_b(folder, pictures)


main()
