# SPDX-License-Identifier: Apache-2.0
"""malha study results: its page has the numbers of the folder's JSON, and names what the folder lacks."""
import html
import json
import re
import subprocess
from html.parser import HTMLParser

import pytest
from conftest import COMMAND, run_study

pytest.importorskip("matplotlib")
BUILD = {"malha_version": "0.1.0", "compiler": "GNU", "flags": "", "instructions": "avx2", "cpu": "a processor", "cores": 2}
MEASURED = ["bounces", "elastic pendulum"]  # cheap protocols, one that passes and one that fails


def save(folder, name, rows, sections):
    """A result of the shape that a study leaves."""
    (folder / f"{name}.json").write_text(json.dumps({
        "study": name, "what": name, "quick": True, "command": f"malha study {name} --quick", "build": BUILD, "rows": rows,
        "sections": [{"title": title, "sentences": [], "chart": chart, "columns": [], "rows": [], "replays": []}
                     for title, chart in sections]}))


def setting(series, settings, ms, error, ours=True, **more):
    return {"case": "orbit", "series": series, "settings": settings, "variant": False, "ours": ours, "precision": "double",
            "status": "diverged" if error is None else "finished", "time_s": 1.0, "truth_known_to_m": 0.0, "rms_error_m": error,
            "ms_per_s": ms} | more


ACCURACY = [
    setting("XPBD, substeps, float", "4x1", 0.15, 0.03), setting("XPBD, substeps, float", "16x1", 0.4, 0.003),
    setting("Desbrun, substeps", "1, r = 0", 0.1, 1.5), setting("explicit Euler", "1 a frame", 0.04, None, False),
    setting("RK4", "4 a frame", 0.11, 3e-5, False), setting("RK4", "64 a frame", 1.1, 1e-10, False),
    setting("PBD, iterations, float", "1x1", 0.2, 0.09, case="sheet7", truth_known_to_m=8e-11),
    setting("Desbrun, substeps", "1, r = 0", 0.3, 0.004, case="sheet7", truth_known_to_m=8e-11)]
STABILITY = [{"map": "steps", "panel": panel, "x": x, "y": 0.1, "verdict": verdict, "warned": warned}
             for panel, x, verdict, warned in (("PBD", 0.1, "bounded but wrong", True), ("PBD", 1, "stable", False),
                                               ("RK4", 0.1, "diverged", False), ("Desbrun, dense", 0.1, "stable", True))] + [
    {"map": "weight", "panel": "filtered", "x": 1, "y": 2}]


