# SPDX-License-Identifier: Apache-2.0
"""The results of the studies in one look: results.html of a folder of results, with a link from its index.html.

    malha study results --out out/study

`malha study all` writes it at its end. It measures nothing: it reads accuracy.json, validation.json, stability.json and scaling.json of the folder, and names what
the folder lacks with the command that measures it. Each part is a function of a study's result (its JSON) that returns HTML;
its sentences are computed from the rows.
"""
import argparse
import html
import io
import json
import math
import pathlib
import re
import shlex
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import study as studies  # noqa: E402

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

WHAT = "Page that shows what other studies have found in one look, results.html; all ends with it"

STYLE = studies.STYLE + """
td, th { text-align: left; vertical-align: top; white-space: normal; }
.passed, .failed { white-space: nowrap; }
.passed { background: #e3f3e3; }
.failed { background: #fbe0e0; }
.lacks { background: #fff6d6; padding: 0.5rem 1rem; }
"""


def paragraph(*sentences):
    return "<p>" + html.escape(" ".join(sentences)) + "</p>\n"


def table_of(columns, rows):
    """rows: lists of cells, each HTML that begins with <td."""
    return ("<table>\n<tr><th>" + "</th><th>".join(map(html.escape, columns)) + "</th></tr>\n" +
            "\n".join("<tr>" + "".join(row) + "</tr>" for row in rows) + "\n</table>\n")


def field(text):
    return "<td>" + html.escape(text)


# ---- Speed against accuracy ------------------------------------------------------------------------------------------


# The beginning of a series' name, what the legend calls it, colour, marker and style of the line. The first that fits counts.
SERIES = [
    ("PBD", "PBD", "#1f77b4", "o", "-"),
    ("XPBD, iterations", "XPBD, iterations", "#ff7f0e", "s", "-"),
    ("XPBD, substeps, filtered", "XPBD, substeps, filtered bending", "#9467bd", "P", "-"),
    ("XPBD", "XPBD, substeps", "#d62728", "s", "-"),
    ("Desbrun, substeps", "Desbrun, substeps", "#2ca02c", "^", "-"),
    ("Desbrun, refine", "Desbrun, refinements", "#17becf", "v", "-"),
    ("Desbrun", "Desbrun, other variants", "#98c379", "<", "-"),
    ("explicit", "explicit Euler", "#bbbbbb", "x", ":"),
    ("symplectic", "symplectic Euler", "#777777", "+", "--"),
    ("RK4", "RK4", "#000000", "d", "--"),
    ("backward", "backward Euler, Newton", "#8c564b", "D", "--")]

# What each case is compared with, by its name without its number. None of it is malha's own.
REFERENCES = {
    "oscillator": "closed form", "orbit": "closed form", "cantilever": "heavy elastica, a boundary value problem",
    "catenary": "elastic catenary, from which the springs' rest is {:.1g} m",
    "sunk_beam": "rest of the same energy, by relaxation",
    "": "same equations by RK4 with fine steps, known to {:.1g} m"}
BEST = "#ffd54d"  # colour of malha's best
BOUNDS = (1e-1, 1e-2, 1e-3, 1e-4)  # m, errors in the table


def reference_of(row):
    return REFERENCES.get(row["case"].rstrip("0123456789."), REFERENCES[""]).format(row["truth_known_to_m"])


def finished(row):
    return row["status"] == "finished" and row["rms_error_m"] is not None


def cheapest(rows, bound):
    """The cheapest row whose error is at most the bound (m); None without one."""
    return min((row for row in rows if finished(row) and row["rms_error_m"] <= bound), key=lambda row: row["ms_per_s"],
               default=None)


