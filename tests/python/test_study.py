# SPDX-License-Identifier: Apache-2.0
"""tools/study/study.py: cells are measured once and kept, shares merge into the results of one process, what does not fit
is refused with its line, replays are pages, and a study that is stopped goes on. Times are never asserted."""
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time

import pytest
from conftest import COMMAND, ROOT, run_study

pytest.importorskip("matplotlib")

STUDY = r'''
import os, pathlib, sys, time
sys.path.insert(0, os.environ["STUDIES"])
import study as studies

def measured(key, value):
    if key == "square 3" and pathlib.Path("wait").exists():
        pathlib.Path("waits").touch()
        time.sleep(60)
    with open("measured", "a") as file:
        file.write(key + "\n")
    return {"y": value}

def flight(name, dt):
    """A particle whose gravity grows with the step, so that with 2^59 s it exceeds the largest float."""
    at = {"lattice": {"min": [0, 1, 0], "max": [0, 1, 0], "count": [1, 1, 1]}}
    return {"name": name, "duration": dt, "solver": {"type": "pbd", "dt": dt, "substeps": 1}, "expect": {"max_strain": 0},
            "gravity": [0, -dt, 0], "bodies": [{"name": "particle", "shape": at, "mass": 1}]}

def measure(study):
    """Five squares, and a cell that needs another one."""
    study.plan(7)
    cells = study.cells([1, 2, 3, 4, 5], lambda x: f"square {x}", lambda x: measured(f"square {x}", x * x))
    def error():
        truth = study.cell("truth", lambda: measured("truth", 1 / 3))
        cell = study.cell("error", lambda: measured("error", truth["y"] - 0.3))
        study.row(error=cell["y"], lost=float("nan"), text='x, "y"', **studies.machine(cell))
    study.together(error)
    if study.partial:
        return
    for cell in cells:
        study.row(square=cell["y"], **studies.machine(cell), **({"cores": study.cores} if "CORES" in os.environ else {}))
    more = {}
    if "CHART" in os.environ:
        import matplotlib.pyplot as plt
        figure, axes = plt.subplots()
        axes.plot([1, 2], [3, 4])
        more = {"chart": ("line", figure), "replays": [("flights", "A flight & a long one", flight("1 s", 1.0), flight("2^59 s", 2.0**59))]}
    study.section("Squares <1>", [f"The largest is {cells[-1]['y']}."], ["x", "even"], [[1.23456, False], [None, True]], **more)

studies.main("squares", "Squares of numbers", measure)
'''
KEYS = ["square 1", "square 2", "square 3", "square 4", "square 5", "truth", "error"]


class Folder:
    """A folder with the study, and what its runs there leave."""

    def __init__(self, path):
        self.path = path
        (path / "squares.py").write_text(STUDY)

    def command(self, *words):
        return [sys.executable, "squares.py", *map(str, words)]

    def environment(self, **more):
        return {**os.environ, "STUDIES": str(ROOT / "tools" / "study"), **more}

    def run(self, *words, **more):
        return subprocess.run(self.command(*words), cwd=self.path, capture_output=True, text=True, check=False,
                              env=self.environment(**more))

    def measured(self):
        """The keys of the cells that were measured since the last call."""
        file = self.path / "measured"
        keys = file.read_text().splitlines() if file.exists() else []
        file.unlink(missing_ok=True)
        return keys

    def share(self, share, out, **head):
        """Measures a share, and changes the head of its journal, which it returns."""
        ended = self.run("--share", share, "--out", out)
        assert ended.returncode == 0, ended.stderr
        journal = self.path / out / f"squares.{share.replace('/', 'of')}.cells.jsonl"
        first, *cells = journal.read_text().splitlines(keepends=True)
        journal.write_text("".join([json.dumps(json.loads(first) | head) + "\n", *cells]))
        return journal

    def refused(self, *folders, keep=False):
        """What a merge says that refuses these folders; nothing is written."""
        ended = self.run("--merge", *folders, "--out", "merged", *(["--keep"] if keep else []))
        assert ended.returncode == (2 if ended.stderr else 0)
        assert not ended.stderr or not (self.path / "merged").exists()
        shutil.rmtree(self.path / "merged", ignore_errors=True)
        return ended.stderr.rstrip("\n")

    def other_build(self, **facts):
        head = json.loads((self.path / "one" / "squares.1of2.cells.jsonl").read_text().splitlines()[0])
        return head["build"] | facts


