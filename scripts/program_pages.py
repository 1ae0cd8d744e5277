#!/usr/bin/env python3
"""Writes the manual page and the completion of bash, by what the program says of itself with --help.

    scripts/program_pages.py PROGRAM OUT     # OUT/scanmill.1, OUT/scanmill.bash
"""

import re
import subprocess
import sys
from pathlib import Path

INTRODUCTION = """\
Scanmill turns 3D scenes into labelled LiDAR datasets, offline, by ray tracing, through images of depth, or by distance
fields, and tells what each shortcut costs. A pipeline, a YAML file, says which scenes, ways, sensors and effects make a
dataset. Those that come with the program are known by their names, as its scenes, sensors and ontologies are: see
scanmill list."""

ENVIRONMENT = [
    ("SCANMILL_RESOURCES", "the folder that holds the program's own pipelines, scenes and labels"),
    ("SCANMILL_GL_DEVICE", "which graphics device the depth camera and particles use (0, 1 ... or software)"),
    ("SCANMILL_BLENDER", "the program that reads .blend files and renders passes; else the one of PATH"),
]
EXIT_STATUS = [("0", "done"), ("1", "work that failed"), ("2", "wrong usage or input"), ("128 + n", "stopped by signal n")]


def help_of(program: str, *command: str) -> str:
    return subprocess.run([program, *command, "--help"], check=True, capture_output=True, text=True).stdout


def commands_of(text: str) -> list[str]:
    """The names of the subcommands, by the lines of the program's own help."""
    return list(dict.fromkeys(re.findall(r"^  scanmill ([a-z-]+) +\S", text, re.MULTILINE)))


def options_of(text: str) -> list[str]:
    """-o and --out of lines such as "  -o, --out DIR   a folder"."""
    found = re.findall(r"^ +(?:(-\w), )?(--[a-z][a-z-]*)", text, re.MULTILINE)
    return list(dict.fromkeys(option for pair in found for option in pair if option))


def escaped(text: str) -> str:
    """Text for troff: backslashes and hyphens as they are, and no line that it takes for an order."""
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq")
    return re.sub(r"^\.", r"\\&.", text, flags=re.MULTILINE)


def literal(text: str) -> str:
    return ".nf\n" + escaped(text.strip("\n")) + "\n.fi\n"


def manual_page(program: str) -> str:
    whole = help_of(program)
    version, summary = re.match(r"scanmill ([\d.]+): (.*)", whole).groups()
    page = f'.TH SCANMILL 1 "" "scanmill {version}" "User commands"\n'
    page += f".SH NAME\nscanmill \\- {escaped(summary)}\n.SH SYNOPSIS\n.B scanmill\n.I COMMAND\n[\\fIOPTION\\fR...]\n"
    page += f".SH DESCRIPTION\n{escaped(INTRODUCTION)}\n.SH COMMANDS\n"
    for command in commands_of(whole):
        page += f".SS scanmill {escaped(command)}\n" + literal(help_of(program, command))
    for title, rows in (("ENVIRONMENT", ENVIRONMENT), ("EXIT STATUS", EXIT_STATUS)):
        page += f".SH {title}\n" + "".join(f".TP\n.B {escaped(name)}\n{escaped(text)}\n" for name, text in rows)
    page += ".SH FILES\n" + escaped("share/scanmill beside the program's folder: pipelines, scenes, labels") + "\n"
    return page


COMPLETION = """\
# Completion of bash for scanmill: commands, then their options and files.
_scanmill() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} options
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W "{commands} --help --version" -- "$word"))
    return
  fi
  case ${{COMP_WORDS[1]}} in
{cases}
    *) options= ;;
  esac
  case $before in
    --to) COMPREPLY=($(compgen -W "{layouts}" -- "$word")); return ;;
  esac
  case $word in
    -*) COMPREPLY=($(compgen -W "$options" -- "$word")) ;;
    *) COMPREPLY=($(compgen -f -- "$word")) ;;
  esac
}}
complete -o filenames -F _scanmill scanmill
"""


def completion(program: str) -> str:
    commands = commands_of(help_of(program))
    helps = {command: help_of(program, command) for command in commands}
    cases = "\n".join(f'    {name}) options="{" ".join(options_of(text))}" ;;' for name, text in helps.items())
    layouts = re.search(r"--to LAYOUT +((?:[a-z_0-9]+, )*[a-z_0-9]+)", helps["export"]).group(1).replace(", ", " ")
    return COMPLETION.format(commands=" ".join(commands), cases=cases, layouts=layouts)


def main() -> None:
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    program, folder = sys.argv[1], Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in (("scanmill.1", manual_page(program)), ("scanmill.bash", completion(program))):
        (folder / f"{name}.partial").write_text(text)
        (folder / f"{name}.partial").rename(folder / name)


if __name__ == "__main__":
    main()
