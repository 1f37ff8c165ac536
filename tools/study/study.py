# SPDX-License-Identifier: Apache-2.0
"""What the studies in Python have in common: their command line, journal, results, charts and page.

A study is a script that ends with `study.main(NAME, WHAT, measure)`. `measure(study)` measures cells, adds rows and
sections to the study, and returns nothing. The script leaves, as the studies in C++ do, NAME.csv, NAME.json, the charts
NAME_*.svg and .png, and index.html with a section for each study of the folder. Each measured cell is appended to
NAME.cells.jsonl as soon as it is known, so that the same command continues where it was stopped.
"""
import argparse
import csv
import fcntl
import hashlib
import html
import importlib
import io
import json
import os
import pathlib
import re
import sys
import time

FAILED = 4  # exit status of a program that cannot do its work, as in tools/exit_status.h


def require(*names):
    """Imports the modules; ends the program with a message that names the missing ones and how to install them."""
    missing = []
    for name in names:
        try:
            importlib.import_module(name)
        except ImportError as error:
            missing.append(name if error.name in (None, name) else f"{name} ({error})")
    if not missing:
        return
    plural = "s" if len(missing) > 1 else ""
    how = "tools/setup python installs numpy, scipy and matplotlib (Debian: python3-numpy python3-scipy python3-matplotlib)"
    if any(name.split()[0] == "malha" for name in missing):
        how += ", and tools/build then builds malha's module"
    program = pathlib.Path(sys.argv[0]).stem
    print(f"malha study {program}: found no Python module{plural} {', '.join(missing)} in {sys.executable}; {how}",
          file=sys.stderr)
    sys.exit(FAILED)


require("malha", "numpy", "matplotlib")

import malha  # noqa: E402
import matplotlib  # noqa: E402
import numpy as np  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

# One colour for each method, in all charts: black is kept for what is compared with.
COLOURS = ["#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#17becf", "#8c564b", "#7f7f7f"]
plt.rcParams.update({
    "figure.figsize": (11, 6.2), "font.family": "sans-serif", "font.size": 12, "axes.grid": True, "grid.color": "#dddddd",
    "axes.spines.top": False, "axes.spines.right": False, "axes.prop_cycle": plt.cycler(color=COLOURS),
    "legend.frameon": False, "lines.linewidth": 1.6, "svg.fonttype": "none", "svg.hashsalt": "malha",
    "axes.axisbelow": True})