@pytest.fixture
def folder(tmp_path):
    return Folder(tmp_path)


# ---- Cells and results -----------------------------------------------------------------------------------------------


def test_a_study_leaves_rows_charts_and_a_page_and_measures_nothing_twice(folder):
    first = folder.run("--out", "out", CHART="1")
    assert first.returncode == 0, first.stderr
    assert folder.measured() == KEYS
    out = folder.path / "out"
    assert sorted(path.name for path in out.iterdir()) == [
        "index.html", "squares.cells.jsonl", "squares.csv", "squares.json", "squares_flights.html",
        "squares_line.png", "squares_line.svg"]
    result = json.loads((out / "squares.json").read_text())
    assert result["rows"][0] == {"error": 1 / 3 - 0.3, "lost": None, "text": 'x, "y"'}  # JSON has no NaN
    assert [row["square"] for row in result["rows"][1:]] == [1, 4, 9, 16, 25]
    assert result["sections"][0]["rows"] == [["1.235", "no"], ["", "yes"]]
    assert (out / "squares.csv").read_text().splitlines()[:3] == [
        "error,lost,text,square", f'{1 / 3 - 0.3},,"x, ""y""",', ",,,1"]
    page = (out / "index.html").read_text()
    build = result["build"]
    caption = f"malha {build['malha_version']}, {build['compiler']} -O"
    assert caption in page and caption in (out / "squares_line.svg").read_text()
    for words in ("Squares &lt;1&gt;", "The largest is 25.", "malha study squares. Rows", "<svg",
                  '<a href="squares_flights.html">A flight &amp; a long one</a>'):
        assert words in page, words
    names = re.findall(r'\bid="([^"]*)"', page)
    assert len(names) == len(set(names)) and all(name == "squares" or name.startswith("squares_line_") for name in names)
    journal = (out / "squares.cells.jsonl").read_bytes()
    again = folder.run("--out", "out", CHART="1")
    assert again.stdout == first.stdout and folder.measured() == []
    assert (out / "squares.cells.jsonl").read_bytes() == journal
    assert json.loads((out / "squares.json").read_text()) == result
    replay = (out / "squares_flights.html").read_text()
    assert "1 s" in replay and "2^59 s" in replay and "finished" in replay and "diverged" in replay
    (out / "squares_flights.html").unlink()
    import study as studies
    assert "squares_flights.html" not in studies.page(out)  # no link to a missing file


def test_cells_survive_a_crash_in_the_middle_of_a_line(folder):
    journal = folder.share("3/3", "out")
    complete = [{key: value for key, value in json.loads(line).items() if key != "s"} for line in journal.open()]
    whole = journal.read_bytes()
    for cut in (1, 40, len(whole) - 9):
        journal.write_bytes(whole[:-cut])
        folder.share("3/3", "out")
        assert [{key: value for key, value in json.loads(line).items() if key != "s"} for line in journal.open()] == complete


def test_a_file_that_is_no_journal_or_of_another_build_is_kept_beside(folder):
    out = folder.path / "out"
    out.mkdir()
    (out / "squares.1of3.cells.jsonl").write_text('not a journal\n{"key":"square 1","value":{"y":7}}\n')
    journal = folder.share("1/3", "out", program="another")
    assert folder.measured() == ["square 1", "square 4"]
    assert (out / "squares.1of3.cells.jsonl.old").read_text().startswith("not a journal\n")  # it may be hours of work
    assert folder.run("--share", "1/3", "--out", "out", "--keep").returncode == 0
    assert folder.measured() == [] and "another" in journal.read_text()
    folder.share("1/3", "out")
    assert folder.measured() == ["square 1", "square 4"]
    assert "another" in (out / "squares.1of3.cells.jsonl.old").read_text()