def error_panel(axes, rows, title, labels):
    """Error over cost of one case. labels: a dict to which the tooltip of each point is added, by its identifier.

    The chart has the errors of malha's methods and a little more: what has blown up is at its upper edge, and integrators that
    are far more accurate are at its lower one.
    """
    ours = sorted((row for row in rows if row["ours"] and finished(row)), key=lambda row: row["ms_per_s"])
    low = min(row["rms_error_m"] for row in ours) / 10 or 1e-12
    high = min(3 * max(row["rms_error_m"] for row in rows if finished(row)), 10)
    axes.step([row["ms_per_s"] for row in ours], np.minimum.accumulate([row["rms_error_m"] for row in ours]), where="post",
              color=BEST, lw=5, zorder=0)
    by_series = {}
    for row in rows:
        by_series.setdefault(row["series"], []).append(row)
    for series, its_rows in by_series.items():
        _, _, colour, marker, dashes = next(one for one in SERIES if series.startswith(one[0]))
        curve = [(row["ms_per_s"], max(row["rms_error_m"], low)) for row in its_rows
                 if finished(row) and row["rms_error_m"] <= high]
        axes.plot(*zip(*curve), color=colour, ls=dashes, lw=0.5 if its_rows[0]["variant"] else 1)
        for row in its_rows:
            failed = not finished(row) or row["rms_error_m"] > high
            name = f"point_{len(labels)}"
            error = f"{row['rms_error_m']:.2g} m" if finished(row) else row["status"]
            labels[name] = f"{series}, {row['settings']}: {error}, {row['ms_per_s']:.3g} ms per s"
            axes.plot(row["ms_per_s"], high if failed else max(row["rms_error_m"], low), color=colour, gid=name, ls="none",
                      marker="$\\times$" if failed else marker, markersize=5, clip_on=False,
                      fillstyle="none" if row["precision"] == "double" and row["ours"] else "full")
    axes.set(xscale="log", yscale="log", ylim=(low, high))
    axes.set_title(title, fontsize=10, pad=8)
    axes.tick_params(labelsize=9)


def accuracy_chart(charts, titles):
    """The chart of all cases as SVG. charts: rows of each case and time. titles: of the cases."""
    wide = min(3, len(charts))
    tall = math.ceil(len(charts) / wide)
    figure, panels = plt.subplots(tall, wide, figsize=(15, 3.9 * tall + 1.1), squeeze=False)
    labels = {}
    for panel, ((case, time_s), rows) in zip(panels.flat, charts.items()):
        error_panel(panel, rows, f"{titles[case]}, after {time_s:g} s\n{reference_of(rows[0])}", labels)
    for panel in panels.flat[len(charts):]:
        panel.axis("off")
    for panel in panels[-1]:
        panel.set_xlabel("ms per simulated second", fontsize=10)
    for panel in panels[:, 0]:
        panel.set_ylabel("RMS error (m)", fontsize=10)
    shown = [{"color": colour, "marker": marker, "ls": dashes, "label": label} for _, label, colour, marker, dashes in SERIES]
    shown += [{"color": BEST, "lw": 5, "label": "the best of malha's"},
              {"color": "black", "marker": "$\\times$", "ls": "none", "label": "at the top: diverged, or an error of metres"}]
    figure.legend(handles=[plt.Line2D([], [], **style) for style in shown], loc="lower center", ncol=5, fontsize=10)
    figure.subplots_adjust(left=0.06, right=0.98, top=1 - 0.5 / figure.get_figheight(), bottom=1.5 / figure.get_figheight(),
                           hspace=0.36, wspace=0.17)
    picture = io.StringIO()
    figure.savefig(picture, format="svg", metadata={"Date": None})
    plt.close(figure)
    return re.sub(r'<g id="(point_\d+)">', lambda found: f"{found[0]}<title>{html.escape(labels[found[1]])}</title>",
                  picture.getvalue())