class Study:
    """A study that runs.

    name, what: its name, and one sentence about its subject. quick: whether smaller cases are asked for. threads: for
    simulations. out: the folder of the results (a pathlib.Path). rows: flat dicts, for NAME.csv and "rows" of NAME.json.
    sections: the parts of the page.
    """

    def __init__(self, name, what, quick, threads, out, keep):
        self.name, self.what, self.quick, self.threads, self.out = name, what, quick, threads, out
        self.rows, self.sections, self.build = [], [], _build()
        self._figures, self._cells = {}, {}
        self._shown = 0.0
        out.mkdir(parents=True, exist_ok=True)
        self._journal = self._open_journal(keep)

    def cell(self, key, make):
        """The value of make(), which is measured once: later runs with the same key read it from the journal.

        key: text that names the cell with all its settings. make: a function without arguments that returns what JSON
        can hold; arrays become lists, NaN becomes None.
        """
        if key not in self._cells:
            self._show(key)
            start = time.monotonic()
            value = json.loads(json.dumps(_plain(make())))
            self._journal.write(json.dumps({"key": key, "value": value, "s": round(time.monotonic() - start, 2)}) + "\n")
            self._journal.flush()
            self._cells[key] = value
        return self._cells[key]

    def row(self, **fields):
        """Adds a row to NAME.csv and NAME.json: text, numbers, booleans or None."""
        self.rows.append(_plain(fields))

    def section(self, title, sentences=(), columns=(), rows=(), chart=None, first=False):
        """Adds a part of the page.

        sentences: what the rows show, computed from them. columns, rows: a table; its fields are shown as text. chart: a
        name and a matplotlib figure, which is saved as STUDY_NAME.svg and .png. first: the part precedes all others.
        """
        name = ""
        if chart is not None:
            name = f"{self.name}_{chart[0]}"
            self._figures[name] = chart[1]
        part = {"title": title, "sentences": list(sentences), "chart": name, "columns": list(columns),
                "rows": [[text(field) for field in row] for row in rows], "replays": []}
        self.sections.insert(0 if first else len(self.sections), part)

    def _open_journal(self, keep):
        path = self.out / f"{self.name}{'.quick' if self.quick else ''}.cells.jsonl"
        head = {"study": self.name, "quick": self.quick, "build": self.build, "program": _program()}
        journal = open(path, "a+", encoding="utf-8")
        try:
            fcntl.flock(journal, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise SystemExit(f"malha study: {path}: another malha study is using it") from None
        journal.seek(0)
        lines = journal.read().splitlines(keepends=True)
        good = []
        for line in lines:  # a process that was killed may have left a torn last line
            try:
                record = json.loads(line) if line.endswith("\n") else None
            except ValueError:
                record = None
            if record is None or (not good and not _same_head(record, head, keep)) or (good and "key" not in record):
                break
            if good:
                self._cells[record["key"]] = record["value"]
            good.append(line)
        if not good:
            if lines:
                path.with_name(path.name + ".old").write_text("".join(lines), encoding="utf-8")
            good = [json.dumps(head) + "\n"]
        journal.truncate(0)
        journal.write("".join(good))
        journal.flush()
        return journal

    def _show(self, key):
        now = time.monotonic()
        if sys.stderr.isatty():
            print(f"\r\033[K{self.name} {len(self._cells)} {key}"[:118], end="", file=sys.stderr, flush=True)
        elif now - self._shown > 10:
            print(f"{self.name} {len(self._cells)} {key}", file=sys.stderr, flush=True)
            self._shown = now

    def _write(self, command):
        """Writes all results into the folder."""
        if sys.stderr.isatty():
            print("\r\033[K", end="", file=sys.stderr)
        result = {"study": self.name, "what": self.what, "quick": self.quick, "command": command, "build": self.build,
                  "sections": self.sections, "rows": self.rows}
        for name, figure in self._figures.items():
            figure.text(0.01, 0.075 / figure.get_figheight(), caption(result), fontsize=8, color="#555555")
            figure.subplots_adjust(bottom=max(0.9 / figure.get_figheight(), figure.subplotpars.bottom))
            figure.savefig(self.out / f"{name}.svg", metadata={"Date": None})
            figure.savefig(self.out / f"{name}.png", dpi=145)
            plt.close(figure)
        columns = list(dict.fromkeys(key for row in self.rows for key in row))
        table = io.StringIO()
        writer = csv.DictWriter(table, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows([{key: _field(value) for key, value in row.items()} for row in self.rows])
        (self.out / f"{self.name}.csv").write_text(table.getvalue(), encoding="utf-8")
        (self.out / f"{self.name}.json").write_text(json.dumps(result, indent=1, ensure_ascii=False) + "\n",
                                                    encoding="utf-8")
        (self.out / "index.html").write_text(page(self.out), encoding="utf-8")


def _plain(value):
    """The value as JSON has it: lists for arrays, numbers of Python for those of numpy, None for NaN and infinities."""
    if isinstance(value, dict):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(one) for one in value]
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    return value


def _field(value):
    return "" if value is None else str(value).lower() if isinstance(value, bool) else value


def text(value):
    """A field of a table as text: numbers with four digits, yes and no."""
    if value is None:
        return ""
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (float, np.floating)):
        return f"{value:.4g}"
    return str(value)


def _build():
    """Version and flags of malha, and the processor, as the studies in C++ name them."""
    report = malha.Simulation({"name": "build", "duration": 1, "solver": {"type": "pbd"}, "bodies": [
        {"name": "point", "mass": 1, "shape": {"lattice": {"min": [0, 0, 0], "max": [1, 1, 1], "count": [1, 1, 1]}}}]}).report()
    return {key: report[key] for key in ("malha_version", "compiler", "flags", "instructions", "cpu")} | {
        "cores": len(os.sched_getaffinity(0))}


def _program():
    """A hash of malha's module and of the scripts, which distinguishes what measured a journal's cells."""
    files = [sys.modules["_malha"].__file__, __file__, sys.modules["__main__"].__file__]
    return hashlib.sha256(b"".join(pathlib.Path(file).read_bytes() for file in files)).hexdigest()[:16]


def _same_head(record, head, keep):
    return all(record.get(key) == value for key, value in head.items() if not (keep and key == "program"))


def caption(result):
    """The line below a chart: malha, compiler, machine and command."""
    build = result["build"]
    cores = f"{build['cores']} core" + ("s" if build["cores"] != 1 else "")
    return (f"malha {build['malha_version']}, {build['compiler']}, {build['instructions']}; {build['cpu']}, {cores}; "
            f"{result['command']}")


STYLE = """
body { font: 16px/1.5 sans-serif; max-width: 70rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
table { border-collapse: collapse; font-size: 0.85rem; display: block; overflow-x: auto; }
th, td { padding: 0.15rem 0.6rem; border-bottom: 1px solid #ddd; text-align: right; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; }
svg { width: 100%; height: auto; }
.made { color: #666; font-size: 0.85rem; }
@media print { section { break-inside: avoid; } details > * { display: block; } }
"""