def test_an_interrupt_keeps_the_cells_and_says_how_to_go_on(folder):
    (folder.path / "wait").touch()
    for number in (signal.SIGINT, signal.SIGTERM):
        with subprocess.Popen(folder.command("--out", "o t"), cwd=folder.path, stderr=subprocess.PIPE, text=True,
                              env=folder.environment(), start_new_session=True) as running:
            while not (folder.path / "waits").exists() and running.poll() is None:
                time.sleep(0.02)
            busy = folder.run("--out", "o t")
            running.send_signal(number)
            said = running.stderr.read()
        assert running.returncode == 128 + number, said
        assert said.endswith("interrupted; go on with: malha study squares --out 'o t'\n") and "Traceback" not in said
        assert busy.returncode == 4 and "squares.cells.jsonl: another malha study is using it" in busy.stderr
        (folder.path / "waits").unlink()
    assert folder.measured() == ["square 1", "square 2"]
    assert not (folder.path / "o t" / "squares.csv").exists()
    (folder.path / "wait").unlink()
    assert folder.run("--out", "o t").returncode == 0
    assert folder.measured() == KEYS[2:]


# ---- Shares ----------------------------------------------------------------------------------------------------------


def test_every_cell_is_in_one_share_and_cells_that_depend_on_each_other_in_the_same(folder):
    for count in (3, 7):
        shares = []
        for number in range(1, count + 1):
            ended = folder.run("--share", f"{number}/{count}", "--out", f"of{count}")
            shares.append(folder.measured())
            assert ended.stdout.startswith(f"share       {number}/{count} of squares: {len(shares[-1])} cell"), ended.stderr
        assert sorted(key for share in shares for key in share) == sorted(KEYS)
        if count == 3:
            assert shares == [["square 1", "square 4"], ["square 2", "square 5"], ["square 3", "truth", "error"]]
    assert all(path.name.endswith(".cells.jsonl") for path in (folder.path / "of3").iterdir())


def test_merged_shares_have_the_results_of_one_process(folder):
    for number in (1, 2, 3):
        folder.share(f"{number}/3", str(number))
    folder.run("--out", "alone")
    folder.measured()
    merged = folder.run("--merge", "3", "1", "2", "--out", "merged")
    assert merged.returncode == 0 and folder.measured() == [], merged.stderr
    alone = json.loads((folder.path / "alone" / "squares.json").read_text())
    both = json.loads((folder.path / "merged" / "squares.json").read_text())
    assert both.pop("command") == "malha study squares --merge, 3 shares" and alone.pop("command") == "malha study squares"
    assert both["build"].pop("program")
    assert both == alone
    assert (folder.path / "merged" / "squares.csv").read_bytes() == (folder.path / "alone" / "squares.csv").read_bytes()


def test_a_merge_names_the_cells_that_are_missing_and_writes_nothing(folder):
    journal = folder.share("1/3", "one")
    journal.write_text("".join(journal.read_text().splitlines(keepends=True)[:2]))
    merged = folder.run("--merge", "one", "--out", "merged")
    assert merged.returncode == 1
    assert merged.stderr.splitlines() == [
        'malha study: squares: share 1/3 lacks 1 cell: "square 4"; to measure: malha study squares --share 1/3',
        'malha study: squares: share 2/3, which has no journal, lacks 2 cells: "square 2", "square 5"; to measure: malha study '
        "squares --share 2/3",
        'malha study: squares: share 3/3, which has no journal, lacks 2 cells: "square 3", "truth"; to measure: malha study '
        "squares --share 3/3"]  # "error", which needs "truth", is not requested without it
    assert not (folder.path / "merged").exists()


