"""The tutorial and the page of the command line are true."""

import re
import shlex
from pathlib import Path

import pytest

from sbam.cli import main

DOCUMENTATION = Path(__file__).parents[1] / "docs"


def blocks(page: str, language: str) -> list[str]:
    text = (DOCUMENTATION / page).read_text(encoding="utf-8")
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


def test_the_commands_of_the_tutorial_work_one_after_the_other(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    (scene,) = blocks("tutorial.md", "yaml")
    Path("my_scene.yaml").write_text(scene)
    commands = [shlex.split(line) for block in blocks("tutorial.md", "sh") for line in block.splitlines()]
    assert len(commands) >= 8
    for program, *arguments in commands:
        assert program == "sbam"
        assert main(arguments) == 0, (arguments, capsys.readouterr().err)
    for written in ("trajectory.npz", "trajectory.csv", "report.json", "recording.html"):
        assert Path("out/mine", written).is_file()

    (program,) = blocks("tutorial.md", "python")
    exec(compile(program, "tutorial.md", "exec"), {})
    assert "ready" in capsys.readouterr().out


def test_every_option_is_on_the_page_of_the_command_line(capsys) -> None:
    synopses = [block for block in blocks("command_line.md", "text") if block.startswith("sbam ")]
    lines = [line for block in synopses for line in re.split(r"\n(?=sbam )", block)]
    described = {}
    for line in lines:
        words = line.split()
        verb = tuple(words[1:3] if words[2:] and words[2].islower() and words[2].isalpha() else words[1:2])
        named = set(re.findall(r"--[a-z-]+|(?<=\s|\[)-o", line)) - {"-o"}
        described[verb] = described.get(verb, set()) | named
    groups = ("recordings", "scenes", "robots")
    for verb, options in described.items():
        with pytest.raises(SystemExit) as ended:
            main([*verb, "--help"])
        assert ended.value.code == 0
        usage = capsys.readouterr().out
        known = set(re.findall(r"(?<!-)--[a-z]+(?:-[a-z]+)*\b", usage)) - {"--help", "--json", "--output"}
        assert options == known, verb
    with pytest.raises(SystemExit):
        main(["--help"])
    listed = set(re.findall(r"• ([a-z]+)", capsys.readouterr().out))
    assert {verb[0] for verb in described} == listed
    assert all(len(verb) == 2 for verb in described if verb[0] in groups)


def test_the_program_of_the_readme_works(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    text = (DOCUMENTATION.parent / "README.md").read_text(encoding="utf-8")
    (program,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    exec(compile(program, "README.md", "exec"), {})
    assert "checks passed" in capsys.readouterr().out
    assert {path.name for path in Path("out").iterdir()} >= {"trajectory.npz", "trajectory.csv", "recording.html"}


def test_the_readme_points_to_what_is_there() -> None:
    repository = DOCUMENTATION.parent
    text = (repository / "README.md").read_text(encoding="utf-8")
    links = [link for link in re.findall(r"\]\(([^)#]+)", text) if "://" not in link]
    assert links
    assert [link for link in links if not (repository / link).exists()] == []