def accuracy(result, folder):
    charts = {}
    for row in result["rows"]:
        if row.get("ms_per_s") is not None:  # the case "order" has none
            charts.setdefault((row["case"], row["time_s"]), []).append(row)
    titles = {case: next((section["title"].rsplit(":", 1)[0] for section in result["sections"]
                          if section["chart"] == f"accuracy_{case}_cost"), case) for case, _ in charts}
    winners, reached, beaten, lines = {}, 0, 0, []
    for (case, time_s), rows in charts.items():
        line = [field(f"{titles[case]}, after {time_s:g} s"), field(reference_of(rows[0]))]
        for bound in BOUNDS:
            ours, other = (cheapest([row for row in rows if row["ours"] == whose], bound) for whose in (True, False))
            line.append("<td>" + "<br>".join(
                f"<{tag}>{html.escape(one['series'])}, {html.escape(one['settings'])}: {one['ms_per_s']:.3g}</{tag}>"
                for tag, one in (("span", ours), ("i", other)) if one))
            if bound == 1e-2 and ours:
                label = next(label for start, label, *_ in SERIES if ours["series"].startswith(start))
                winners[label] = winners.get(label, 0) + 1
                reached += 1
                beaten += other is not None and other["ms_per_s"] < ours["ms_per_s"]
        lines.append(line)
    order = sorted(winners.items(), key=lambda one: -one[1])
    return paragraph(
        f"There are {studies.counted(sum(map(len, charts.values())), 'setting')} in {studies.counted(len(charts), 'chart')}. malha's methods reach "
        f"an error of 1 cm in {reached} of them; the cheapest that do are " +
        ("; ".join(f"{label} ({studies.counted(wins, 'chart')})" for label, wins in order) or "none") +
        f". An integrator that malha is compared with is cheaper there in {beaten}.") + paragraph(
        "Down and to the left is better. Each point is a setting, which a pointer on it names; full marks are float, empty ones "
        "double. The second line above each chart says what it is compared with, which malha has not computed. Points at the "
        "lower edge of a chart are more accurate still."
    ) + studies.inline_svg(accuracy_chart(charts, titles), "results_accuracy") + (
        "<details open><summary>The cheapest setting for an error of at most so many metres, and its ms per simulated second: of "
        "malha's methods, and in italics of the integrators</summary>\n") + table_of(
        ["case", "compared with", *(f"{bound:g} m" for bound in BOUNDS)], lines) + "</details>\n"


# ---- Validation ------------------------------------------------------------------------------------------------------


def validation(result, folder):
    """One line for each protocol and method: its largest error by each kind of mesh, and whether it has passed."""
    section = next(section for section in result["sections"] if section["title"] == "Passed and failed")
    rows = [dict(zip(section["columns"], row)) for row in section["rows"]]  # the verdict's column has no name
    bars = {row["protocol"]: row["bar"] for row in result["rows"] if "bar" in row}
    kinds = {"grid": "grids", "irregular": "irregular meshes", "other": "others"}
    lines, counts = {}, {kind: [0, 0] for kind in kinds}
    for row in rows:
        kind = row["mesh"] if row["mesh"] in kinds else "other"
        words = ("failed: " if row[""] == "failed" else "") + row["largest error"] + (
            f" ({row['mesh']})" if kind == "other" else "")
        where = html.escape(f"at {row['at']}; cells: {row['cells']}")
        lines.setdefault(row["protocol"], {}).setdefault(row["method"], {}).setdefault(kind, []).append(
            f'<span class="{row[""]}" title="{where}">{html.escape(words)}</span>')
        counts[kind][0] += row[""] == "passed"
        counts[kind][1] += 1
    body = []
    for protocol, methods in lines.items():
        span = f'<td rowspan="{len(methods)}">'
        first = [span + html.escape(protocol), span + (f"{100 * bars[protocol]:g} %" if protocol in bars else "")]
        for method, cells in methods.items():
            body.append([*first, field(method), *("<td>" + "<br>".join(cells.get(kind, [])) for kind in kinds)])
            first = []
    clean = [protocol for protocol in lines if all(row[""] == "passed" for row in rows if row["protocol"] == protocol)]
    return paragraph(
        f"{sum(row[''] == 'passed' for row in rows)} of {len(rows)} methods and kinds of mesh have passed (" +
        "; ".join(f"{passed} of {count} by {kinds[kind]}" for kind, (passed, count) in counts.items() if count) +
        f"), and all of them in {len(clean)} of {studies.counted(len(lines), 'protocol')}" + (f": {', '.join(clean)}" if clean else "") +
        ".") + paragraph(
        "Shown is the largest error by the finest mesh that was measured; a pointer on it names where it is. A method passes if "
        "no error exceeds the bar.") + table_of(["protocol", "bar", "method", "grid", "irregular", "other meshes"], body)


# ---- Stability -------------------------------------------------------------------------------------------------------