def inline_svg(file, name):
    """A chart's SVG without its fixed size and with identifiers of its own, so that a page can hold several."""
    svg = file[file.find("<svg"):]
    svg = re.sub(r"""\b(id=["'])""", rf"\g<1>{name}_", svg)
    svg = re.sub(r"""(href=["']#|url\(#)""", rf"\g<1>{name}_", svg)
    start, end = svg.split(">", 1)
    return re.sub(r' (width|height)="[^"]*"', "", start) + ">" + end


def page(folder):
    """index.html of a folder: one section for each study whose NAME.json lies there."""
    contents, body = [], []
    for file in sorted(folder.glob("*.json")):
        try:
            result = json.loads(file.read_text(encoding="utf-8"))
        except ValueError:
            continue
        if not isinstance(result, dict) or result.get("study") != file.stem or "sections" not in result:
            continue
        name, escape = result["study"], html.escape
        short = " (quick version)" if result["quick"] else ""
        contents.append(f'<li><a href="#{name}">{name}</a>: {escape(result["what"])}{short}</li>')
        body.append(f'<h2 id="{name}">{name}</h2>\n<p>{escape(result["what"])}.</p>\n<p class="made">'
                    f'{escape(caption(result))}. Rows: {name}.csv, {name}.json.</p>')
        for section in result["sections"]:
            body.append(f'<section>\n<h3>{escape(section["title"])}</h3>')
            if section["sentences"]:
                body.append("<p>" + "\n".join(map(escape, section["sentences"])) + "</p>")
            chart = folder / (section["chart"] + ".svg")
            if section["chart"] and chart.exists():
                body.append(inline_svg(chart.read_text(encoding="utf-8"), section["chart"]))
            replays = [one for one in section["replays"] if (folder / one["file"]).exists()]
            if replays:
                body.append("<p>Replays, which play in the browser:</p>\n<ul>" + "".join(
                    f'<li><a href="{one["file"]}">{escape(one["words"])}</a></li>' for one in replays) + "</ul>")
            if section["rows"]:
                lines = ["<th>" + "</th><th>".join(map(escape, section["columns"])) + "</th>"]
                lines += ["<td>" + "</td><td>".join(map(escape, row)) + "</td>" for row in section["rows"]]
                unfolded = " open" if len(lines) <= 13 else ""
                body.append(f"<details{unfolded}><summary>The numbers</summary>\n<table>\n" +
                            "\n".join(f"<tr>{line}</tr>" for line in lines) + "</table></details>")
            body.append("</section>")
    return (f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>malha: studies</title><style>{STYLE}'
            "</style></head><body>\n<h1>malha: studies</h1>\n<ul>\n" + "\n".join(contents) + "</ul>\n" +
            "\n".join(body) + "</body></html>\n")


def main(name, what, measure, *, only=None):
    """Runs a study as its command line says, and writes its results.

    measure: a function of the Study. only: names of parts, of which the option --only chooses some; they are handed to
    measure as a second argument.
    """
    parser = argparse.ArgumentParser(prog=f"malha study {name}", description=what + ".")
    parser.add_argument("--quick", action="store_true", help="measure smaller cases and fewer points")
    parser.add_argument("--out", type=pathlib.Path, metavar="FOLDER",
                        help="folder of the results; out/study, or out/study_quick, if not given")
    parser.add_argument("--threads", type=int, default=1, metavar="N", help="threads of a simulation (1)")
    parser.add_argument("--keep", action="store_true",
                        help="also use measurements that another build of malha or of the script left in the folder")
    if only:
        parser.add_argument("--only", nargs="+", choices=only, metavar="PART", help="measure some parts: " + ", ".join(only))
    given = parser.parse_args()
    out = given.out or pathlib.Path("out", "study_quick" if given.quick else "study")
    study = Study(name, what, given.quick, given.threads, out, given.keep)
    chosen = getattr(given, "only", None)
    measure(study, chosen or only) if only else measure(study)
    study._write(f"malha study {name}" + (" --quick" if given.quick else "") +
                 (" --only " + " ".join(chosen) if chosen else ""))
    print(f"{name}: {what}")
    for section in study.sections:
        print(f"  {section['title']}")
        for sentence in section["sentences"]:
            print(f"    {sentence}")
    print(f"rows        {out / name}.csv, {out / name}.json\ncharts      {out / name}_*.svg, .png\n"
          f"page        {out / 'index.html'}")