def test_rows_of_several_machines_name_theirs(folder):
    folder.share("1/2", "one")
    folder.share("2/2", "one", build=folder.other_build(cpu="other", cores=80))
    assert folder.refused("one") == ""
    assert folder.run("--merge", "one", "--out", "merged").returncode == 0
    result = json.loads((folder.path / "merged" / "squares.json").read_text())
    own, other = result["machines"]
    rows = result["rows"]
    assert rows[1]["machine"].endswith(f"; {own['cpu']}, {own['cores']} cores; program {own['program']}")
    assert rows[2]["machine"].endswith(f"; other, 80 cores; program {own['program']}")
    caption = f"2 builds or machines, which the rows name; {own['cpu']}, {own['cores']} cores; other, 80 cores; malha study"
    assert caption in (folder.path / "merged" / "index.html").read_text()
    refused = folder.run("--merge", "one", "--out", "cores", CORES="1")
    assert refused.returncode == 2 and not (folder.path / "cores").exists()
    assert (f"one/squares.2of2.cells.jsonl: line 1: found 80 cores; allowed: {own['cores']}, as in "
            "one/squares.1of2.cells.jsonl") in refused.stderr


def test_a_torn_line_is_refused_and_its_share_resumed(folder):
    folder.share("1/2", "one")
    journal = folder.share("2/2", "one")
    with open(journal, "a") as file:
        file.write('{"key":"square 9","val')
    assert folder.refused("one") == (
        "one/squares.2of2.cells.jsonl: line 6: found a torn line; allowed: complete lines of JSON; its command resumes the "
        "share there, or starts anew without this file")
    folder.measured()
    folder.share("2/2", "one")
    assert folder.measured() == [] and folder.refused("one") == ""
    with open(journal, "a") as file:
        file.write('{"key":"square 9"}\n')
    assert "line 6: found no cell; allowed: " in folder.refused("one")


def test_contradicting_cells_are_refused(folder):
    folder.share("1/2", "one")
    journal = folder.share("2/2", "two")
    with open(journal, "a") as file:
        file.write('{"key":"square 1","value":{"y":1}}\n')
    assert folder.refused("one", "two") == ""  # the same result is no contradiction
    with open(journal, "a") as file:
        file.write('{"key":"square 3","value":{"y":8}}\n')
    assert folder.refused("one", "two") == (
        "two/squares.2of2.cells.jsonl: line 7: found 'square 3', measured again with another result than in "
        "one/squares.1of2.cells.jsonl, line 3; allowed: one journal of each share")


def test_journals_of_other_versions_programs_and_numbers_of_shares_are_refused(folder):
    folder.share("1/2", "one")
    folder.share("2/2", "version", build=folder.other_build(malha_version="0"))
    assert 'line 1: found malha "0"; allowed: "' in folder.refused("one", "version")
    folder.share("2/2", "program", program="q")
    assert re.search(r'line 1: found program "q"; allowed: "\w+", this one; or --keep', folder.refused("one", "program"))
    assert folder.refused("one", "program", keep=True) == ""
    folder.share("2/3", "three")
    assert "line 1: found share 2/3; allowed: shares of 2, as in one/squares.1of2" in folder.refused("one", "three")
    folder.share("2/2", "quick", quick=True)
    assert "line 1: found quick true; allowed: false" in folder.refused("one", "quick")
    folder.share("2/2", "device", on="--backend cuda")
    assert 'line 1: found on "--backend cuda"; allowed: ""' in folder.refused("one", "device")
    journal = folder.share("2/2", "empty")
    journal.write_text(journal.read_text().replace('"2/2"', '"3/2"'))
    assert 'line 1: found the share "3/2"; allowed: such as 1/3' in folder.refused("one", "empty")
    journal.write_text("")
    assert "found nothing; allowed: the head of a share's journal" in folder.refused("one", "empty")
    journal.write_text("{}\n")
    assert "line 1: found no 'study'; allowed: the head of a share's journal" in folder.refused("one", "empty")