class Page(HTMLParser):
    """Texts of the page: cells (class, text) of marked spans, titles of points, identifiers and links."""

    def __init__(self, text):
        super().__init__()
        self.spans, self.titles, self.ids, self.links, self._open = [], [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self._open.append((tag, attrs))
        self.ids += [attrs["id"]] if "id" in attrs else []
        self.links += [value for key, value in attrs.items() if key in ("href", "xlink:href", "src")]

    def handle_data(self, data):
        tag, attrs = self._open[-1] if self._open else ("", {})
        if tag == "span" and attrs.get("class") in ("passed", "failed"):
            self.spans.append((attrs["class"], data))
        if tag == "title" and len(self._open) > 1:
            self.titles.append(data)

    def handle_endtag(self, tag):
        while self._open and self._open.pop()[0] != tag:
            pass


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder of results without those of scaling, and its page."""
    out = tmp_path_factory.mktemp("study") / "the results"
    measured = run_study("validation", "--quick", "--out", out, "--only", *MEASURED)
    assert measured.returncode == 0, measured.stderr
    save(out, "accuracy", ACCURACY, [("A spring: what accuracy costs", "accuracy_orbit_cost")])
    save(out, "stability", STABILITY, [("Time step", "stability_steps"), ("Other", "stability_weight")])
    for name in ("steps", "weight"):
        (out / f"stability_{name}.svg").write_text(f'<svg width="9" height="9"><g id="map_{name}"/></svg>')
    ended = run_study("results", "--out", out)
    assert ended.returncode == 0, ended.stderr
    assert "Warning" not in ended.stderr
    return out


@pytest.fixture(scope="module")
def text(folder):
    return (folder / "results.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


def test_each_protocol_method_and_mesh_is_shown_as_passed_or_failed_with_its_largest_error(folder, page):
    result = json.loads((folder / "validation.json").read_text())
    worst = {}
    for row in result["rows"]:
        key = row["protocol"], row["method"], row["mesh"]
        passed, error = worst.get(key, (True, 0))
        worst[key] = passed and row["within"], max(error, row["error"])
    assert {protocol for protocol, _, _ in worst} == set(MEASURED)
    assert len(page.spans) == len(worst)
    for (kind, words), ((_, _, mesh), (passed, error)) in zip(page.spans, worst.items()):
        assert kind == ("passed" if passed else "failed"), words
        assert words.startswith("failed: ") != passed, words
        assert float(words.removeprefix("failed: ").split()[0]) == pytest.approx(100 * error, rel=0.06)
        assert words.endswith(f"({mesh})")
    assert {kind for kind, _ in page.spans} == {"passed", "failed"}


def test_the_sentence_about_passed_and_failed_counts_them(text, page):
    passed = sum(kind == "passed" for kind, _ in page.spans)
    assert f"{passed} of {len(page.spans)} methods and kinds of mesh have passed" in text
    assert "all of them in 1 of 2 protocols: bounces." in text


def test_the_bar_of_each_protocol_is_shown(folder, text):
    bars = {row["protocol"]: row["bar"] for row in json.loads((folder / "validation.json").read_text())["rows"]}
    for protocol, bar in bars.items():
        assert re.search(rf"<td rowspan=\"\d+\">{protocol}<td rowspan=\"\d+\">{100 * bar:g} %", text)


def test_each_setting_in_the_chart_of_speed_and_accuracy_is_named_with_its_error_and_cost(page):
    def named(row):
        error = "diverged" if row["rms_error_m"] is None else f"{row['rms_error_m']:.2g} m"
        return f"{row['series']}, {row['settings']}: {error}, {row['ms_per_s']:.3g} ms per s"

    assert sorted(map(named, ACCURACY)) == sorted(title for title in page.titles if "ms per s" in title)


def test_the_chart_and_the_table_name_what_each_case_is_compared_with(text):
    for words in ("closed form", "same equations by RK4 with fine steps, known to 8e-11 m"):
        assert text.count(words) >= 2, words


def test_the_cheapest_settings_are_those_of_the_rows(text):
    table = html.unescape(re.search(r"<details open>.*?</details>", text, re.S)[0])
    orbit, sheet = [line.split("<td>")[1:] for line in table.splitlines() if line.startswith("<tr><td>")]
    assert orbit[0].startswith("A spring, after 1 s") and sheet[0].startswith("sheet7, after 1 s")
    fast, fine, rk4 = "XPBD, substeps, float, 4x1: 0.15", "XPBD, substeps, float, 16x1: 0.4", "RK4, 4 a frame: 0.11"
    assert [re.findall(r"<(?:span|i)>([^<]*)", cell) for cell in orbit[2:]] == [[fast, rk4], [fine, rk4], [rk4], [rk4]]
    assert [re.findall(r"<(?:span|i)>([^<]*)", cell) for cell in sheet[2:]] == [
        ["PBD, iterations, float, 1x1: 0.2"], ["Desbrun, substeps, 1, r = 0: 0.3"], [], []]


def test_the_sentence_about_accuracy_counts_the_cheapest(text):
    assert ("There are 8 settings in 2 charts. malha's methods reach an error of 1 cm in 2 of them; the cheapest that do are "
            "XPBD, substeps (1 chart); Desbrun, substeps (1 chart). An integrator that malha is compared with is cheaper there "
            "in 1.") in html.unescape(text)


def test_the_maps_of_stability_are_shown_with_a_sentence_that_counts_their_verdicts(text, page):
    assert ("2 of 4 settings are stable, 1 bounded but wrong and 1 diverged; stable everywhere: Desbrun, dense. malha run "
            "warns of 1 of the 2 that fail.") in text
    assert "results_stability_steps_map_steps" in page.ids
    assert not any("weight" in name for name in page.ids), "a chart without verdicts is no map"


def test_what_the_folder_lacks_is_named_with_the_command_that_measures_it(folder, text):
    assert f"<code>{html.escape(f'malha study scaling --quick --out {chr(39)}{folder}{chr(39)}')}</code> measures it" in text
    assert text.count("This folder has no ") == 1
    assert not (folder / "scaling.json").exists()


def test_the_page_stands_by_itself_and_its_identifiers_are_its_own(page):
    assert len(page.ids) == len(set(page.ids))
    for link in page.links:
        assert link.startswith("#") and link[1:] in page.ids or link.startswith("index.html"), link


def test_the_first_page_links_to_it(folder):
    assert (folder / "index.html").read_text(encoding="utf-8").count('<a href="results.html">') == 1
    assert run_study("results", "--out", folder).returncode == 0
    assert (folder / "index.html").read_text(encoding="utf-8").count('<a href="results.html">') == 1


def test_the_speed_up_by_threads_is_that_of_the_rows(folder, tmp_path):
    save(tmp_path, "scaling", [
        {"kind": "strong", "method": method, "particles": particles, "threads": threads, "times_as_fast": times}
        for method, particles, threads, times in (("PBD", 289, 1, 1.0), ("PBD", 289, 4, 1.1), ("Desbrun", 10000, 4, 3.456))] + [
        {"kind": "launch", "threads": 8}], [])
    assert run_study("results", "--out", tmp_path).returncode == 0
    assert ("On 4 threads a step is 1.10 times (PBD, 289 particles) to 3.46 times (Desbrun, 10,000 particles) as fast as on "
            "one.") in (tmp_path / "results.html").read_text(encoding="utf-8")


def test_the_command_writes_the_page_too(folder, text):
    (folder / "results.html").unlink()
    ended = subprocess.run([COMMAND, "study", "results", "--out", folder], capture_output=True, text=True, check=False)
    assert ended.returncode == 0 and ended.stdout == f"page        {folder / 'results.html'}\n", ended.stderr
    assert (folder / "results.html").read_text(encoding="utf-8") == text
    refused = subprocess.run([COMMAND, "study", "results", "--out", folder, "--share", "1/2"], capture_output=True, text=True,
                             check=False)
    assert refused.returncode == 2
    assert refused.stderr.startswith("malha study results: found --share 1/2; allowed: --quick and --out")


def test_a_folder_that_does_not_exist_is_refused(tmp_path):
    ended = run_study("results", "--out", tmp_path / "none")
    assert ended.returncode == 2
    assert ended.stderr.startswith(f"malha study results: {tmp_path / 'none'}: found no folder; allowed: ")
    assert not (tmp_path / "none").exists()
