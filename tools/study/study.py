# SPDX-License-Identifier: Apache-2.0
"""The part that all studies share: command line, journal of measurements, shares, results, charts and page.

A study is a script NAME.py that ends with `studies.main(NAME, WHAT, measure)`. `measure(study)` requests all its cells
(single measurements), returns if `study.partial`, and adds rows and sections to the study otherwise:

    def measure(study):
        sizes = [10, 100] if study.quick else [10, 100, 1000]
        study.plan(len(sizes))
        cells = study.cells(sizes, lambda size: f"chain of {size}", lambda size: sag_of(chain(size), study.threads))
        if study.partial:
            return
        for size, sag in zip(sizes, cells):
            study.row(size=size, sag_m=sag)
        study.section("Sag", [f"The longest chain sags by {cells[-1]:.3g} m."], ["size", "sag, m"], zip(sizes, cells))

The script leaves NAME.csv, NAME.json, the charts NAME_*.svg and .png, and index.html with a section for each study of
the folder. Each cell is appended to NAME.cells.jsonl as soon as it is measured, so that the same command continues where
it was stopped. With --share I/N several processes measure a part of the cells each, and --merge combines them.
"""
import argparse
import csv
import fcntl
import hashlib
import html
import importlib
import io
import json
import math
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
import traceback

# All studies of `malha study`, in the order in which `malha study all` runs them, before results.py, and in which the
# page shows them.
STUDIES = ("accuracy", "published", "stability", "scaling", "parsimony", "size", "validation")
UNMET, BAD_INPUT, DIVERGED, FAILED, OUT_OF_MEMORY = 1, 2, 3, 4, 5  # exit statuses, as in tools/exit_status.h
MOST_SHARES = 100_000
UNMERGED = "--unmerged"  # hidden option of `malha study all --merge`: the studies before that could not be merged, by commas


def require(*names):
    """Imports the modules; ends the program with a message that names the missing ones and the command that installs them:
    that of Debian for its own Python, else that of the environment."""
    missing = []
    for name in names:
        try:
            importlib.import_module(name)
        except ImportError as error:
            missing.append(name if error.name in (None, name) else f"{name} ({error})")
    if not missing:
        return
    plural = "s" if len(missing) > 1 else ""
    needed = [name.split()[0] for name in missing]
    how = []
    if packages := [name for name in needed if name != "malha"]:
        how.append("sudo apt-get install " + " ".join(f"python3-{name}" for name in packages) if sys.prefix == "/usr" else
                   f"{shlex.quote(sys.executable)} -m pip install {' '.join(packages)}")
    if "malha" in needed:
        how.append("tools/setup python && tools/build")
    print(f"malha study {pathlib.Path(sys.argv[0]).stem}: found no Python module{plural} {', '.join(missing)} in "
          f"{sys.executable}; to install: {'; '.join(how)}", file=sys.stderr)
    sys.exit(FAILED)


require("malha", "numpy", "matplotlib")

import malha  # noqa: E402
import matplotlib  # noqa: E402
import numpy as np  # noqa: E402

matplotlib.use("Agg")

# One colour for each method, in all charts: black is kept for what is compared with.
COLOURS = ["#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#17becf", "#8c564b", "#7f7f7f"]
matplotlib.rcParams.update({
    "figure.figsize": (11, 6.2), "font.family": "sans-serif", "font.size": 12, "axes.grid": True, "grid.color": "#dddddd",
    "axes.spines.top": False, "axes.spines.right": False, "axes.prop_cycle": matplotlib.cycler(color=COLOURS),
    "legend.frameon": False, "lines.linewidth": 1.6, "svg.fonttype": "none", "svg.hashsalt": "malha",
    "axes.axisbelow": True, "figure.max_open_warning": 0})


class _Missing(Exception):
    """Leaves the work of Study.together() where a merge lacks one of its cells."""