def stability(result, folder):
    """The maps, whose rows have verdicts, each with its chart."""
    text, maps = "", {}
    for row in result["rows"]:
        if "verdict" in row:
            maps.setdefault(row["map"], []).append(row)
    for section in result["sections"]:
        rows = maps.get(section["chart"].removeprefix("stability_"))
        chart = folder / (section["chart"] + ".svg")
        if not rows or not chart.exists():
            continue
        count = {verdict: sum(row["verdict"] == verdict for row in rows)
                 for verdict in ("stable", "bounded but wrong", "diverged")}
        panels = list(dict.fromkeys(row["panel"] for row in rows))
        calm = [panel for panel in panels if all(row["verdict"] == "stable" for row in rows if row["panel"] == panel)]
        failed = [row for row in rows if row["verdict"] != "stable" and "warned" in row]
        text += f"<h3>{html.escape(section['title'])}</h3>\n" + paragraph(
            f"{count['stable']} of {studies.counted(len(rows), 'setting')} are stable, {count['bounded but wrong']} bounded but wrong and "
            f"{count['diverged']} diverged; stable everywhere: {'; '.join(calm) or 'none'}.",
            f"malha run warns of {sum(row['warned'] for row in failed)} of the {len(failed)} that fail." if failed else "")
        text += studies.inline_svg(chart.read_text(encoding="utf-8"), "results_" + section["chart"])
    return text


# ---- Scaling ---------------------------------------------------------------------------------------------------------


def scaling(result, folder):
    rows = [row for row in result["rows"] if row.get("kind") == "strong" and row.get("times_as_fast") is not None]
    most = max(row["threads"] for row in rows)
    last = sorted((row for row in rows if row["threads"] == most), key=lambda row: row["times_as_fast"])

    def named(row):
        return f"{row['times_as_fast']:.2f} times ({row['method']}, {row['particles']:,} particles)"

    chart = folder / "scaling_strong.svg"
    return paragraph(f"On {studies.counted(most, 'thread')} a step is {named(last[0])} to {named(last[-1])} as fast as on one.") + (
        studies.inline_svg(chart.read_text(encoding="utf-8"), "results_scaling") if chart.exists() else "")


# ---- The page --------------------------------------------------------------------------------------------------------


PARTS = [("accuracy", "Speed against accuracy", accuracy), ("validation", "Passed and failed", validation),
         ("stability", "Stability", stability), ("scaling", "Threads", scaling)]


def result_of(folder, name):
    """The result of a study in the folder; None where it has none with rows."""
    try:
        result = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return result if isinstance(result, dict) and result.get("study") == name and result.get("rows") else None


def page(folder):
    found = {name: result_of(folder, name) for name, _, _ in PARTS}
    quick = any(result["quick"] for result in found.values() if result)
    text = (f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>malha: results</title><style>{STYLE}</style>'
            '</head><body>\n<h1>malha: the results in one look</h1>\n<p><a href="index.html">All studies, with all their '
            "sections, charts and numbers</a></p>\n")
    for name, title, part in PARTS:
        text += f'<h2 id="{name}">{title}</h2>\n'
        if result := found[name]:
            text += part(result, folder) + (f'<p class="made">{html.escape(studies.caption(result))}. '
                                            f'<a href="index.html#{name}">All of {name}</a></p>\n')
        else:
            command = f"malha study {name}" + (" --quick" if quick else "") + f" --out {shlex.quote(str(folder))}"
            text += f'<p class="lacks">This folder has no {name}.json. <code>{html.escape(command)}</code> measures it.</p>\n'
    return text + "</body></html>\n"


def write(folder):
    """Writes results.html into the folder, and a link to it into index.html."""
    (folder / "results.html").write_text(page(folder), encoding="utf-8")
    (folder / "index.html").write_text(studies.page(folder), encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(prog="malha study results", description=WHAT + ".")
    parser.add_argument("--quick", action="store_true", help="of out/study_quick, if no folder is given")
    parser.add_argument("--out", type=pathlib.Path, metavar="FOLDER", help="folder of the results; out/study, if not given")
    given, others = parser.parse_known_args()
    folder = studies.folder_of(given)
    if others:
        print(f"malha study results: found {shlex.join(others)}; allowed: --quick and --out, because it measures nothing",
              file=sys.stderr)
        sys.exit(studies.BAD_INPUT)
    if not folder.is_dir():
        print(f"malha study results: {folder}: found no folder; allowed: one in which malha study has left its results",
              file=sys.stderr)
        sys.exit(studies.BAD_INPUT)
    write(folder)
    print(f"page        {folder / 'results.html'}")


if __name__ == "__main__":
    main()
