"""The demonstration of it all."""

import json
from pathlib import Path

from sbam.cli import main


def test_demo(here, capsys) -> None:
    assert main(["demo", "--json", "demo.json"]) == 0
    report = json.loads(Path("demo.json").read_text())
    assert report["ok"] and report["plan"]["ok"]
    assert {"demonstrate", "learn", "plan", "write"} == report["seconds"].keys()
    written = {str(path) for path in Path("out/demo").rglob("*") if path.is_file()}
    assert written == set(report["files"])
    names = {Path(file).name for file in written}
    assert {"trajectory.npz", "trajectory.csv", "report.json", "model.json", "recording.html"} <= names
    said = capsys.readouterr().out
    for mentioned in ("recording.html", "plots/", "trajectory.csv", "report.json", "model.json"):
        assert f"out/demo/{mentioned}" in said
        assert Path("out/demo", mentioned).exists()
    assert len(said.splitlines()) < 12