def test_folders_without_a_journal_or_named_twice_are_refused(folder):
    folder.share("1/1", "one")
    (folder.path / "empty").mkdir()
    assert folder.refused("empty") == (
        "empty: found no journal of a share of squares; allowed: a folder in which malha study squares --share leaves its "
        "squares.1of2.cells.jsonl")
    assert folder.refused("none").startswith("none: found No such file or directory; allowed: a folder")
    assert folder.refused("one", "empty/../one").startswith(
        "malha study: --merge: found 'empty/../one' twice; allowed: each folder once")


@pytest.mark.parametrize("words, said", [
    (["--share", "0/3"], 'found "0/3"; allowed: I/N, such as 2/3, with 1 <= I <= N <= 100000'),
    (["--share", "4/3"], 'found "4/3"'), (["--share", "1/3x"], 'found "1/3x"'), (["--share", "1/100001"], 'found "1/100001"'),
    (["--share", "1/3", "--merge", "a"], "not allowed with argument"),
    (["--backend", "serial"], 'malha study squares: found "--backend serial"; allowed: accuracy and scaling, which run on any'),
])
def test_options_that_do_not_fit_are_refused(folder, words, said):
    ended = folder.run(*words)
    assert ended.returncode == 2 and said in ended.stderr and "Traceback" not in ended.stderr
    assert [path.name for path in folder.path.iterdir()] == ["squares.py"]


def test_a_merge_needs_no_device(tmp_path):
    ended = run_study("scaling", "--backend", "cuda", "--merge", tmp_path / "none")
    assert ended.returncode == 2 and "none: found No such file or directory" in ended.stderr


def test_an_error_of_the_script_is_shown_where_it_is(folder):
    (folder.path / "squares.py").write_text(STUDY.replace('{"y": value}', 'value["y"]'))
    ended = folder.run("--out", "out")
    assert ended.returncode == 4 and "Traceback" in ended.stderr and "measured" in ended.stderr


# ---- The studies -----------------------------------------------------------------------------------------------------

SCRIPTS = {path.stem: path.read_text() for path in (ROOT / "tools" / "study").glob("*.py")}
STUDIES = sorted(name for name, text in SCRIPTS.items() if "\n    studies.main(" in text)


def test_the_command_hands_its_words_to_the_scripts_and_says_what_they_say(tmp_path):
    help = subprocess.run([COMMAND, "study", "--help"], capture_output=True, text=True, check=True).stdout
    said = dict(line.split(maxsplit=1) for line in help.partition("Studies:\n")[2].partition("\n\n")[0].splitlines())
    assert sorted(said) == sorted([*STUDIES, "results"])
    for name, what in said.items():
        assert f'"{what}"' in SCRIPTS[name]
    (tmp_path / "python").write_text('#!/bin/sh\nshift; echo "$@"\n')
    (tmp_path / "python").chmod(0o755)
    for words in (["--quick", "--keep", "--out", "a b"], ["--share", "2/3"], ["--merge", "a", "b", "--backend", "serial", "--for", "h200"]):
        handed = subprocess.run([COMMAND, "study", "scaling", *words], capture_output=True, text=True, check=True,
                                env={**os.environ, "MALHA_PYTHON": str(tmp_path / "python")}).stdout
        assert handed == " ".join(words) + "\n"