class Study:
    """A study that runs.

    name, what: its name, and one sentence about its subject. quick: whether smaller cases are asked for. threads: for
    simulations. on: keyword arguments of malha.Simulation that name the backend; {} on the host. out: the folder of the
    results (a pathlib.Path). rows: flat dicts, for NAME.csv and "rows" of NAME.json. sections: the parts of the page.
    table: lines of Markdown, for NAME.md; empty without such a file.
    """

    def __init__(self, name, what, given):
        self.name, self.what, self.quick, self.threads = name, what, given.quick, given.threads
        self.out = folder_of(given)
        self.on = {key: value for key, value in (("backend", given.backend), ("machine", given.machine)) if value}
        self.rows, self.sections, self.table, self.builds = [], [], [], [_build({} if given.merge else self.on)]
        self._figures, self._replays, self._shown = {}, [], time.monotonic()
        self._share, self._merged = given.share, None
        self._shares = given.share[1] if given.share else 1
        self._requests, self._group, self._planned = 0, 0, 0
        self._share_of, self._done, self._missing = {}, set(), {}
        head = {"study": name, "quick": self.quick, "build": self.builds[0], "program": _program()}
        if self.on:
            head["on"] = " ".join(_options_on(given))
        if given.merge:
            self._merged = read_shares(given.merge, head, given.keep)
            self._cells, self._shares, self.builds = (self._merged[key] for key in ("cells", "shares", "builds"))
        else:
            self.out.mkdir(parents=True, exist_ok=True)
            self._cells, self._journal = _open_journal(self.out / journal_name(name, self.quick, given.share),
                                                       head | ({"share": share_text(given.share)} if given.share else {}),
                                                       given.keep)

    @property
    def partial(self):
        """True if cells are missing: those of other shares, or those that no share has measured. A study requests its
        other cells all the same, and then returns without rows."""
        return bool(self._share or self._missing)

    @property
    def cores(self):
        """The number of cores of the machine that measured. A merge of machines that differ in it is refused."""
        cores = self.builds[0]["cores"]
        for build, journal in zip(self.builds, self._merged["found_in"] if self._merged else []):
            if build["cores"] != cores:
                refuse(f"{journal}: line 1", counted(build["cores"], "core"), f"{cores}, as in "
                       f"{self._merged['found_in'][0]}: this study measures by the number of cores")
        return cores

    def plan(self, cells):
        """Sets the expected number of cells, for the progress line; may be called again."""
        self._planned = -(-cells // self._shares) if self._share else cells

    def cell(self, key, make):
        """The value of make(), which is measured once: later runs with the same key read it from the journal. None where
        this process does not have it: in the share of another one, or in a merge that lacks it.

        key: text that names the cell with all its settings. make: a function without arguments that returns what JSON
        can hold; arrays become lists, NaN becomes None.
        """
        if not self._group and key not in self._share_of:
            self._share_of[key] = self._next_share()
        share = self._group or self._share_of[key]
        self._share_of.setdefault(key, share)
        if self._share and share != self._share[0]:
            return None
        if key not in self._cells:
            if self._merged:
                self._missing.setdefault(share, {})[key] = True
                if self._group:
                    raise _Missing
                return None
            self._show(key)
            start = time.monotonic()
            value = json.loads(json.dumps(_plain(make())))
            line = json.dumps({"key": key, "value": value, "s": round(time.monotonic() - start, 2)}) + "\n"
            self._journal.write(line.encode())
            self._journal.flush()
            self._cells[key] = value
        self._done.add(key)
        return self._cells[key]

    def cells(self, items, key, make):
        """The cells of all items: key(item) names a cell, make(item) measures it."""
        return [self.cell(key(item), lambda: make(item)) for item in items]

    def together(self, work):
        """Calls work(), whose cells depend on each other, so that they belong to one share: it may read each at once. It is
        not called where they belong to another share, and left where a merge lacks one of them."""
        self._group = self._next_share()
        try:
            if not self._share or self._group == self._share[0]:
                work()
        except _Missing:
            pass
        finally:
            self._group = 0

    def _next_share(self):
        """The share that measures the next cell or group of cells, from 1."""
        self._requests += 1
        return (self._requests - 1) % self._shares + 1

    def row(self, **fields):
        """Adds a row to NAME.csv and NAME.json: text, numbers, booleans or None."""
        self.rows.append(_plain(fields))

    def section(self, title, sentences=(), columns=(), rows=(), chart=None, first=False, replays=()):
        """Adds a part of the page.

        sentences: what the rows show, computed from them. columns, rows: a table; its fields are shown as text. chart: a
        name and a matplotlib figure, which is saved as STUDY_NAME.svg and .png. first: the part precedes all others.
        replays: (name, words, left, right) of each replay: two scenes (dicts with different names) that STUDY_NAME.html
        plays side by side, to which the page links with these words.
        """
        name = ""
        if chart is not None:
            name = f"{self.name}_{chart[0]}"
            self._figures[name] = chart[1]
        links = [{"file": f"{self.name}_{replay[0]}.html", "words": replay[1]} for replay in replays]
        self._replays += [(link["file"], left, right) for link, (_, _, left, right) in zip(links, replays)]
        part = {"title": title, "sentences": list(sentences), "chart": name, "columns": list(columns),
                "rows": [[text(field) for field in row] for row in rows], "replays": links}
        self.sections.insert(0 if first else len(self.sections), part)

    def _show(self, what):
        """Shows the progress: on a terminal in one line that is redrawn, elsewhere a line every ten seconds."""
        share = f" {share_text(self._share)}" if self._share else ""
        planned = f"/{self._planned}" if self._planned else ""
        line = f"{self.name}{share} {len(self._done)}{planned} {what}"
        now = time.monotonic()
        if sys.stderr.isatty():
            print(f"\r\033[K{line[:110]}", end="", file=sys.stderr, flush=True)
        elif now - self._shown > 10:
            print(line, file=sys.stderr, flush=True)
            self._shown = now

    def _clear(self):
        if sys.stderr.isatty():
            print("\r\033[K", end="", file=sys.stderr, flush=True)

    def _write_replays(self):
        """Runs the scenes of all replays and writes their pages. A run that diverges ends early, as its page shows."""
        runs = self.out / f"{self.name}_replays"
        try:
            for file, *scenes in self._replays:
                self._show(f"replay {file}")
                for scene in scenes:  # a page names each side by its folder
                    shown = {key: value for key, value in scene.items() if key != "expect"}
                    try:  # 4 MB: two small runs fit on a page that opens at once
                        malha.run(shown | {"outputs": {"page": {"max_megabytes": 4}}}, runs / scene["name"], threads=1)
                    except malha.Diverged:
                        pass
                subprocess.run([malha._command(), "page", *(runs / scene["name"] for scene in scenes), "--out", self.out / file],
                               check=True, stdout=subprocess.DEVNULL)
        finally:
            shutil.rmtree(runs, ignore_errors=True)

    def _write(self, command):
        """Writes all results into the folder, and prints them."""
        self.out.mkdir(parents=True, exist_ok=True)
        self._write_replays()
        self._clear()
        result = {"study": self.name, "what": self.what, "quick": self.quick, "command": command, "build": self.builds[0],
                  **({"machines": self.builds} if len(self.builds) > 1 else {}),
                  "sections": self.sections, "rows": self.rows}
        for name, figure in self._figures.items():
            figure.text(0.01, 0.075 / figure.get_figheight(), caption(result), fontsize=8, color="#555555")
            figure.subplots_adjust(bottom=max(0.9 / figure.get_figheight(), figure.subplotpars.bottom))
            figure.savefig(self.out / f"{name}.svg", metadata={"Date": None})
            figure.savefig(self.out / f"{name}.png", dpi=145)
            matplotlib.pyplot.close(figure)  # which the script has imported that made the figure
        columns = list(dict.fromkeys(key for row in self.rows for key in row))
        table = io.StringIO()
        writer = csv.DictWriter(table, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows([{key: _field(value) for key, value in row.items()} for row in self.rows])
        (self.out / f"{self.name}.csv").write_text(table.getvalue(), encoding="utf-8")
        (self.out / f"{self.name}.json").write_text(json.dumps(result, indent=1, ensure_ascii=False) + "\n",
                                                    encoding="utf-8")
        if self.table:
            lines = [f"{caption(result)}.", "", *self.table]
            (self.out / f"{self.name}.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
        (self.out / "index.html").write_text(page(self.out), encoding="utf-8")
        print(f"{self.name}: {self.what}")
        for section in self.sections:
            print(f"  {section['title']}")
            for sentence in section["sentences"]:
                print(f"    {sentence}")
        print(f"rows        {self.out / self.name}.csv, {self.out / self.name}.json\n"
              f"charts      {self.out / self.name}_*.svg, .png")
        if self.table:
            print(f"table       {self.out / self.name}.md")
        for file, *_ in self._replays:
            print(f"replay      {self.out / file}")
        print(f"page        {self.out / 'index.html'}", flush=True)

    def _say_missing(self, command):
        """Names the cells that no share has measured, on standard error."""
        for number, keys in sorted(self._missing.items()):
            share = f"{number}/{self._shares}"
            lacks = " lacks" if number in self._merged["given"] else ", which has no journal, lacks"
            shown = ", ".join(f'"{key}"' for key in list(keys)[:20]) + (" and others" if len(keys) > 20 else "")
            print(f"malha study: {self.name}: share {share}{lacks} {counted(len(keys), 'cell')}: {shown}; to measure: "
                  f"{command} --share {share}", file=sys.stderr)


# ---- Journals and shares ---------------------------------------------------------------------------------------------


def refuse(place, found, allowed):
    """Raises malha.InputError with a message in malha's form."""
    raise malha.InputError(f"{place}: found {found}; allowed: {allowed}")


def share_of(text):
    """The share (I, N) that a text such as "2/3" names: of the cells and groups of cells in the order in which a study
    requests them, those numbered I, I + N and so on."""
    parts = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text, re.ASCII)
    share = (int(parts[1]), int(parts[2])) if parts else (0, 0)
    if not 1 <= share[0] <= share[1] <= MOST_SHARES:
        raise argparse.ArgumentTypeError(f'found "{text}"; allowed: I/N, such as 2/3, with 1 <= I <= N <= {MOST_SHARES}')
    return share


def share_text(share):
    return f"{share[0]}/{share[1]}"


def journal_name(study, quick, share):
    """The file name of a journal: NAME.cells.jsonl, NAME.quick.cells.jsonl, and NAME.2of3.cells.jsonl of a share."""
    return study + (f".{share[0]}of{share[1]}" if share else "") + (".quick" if quick else "") + ".cells.jsonl"


def _record(line):
    """The JSON object of a journal's line; None where the line is torn, which a process leaves that was killed."""
    try:
        record = json.loads(line) if line.endswith(b"\n") else None
    except ValueError:
        return None
    return record if isinstance(record, dict) else None


def _open_journal(path, head, keep):
    """The cells of a journal and its file, to which cells are appended. A journal with another head, or another file of this
    name, is renamed to .old; what follows a torn line is removed."""
    journal = open(path, "ab+")
    try:
        fcntl.flock(journal, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        raise OSError(f"{path}: another malha study is using it") from None
    journal.seek(0)
    lines = journal.read().splitlines(keepends=True)
    cells, size = {}, 0
    first = _record(lines[0]) if lines else None
    if first is not None and first == head | ({"program": first.get("program")} if keep else {}):
        size = len(lines[0])
        for record, line in ((_record(line), line) for line in lines[1:]):
            if record is None or "key" not in record or "value" not in record:
                break
            cells[record["key"]] = record["value"]
            size += len(line)
    elif lines:
        path.with_name(path.name + ".old").write_bytes(b"".join(lines))
    journal.truncate(size)
    if size == 0:
        journal.write(json.dumps(head).encode() + b"\n")
    journal.flush()
    return cells, journal


def read_shares(folders, head, keep):
    """The cells of all shares whose journals lie in the folders, for a merge. Refuses what would not give the results of one
    process: a folder without a journal or named twice, a torn line, another study, version or (without keep) program, and
    a cell that two journals contradict each other about.

    head: the first line of a journal of this program. Returns a dict: shares (their number N), given (those that have a
    journal), cells (by key; dicts, and those in a list, name their "machine" if there are several), builds (version and
    machine of the journals, with "program"), and found_in (the first journal of each build).
    """
    name, what = head["study"], ("the quick " if head["quick"] else "") + head["study"]
    form = re.compile(re.escape(name) + r"\.(\d{1,6})of\d{1,6}" + (r"\.quick" if head["quick"] else "") + r"\.cells\.jsonl")
    for number, folder in enumerate(folders):
        if folder.resolve() in [before.resolve() for before in folders[:number]]:
            refuse("malha study: --merge", f"'{folder}' twice", "each folder once")
    found = {"shares": 0, "given": set(), "cells": {}, "builds": [], "found_in": []}
    places = {}  # journal, line and number of the build of each cell, by key
    for folder in folders:
        allowed = f"a folder in which malha study {name} --share leaves its {journal_name(name, head['quick'], (1, 2))}"
        try:
            journals = [(int(match[1]), folder / match[0]) for match in map(form.fullmatch, os.listdir(folder)) if match]
        except OSError as error:
            refuse(folder, error.strerror, allowed)
        if not journals:
            refuse(folder, f"no journal of a share of {what}", allowed)
        for _, journal in sorted(journals):
            lines = journal.read_bytes().splitlines(keepends=True)
            if not lines:
                refuse(journal, "nothing", "the head of a share's journal")
            for number, line in enumerate(lines, 1):
                place, record = f"{journal}: line {number}", _record(line)
                if record is None:
                    refuse(place, "a torn line", "complete lines of JSON; its command resumes the share there, or starts anew "
                           "without this file")
                if number == 1:
                    share = _checked_share(place, record, head, keep)
                    found["shares"] = found["shares"] or share[1]
                    if share[1] != found["shares"]:
                        refuse(place, f"share {share_text(share)}", f"shares of {found['shares']}, as in {found['found_in'][0]}")
                    found["given"].add(share[0])
                    build = record["build"] | {"program": record["program"]}
                    if build not in found["builds"]:
                        found["builds"].append(build)
                        found["found_in"].append(journal)
                    continue
                if "key" not in record or "value" not in record:
                    refuse(place, "no cell", "a key and its value")
                key = record["key"]
                if found["cells"].setdefault(key, record["value"]) != record["value"]:
                    refuse(place, f"'{key}', measured again with another result than in {places[key][0]}",
                           "one journal of each share")
                places.setdefault(key, (f"{journal}, line {number}", found["builds"].index(build)))
    if len(found["builds"]) > 1:
        for key, cell in found["cells"].items():
            build = found["builds"][places[key][1]]
            for part in cell if isinstance(cell, list) else [cell]:
                if isinstance(part, dict):
                    part["machine"] = f"{maker(build)}; program {build['program']}"
    return found


def _checked_share(place, record, head, keep):
    """The share whose journal begins with this line. Refuses one whose cells are not comparable with those of `head`."""
    for key in ("study", "quick", "build", "program", "share"):
        if key not in record:
            refuse(place, f"no '{key}'", "the head of a share's journal")
    for key in head["build"]:
        if key not in record["build"]:
            refuse(place, f"no '{key}'", "the head of a share's journal")
    for key, found, allowed, more in (
            ("study", record["study"], head["study"], ""), ("quick", record["quick"], head["quick"], ""),
            ("on", record.get("on", ""), head.get("on", ""), ""),
            ("malha", record["build"]["malha_version"], head["build"]["malha_version"], ", as this program"),
            ("program", record["program"], head["program"], ", this one; or --keep, which takes other builds")):
        if found != allowed and not (keep and key == "program"):
            refuse(place, f"{key} {json.dumps(found)}", json.dumps(allowed) + more)
    try:
        return share_of(str(record["share"]))
    except argparse.ArgumentTypeError:
        refuse(place, f"the share {json.dumps(record['share'])}", "such as 1/3")


def machine(cell):
    """{"machine": ...} for study.row() if cells come from several machines, else {}. cell: a dict, or a list of dicts."""
    part = cell[0] if isinstance(cell, list) and cell else cell
    return {"machine": part["machine"]} if isinstance(part, dict) and "machine" in part else {}


# ---- Results ---------------------------------------------------------------------------------------------------------


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


def rms_distance(x, y):
    """RMS distance of particles, m. x, y: (N, 3), m."""
    return np.linalg.norm(x - y) / math.sqrt(len(x))


def _build(on):
    """Version and flags of malha, and the processor. Raises malha.InputError where the backend has no device."""
    report = malha.Simulation({"name": "build", "duration": 1, "solver": {"type": "pbd"}, "bodies": [
        {"name": "point", "mass": 1, "shape": {"lattice": {"min": [0, 0, 0], "max": [1, 1, 1], "count": [1, 1, 1]}}}]},
        **on).report()
    return {key: report[key] for key in ("malha_version", "compiler", "flags", "instructions", "cpu")} | {
        "cores": len(os.sched_getaffinity(0))}


def _program():
    """A hash of malha's modules and of the scripts, which distinguishes what measured a journal's cells."""
    files = [sys.modules[name].__file__ for name in ("_malha", "_malha_reference", "__main__") if name in sys.modules]
    here = pathlib.Path(__file__).parent  # a script may import another one
    loaded = {pathlib.Path(module.__file__) for module in list(sys.modules.values()) if getattr(module, "__file__", None)}
    files += sorted(file for file in loaded if file.parent == here and str(file) not in files)
    return hashlib.sha256(b"".join(pathlib.Path(file).read_bytes() for file in files)).hexdigest()[:16]


def counted(number, word):
    """The number with its noun: "1 cell", "2 cells"."""
    return f"{number} {word}" + ("s" if number != 1 else "")


def machine_text(build):
    return f"{build['cpu']}, {counted(build['cores'], 'core')}"


def maker(build):
    """The program and machine that measured cells. Of the compiler's flags the relevant ones; NAME.json has all."""
    flags = [flag for flag in build["flags"].split() if flag.startswith(("-O", "-march", "-fsan"))]
    return (f"malha {build['malha_version']}, {' '.join([build['compiler'], *flags])}, {build['instructions']}; "
            f"{machine_text(build)}")


def caption(result):
    """The line below a chart: malha, compiler, machine or machines, and command."""
    made = maker(result["build"])
    if "machines" in result:
        machines = list(dict.fromkeys(map(machine_text, result["machines"])))
        made = "; ".join([f"malha {result['build']['malha_version']}",
                          f"{len(result['machines'])} builds or machines, which the rows name",
                          *machines[:3], *(["and others"] if len(machines) > 3 else [])])
    return f"{made}; {result['command']}"


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
    files = list(folder.glob("*.json"))
    for file in sorted(files, key=lambda file: (STUDIES.index(file.stem) if file.stem in STUDIES else len(STUDIES), file)):
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
    link = '<p><a href="results.html">The results in one look</a></p>\n' if (folder / "results.html").exists() else ""
    return (f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>malha: studies</title><style>{STYLE}'
            f"</style></head><body>\n<h1>malha: studies</h1>\n{link}<ul>\n" + "\n".join(contents) + "</ul>\n" +
            "\n".join(body) + "</body></html>\n")


# ---- The command line ------------------------------------------------------------------------------------------------


class _Stopped(KeyboardInterrupt):
    """A signal that stops the study. A second one ends the process at once."""


def _stop(number, _):
    signal.signal(number, signal.SIG_DFL)
    raise _Stopped(number)


def folder_of(given):
    """The folder of the results. given: the options --out and --quick."""
    return given.out or pathlib.Path("out", "study_quick" if given.quick else "study")


def _options_on(given):
    """The options that name the backend, as typed."""
    return (["--backend", given.backend] if given.backend else []) + (["--for", given.machine] if given.machine else [])


def main(name, what, measure, *, only=None, any_backend=False):
    """Runs a study as its command line says, writes its results, and exits with the status of `malha study`.

    measure: a function of the Study. only: names of parts, of which the option --only chooses some; they are handed to
    measure as a second argument. any_backend: whether the study runs on other backends than the host.
    """
    parser = argparse.ArgumentParser(prog=f"malha study {name}", description=what + ".")
    parser.add_argument("--quick", action="store_true", help="measure smaller cases and fewer points")
    parser.add_argument("--out", type=pathlib.Path, metavar="FOLDER",
                        help="folder of the results; out/study, or out/study_quick, if not given")
    parser.add_argument("--threads", type=int, default=1, metavar="N", help="threads of a simulation (1)")
    parser.add_argument("--backend", metavar="NAME", help="openmp (default), serial, or cuda: a device, in builds that have it")
    parser.add_argument("--for", dest="machine", metavar="MACHINE",
                        help="the machine that patches are cut for: cpu (default), a100, h100 or h200")
    parser.add_argument("--keep", action="store_true",
                        help="also use measurements that another build of malha or of the script left in the folder")
    shares = parser.add_mutually_exclusive_group()
    shares.add_argument("--share", type=share_of, metavar="I/N", help="measure only one of N shares, for --merge")
    shares.add_argument("--merge", type=pathlib.Path, nargs="+", metavar="DIR",
                        help="combine the shares that these folders hold; nothing is measured")
    parser.add_argument("--all", action="store_true", help="then run the studies that follow this one in `malha study all`")
    parser.add_argument(UNMERGED, default="", help=argparse.SUPPRESS)
    if only:
        parser.add_argument("--only", nargs="+", choices=only, metavar="PART", help="measure some parts: " + ", ".join(only))
    given = parser.parse_args()
    given.backend = None if given.backend == "openmp" else given.backend
    chosen, status = getattr(given, "only", None), 0
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:  # as Ctrl-C is for background jobs of a shell
            signal.signal(number, _stop)
    try:
        if _options_on(given) and not any_backend:
            refuse(f"malha study {name}", f"\"{' '.join(_options_on(given))}\"",
                   "accuracy and scaling, which run on any backend; the others run on the host")
        study = Study(name, what, given)
        measure(study, chosen or only) if only else measure(study)
        command = shlex.join(["malha", "study", name, *(["--quick"] if given.quick else []), *_options_on(given),
                              *(["--only", *chosen] if chosen else [])])
        if given.share:
            study._clear()
            print(f"share       {share_text(given.share)} of {name}: {counted(len(study._done), 'cell')} in "
                  f"{study.out / journal_name(name, given.quick, given.share)}", flush=True)
        elif study._missing:
            study._say_missing(command)
            status = UNMET
        else:
            study._write(command + (f" --merge, {counted(study._shares, 'share')}" if given.merge else ""))
    except KeyboardInterrupt as stopped:
        typed = [word for word in sys.argv[1:] if word != "--all" and not word.startswith(UNMERGED)]
        print(f"{chr(10) if sys.stderr.isatty() else ''}interrupted; go on with: "
              f"{shlex.join(['malha', 'study', 'all' if given.all else name, *typed])}", file=sys.stderr)
        sys.exit(128 + (stopped.args[0] if stopped.args else signal.SIGINT))
    except (malha.InputError, malha.Diverged, OSError) as error:
        print(f"malha study: {error}" if isinstance(error, OSError) else error, file=sys.stderr)
        status = (OUT_OF_MEMORY if isinstance(error, malha.OutOfMemory) else BAD_INPUT if isinstance(error, malha.InputError)
                  else DIVERGED if isinstance(error, malha.Diverged) else FAILED)
    except Exception:  # an error of the script: the researcher who changes it needs to know where
        traceback.print_exc()
        sys.exit(FAILED)
    if status and not (given.all and given.merge):
        sys.exit(status)
    if given.all:
        _go_on(name, given, [*filter(None, given.unmerged.split(",")), *([name] if status else [])])


def _go_on(name, given, unmerged):
    """Goes on with what follows the study in `malha study all`: the next study, or at last the page of results. Each has a
    process of its own, so that memory and times of one do not disturb the next. The exit status is then UNMET if some
    studies could not be merged."""
    here, following = pathlib.Path(sys.argv[0]), STUDIES[STUDIES.index(name) + 1:]
    if following:
        words = [word for word in sys.argv[1:] if not word.startswith(UNMERGED)]
        os.execv(sys.executable, [sys.executable, str(here.with_name(f"{following[0]}.py")), *words,
                                  *([f"{UNMERGED}={','.join(unmerged)}"] if unmerged else [])])
    if not given.share and len(unmerged) < len(STUDIES):
        subprocess.run([sys.executable, here.with_name("results.py"), "--out", folder_of(given)], check=True)
    if unmerged:
        print(f"malha study all: not merged: {', '.join(unmerged)}, for the reasons above", file=sys.stderr)
        sys.exit(UNMET)
