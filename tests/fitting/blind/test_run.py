"""Running sealed cases with a stand-in for the diagnosis: resumed, around failures, refused where it must."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fitting.blind.seal import MANIFEST, checksums, new_key, read_manifest
from fitting.blind_run import case_work, processes, running
from fitting.blind_run.case_work import diagnose_folder, diagnose_sent
from fitting.blind_run.results import DIAGNOSIS, FAILURE, HEAD, Results, data_checksum, default_results
from fitting.blind_run.running import Ran, run_cases
from fitting.cli import jaxstick as command
from fitting.progress import Silent
from jaxstick.errors import UserError
from jaxstick.record import load_dataset
from tests.fitting.blind import stub

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture
def cases(tmp_path) -> Path:
    """A set of four cases."""
    stub.made_set(tmp_path / "set", new_key(), [stub.answer("none")] * 4)
    return tmp_path / "set"


@pytest.fixture
def act(monkeypatch):
    """Lets another function stand for the diagnosis of a case."""

    def use(function):
        monkeypatch.setattr(running, "diagnose_folder", function)

    use(stub.diagnosed)
    return use


def ran(cases: Path, **options) -> Ran:
    return run_cases(cases, default_results(cases), Silent(), **{"workers": 2, **options})


def run_command(capsys, *words: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as ended:
        command(list(words), prog_name="jaxstick")
    out, err = capsys.readouterr()
    return int(ended.value.code or 0), out, err


def test_every_case_gets_its_diagnosis_beside_the_set(cases, act):
    before = checksums(cases)
    assert ran(cases, seed=5) == Ran(4, 0, 4, {})
    assert checksums(cases) == before
    results = default_results(cases)
    assert results == cases.with_name("set-results")
    names = {path.name for path in results.iterdir()}
    assert names == {HEAD, "case-0001", "case-0002", "case-0003", "case-0004"}
    assert [path.name for path in (results / "case-0001").iterdir()] == [DIAGNOSIS]
    lines = (cases.parent / stub.CALLS).read_text().split("\n")
    assert sorted(lines)[1:] == [f"case-000{number} 5 1" for number in (1, 2, 3, 4)]
    assert os.environ.get("NPROC") != "1"


def test_what_is_whole_and_of_the_same_data_is_not_done_again(cases, act):
    ran(cases)
    results = default_results(cases)
    (results / "case-0002" / DIAGNOSIS).write_text('{"schema": 1, "verd')
    other = json.loads((results / "case-0003" / DIAGNOSIS).read_text())
    other["data"]["sha256"] = "0" * 64
    (results / "case-0003" / DIAGNOSIS).write_text(json.dumps(other))
    (results / "case-0004" / DIAGNOSIS).unlink()
    assert ran(cases) == Ran(4, 1, 3, {})
    assert sorted(stub.calls(cases)[4:]) == ["case-0002", "case-0003", "case-0004"]
    assert ran(cases) == Ran(4, 4, 0, {})


def test_failures_end_nothing_and_are_tried_again(cases, act):
    act(stub.failing_in_two)
    found = ran(cases)
    assert (found.new, list(found.failed)) == (1, ["case-0002", "case-0003", "case-0004"])
    assert found.failed["case-0002"] == "The motion was lost."
    assert found.failed["case-0003"] == "The process that diagnosed it ended by SIGKILL."
    assert found.failed["case-0004"] == "What came back is no diagnosis of this case's data."
    results = Results(default_results(cases))
    assert results.failure("case-0002") == "The motion was lost."
    act(stub.diagnosed)
    assert ran(cases) == Ran(4, 1, 3, {})
    assert not (results.folder / "case-0002" / FAILURE).exists()


def test_an_exception_becomes_a_sentence(cases, monkeypatch):
    def broken(*_):
        raise ZeroDivisionError("planted\nin two lines")

    monkeypatch.setattr(case_work, "diagnose", broken)
    monkeypatch.setattr(case_work, "load_dataset", lambda folder: folder)
    outcome = diagnose_folder(cases / "case-0001", 0)
    assert outcome.diagnosis is None
    assert outcome.failure is not None
    assert outcome.failure.startswith("ZeroDivisionError: planted in two lines (test_run.py:")

    def mistaken(_):
        raise UserError("The rig has no mass.")

    monkeypatch.setattr(case_work, "load_dataset", mistaken)
    assert diagnose_folder(cases / "case-0001", 0).failure == "The rig has no mass."


def test_the_checksum_is_that_of_the_data_set():
    for folder in (ROOT / "data" / "rig1987", ROOT / "data" / "tribometer"):
        assert data_checksum(checksums(folder)) == load_dataset(folder).sha256


def test_a_run_that_is_killed_goes_on(cases, act):
    script = (
        "import sys\n"
        "from pathlib import Path\n"
        "from fitting.blind_run import running\n"
        "from fitting.progress import Silent\n"
        "from tests.fitting.blind import stub\n"
        "class Slow(Silent):\n"
        "    def advance(self, note=''):\n"
        "        print(note, flush=True)\n"
        "        sys.stdin.readline()\n"
        "if __name__ == '__main__':\n"
        "    running.diagnose_folder = stub.diagnosed\n"
        "    folder = Path(sys.argv[1])\n"
        "    running.run_cases(folder, running.Path(sys.argv[2]), Slow(), workers=1)\n"
    )
    program = cases.parent / "program.py"
    program.write_text(script)
    process = subprocess.Popen(
        [sys.executable, str(program), str(cases), str(default_results(cases))],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None and process.stdin is not None
    assert process.stdout.readline() == "case-0001\n"
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdin.close()
    process.stdout.close()
    time.sleep(0.2)
    found = ran(cases)
    assert found.before + found.new == 4 and found.before >= 1 and not found.failed
    assert stub.calls(cases).count("case-0001") == 1


@pytest.mark.parametrize(("limit", "fresh"), [(0.0, 3), (1e15, 1)])
def test_a_process_that_has_had_too_much_memory_is_replaced(tmp_path, monkeypatch, limit, fresh):
    monkeypatch.setattr(processes, "most_memory", lambda installed, workers: limit)
    folders = {f"case-{number}": tmp_path for number in range(3)}
    outcomes = dict(processes.on_cores(folders, 0, 1, stub.named_by_process))
    assert len({outcome.diagnosis for outcome in outcomes.values()}) == fresh


def test_a_process_may_have_more_memory_where_there_is_more():
    assert processes.most_memory(0, 2) == processes.most_memory(8e9, 2) == 3e9
    assert processes.most_memory(20e9, 2) == 5e9
    assert processes.most_memory(500e9, 2) == 8e9


def test_some_cases_only(cases, act):
    assert ran(cases, numbers=(2, 4)) == Ran(2, 0, 2, {})
    assert sorted(stub.calls(cases)) == ["case-0002", "case-0004"]
    with pytest.raises(UserError, match="there is no case 5; the set has 4, from 1 to 4"):
        ran(cases, numbers=(5,))


def test_what_is_not_whole_or_not_ours_is_refused(cases, act, tmp_path):
    with pytest.raises(UserError, match="may not lie in the folder of the cases"):
        run_cases(cases, cases / "results", Silent())
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear")
    with pytest.raises(UserError, match="not empty and holds no results"):
        run_cases(cases, tmp_path / "mine", Silent())
    ran(cases)
    with pytest.raises(UserError, match="another set, seed or version"):
        ran(cases, seed=1)
    assert ran(cases, seed=1, overwrite=True) == Ran(4, 0, 4, {})
    with (cases / "case-0002" / "run-01.csv").open("a") as stream:
        stream.write("3,4,5\n")
    with pytest.raises(UserError, match=r"case-0002/run-01\.csv: the file was changed"):
        ran(cases)
    shutil.rmtree(cases / "case-0002")
    with pytest.raises(UserError, match="the case is missing"):
        ran(cases)
    (cases / MANIFEST).unlink()
    with pytest.raises(UserError, match="no finished set of cases"):
        ran(cases)


def test_the_command(cases, act, capsys, tmp_path):
    out = tmp_path / "elsewhere"
    words = ("blind", "run", str(cases), "--out", str(out), "--workers", "1", "--json", "--cases", "1-2,2")
    code, said, err = run_command(capsys, *words)
    assert code == 0
    assert json.loads(said) == {"cases": 2, "before": 0, "new": 2, "failed": {}}
    assert f"2 of 2 diagnoses are in {out}" in " ".join(err.split())
    act(stub.failing_in_two)
    code, said, err = run_command(capsys, *words[:-1], "2-4")
    assert code == 1
    assert set(json.loads(said)["failed"]) == {"case-0003", "case-0004"}
    assert "jaxstick: case-0003: The process that diagnosed it ended by SIGKILL." in err
    code, _, err = run_command(capsys, *words[:-1], "4-2")
    assert code == 2 and "'4-2' is no range" in err
    code, _, err = run_command(capsys, *words[:-1], "one")
    assert code == 2 and "neither a number nor a range" in err


def test_a_case_can_travel(cases, monkeypatch):
    seen = {}

    def noted(folder, seed):
        seen.update(name=folder.name, files=checksums(folder), seed=seed)
        return stub.Outcome("x", None)

    monkeypatch.setattr(case_work, "diagnose_folder", noted)
    case = cases / "case-0001"
    files = {path.name: path.read_bytes() for path in case.iterdir()}
    assert diagnose_sent("case-0001", files, 3, case_work.version()).diagnosis == "x"
    assert seen == {"name": "case-0001", "files": read_manifest(cases)["cases"]["case-0001"], "seed": 3}
    with pytest.raises(UserError, match=r"runs jaxstick .*, and this is 0\.0"):
        diagnose_sent("case-0001", files, 3, "0.0")


def test_on_a_cluster(cases, monkeypatch):
    distributed = pytest.importorskip("distributed")
    cluster = pytest.importorskip("fitting.blind_run.cluster")
    act = stub.failing_in_two

    def sent(name, files, seed, wanted):
        folder = cases / name
        assert (seed, wanted) == (7, case_work.version())
        assert files == {path.name: path.read_bytes() for path in folder.iterdir()}
        return stub.Outcome(None, "lost") if name == "case-0003" else act(folder, seed)

    monkeypatch.setattr(cluster, "diagnose_sent", sent)
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None, protocol="tcp"
    ) as here:
        found = ran(cases, seed=7, scheduler=here.scheduler_address)
    assert found.new == 1
    assert found.failed["case-0002"] == "The motion was lost."
    with pytest.raises(UserError, match="no Dask scheduler answers"):
        monkeypatch.setattr("jaxstick.sweeps.workers.PATIENCE", 0.3)
        ran(cases, seed=7, scheduler="tcp://127.0.0.1:1")