class AllStudies:
    """Scripts of three studies that measure one cell each, in the place of all studies, and of the page of results."""

    def __init__(self, path):
        self.path = path
        self.names = ["second", "first", "third"]  # they run in the order of the list, not of the alphabet
        text, lists = re.subn(r"^STUDIES = .*$", f"STUDIES = {self.names}", SCRIPTS["study"], flags=re.MULTILINE)
        assert lists == 1
        (path / "study.py").write_text(text)
        for name in self.names:
            self.write(name, "s.cell('one', lambda: 1); s.section(s.name)")
        (path / "results.py").write_text("import sys\nprint('results of', *sys.argv[1:])\n")

    def write(self, name, measure):
        (self.path / f"{name}.py").write_text(
            f"import study\ndef measure(s):\n    {measure}\nstudy.main('{name}', 'A study', measure)\n")

    def run(self, *words):
        return subprocess.run([sys.executable, f"{self.names[0]}.py", "--all", *words], cwd=self.path, capture_output=True,
                              text=True, check=False)


@pytest.fixture
def all_studies(tmp_path):
    return AllStudies(tmp_path)


def test_all_studies_run_one_after_the_other_then_their_results_and_an_interrupt_names_them_all(all_studies):
    ended = all_studies.run("--quick", "--out", "o t")
    assert ended.returncode == 0, ended.stderr
    assert re.findall(r"^(\w+): A study$", ended.stdout, re.MULTILINE) == all_studies.names
    assert ended.stdout.endswith("\nresults of --out o t\n")
    page = (all_studies.path / "o t" / "index.html").read_text()
    assert re.findall(r'<h2 id="(\w+)">', page) == all_studies.names
    all_studies.write(all_studies.names[1], "raise KeyboardInterrupt")
    ended = all_studies.run("--quick", "--out", "o t")
    assert ended.returncode == 130 and "results of" not in ended.stdout
    assert ended.stderr == "interrupted; go on with: malha study all --quick --out 'o t'\n"


def test_a_merge_of_all_studies_goes_on_after_those_that_lack_cells_and_names_them(all_studies):
    one, lacking, none = all_studies.names
    all_studies.write(lacking, "s.cells('ab', str, ord); s.section(s.name)")
    for share in ("1/2", "2/2"):
        ended = all_studies.run("--share", share, "--out", "shares")
        assert ended.returncode == 0 and "results of" not in ended.stdout, ended.stderr
    whole = all_studies.run("--merge", "shares", "--out", "whole")
    assert whole.returncode == 0 and whole.stderr == "" and whole.stdout.endswith("\nresults of --out whole\n")
    shares = all_studies.path / "shares"
    (shares / f"{lacking}.2of2.cells.jsonl").unlink()
    for journal in shares.glob(f"{none}.*"):
        journal.unlink()
    merged = all_studies.run("--merge", "shares", "--out", "merged")
    assert merged.returncode == 1
    lacks, has_no, last = merged.stderr.splitlines()
    assert lacks.startswith(f'malha study: {lacking}: share 2/2, which has no journal, lacks 1 cell: "b"; to measure: ')
    assert has_no.startswith(f"shares: found no journal of a share of {none}; allowed: ")
    assert last == f"malha study all: not merged: {lacking}, {none}, for the reasons above"
    assert re.findall(r"^(\w+): A study$", merged.stdout, re.MULTILINE) == [one]
    assert merged.stdout.endswith("\nresults of --out merged\n")
    for journal in shares.iterdir():
        journal.unlink()
    nothing = all_studies.run("--merge", "shares", "--out", "nothing")
    assert nothing.returncode == 1 and nothing.stderr.endswith(f"not merged: {', '.join(all_studies.names)}, for the reasons above\n")
    assert "results of" not in nothing.stdout and not (all_studies.path / "nothing").exists()


@pytest.mark.parametrize("name", STUDIES)
def test_no_study_measures_cells_of_other_shares(tmp_path, name):
    last = run_study(name, "--quick", "--share", "100000/100000", "--out", tmp_path)
    assert last.returncode == 0 and f"share       100000/100000 of {name}: 0 cells" in last.stdout, last.stderr
    merged = run_study(name, "--quick", "--merge", tmp_path, "--out", tmp_path / "merged")
    assert merged.returncode == 1 and "share 1/100000, which has no journal, lacks 1 cell: " in merged.stderr, merged.stderr
    assert not (tmp_path / "merged").exists()
